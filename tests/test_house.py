"""The rules of this project's code, room by room: what `python -m experiments.house --list` prints must be nothing."""

from functools import cache
from pathlib import Path

import pytest

from experiments.house.rules import RULES
from experiments.house.tree import Finding, Tree

TREE = Tree(Path(__file__).parents[1])
ROOMS = sorted(
    {path.parent.name for path in (TREE.root / "rwjax").glob("*/__init__.py")} | {"root", "firmware", "experiments"}
)


@cache
def breaches(rule: str) -> tuple[Finding, ...]:
    """Every breach of a rule, found once for all rooms."""
    return tuple(RULES[rule](TREE))


@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.parametrize("rule", RULES)
def test_rule(rule: str, room: str) -> None:
    assert [f"{f.path}:{f.line}: {f.what}" for f in breaches(rule) if f.room == room] == []


@pytest.mark.parametrize("rule", RULES)
def test_every_breach_lies_in_a_room_that_is_tested(rule: str) -> None:
    assert {f.room for f in breaches(rule)} <= set(ROOMS)
