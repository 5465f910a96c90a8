"""Mutants are other programs, one small mistake away, and what says nothing of the program stays as it is."""

from experiments.mutants.__main__ import GROUPS, ROOT, mirrored
from experiments.mutants.mutations import mutants

SOURCE = '''"""Nothing here < changes."""

from typing import TYPE_CHECKING


def least(values: "list[float]", over: float = 2.0) -> float:
    """The least value > over."""
    found = [v for v in values if v >= over]
    if not found:
        raise ValueError(f"no value above {over:.3g}")
    return min(found, key=abs) - values[0]
'''
CHANGES = {
    (6, "2.0 -> 2.2"),
    (8, "v >= over -> v > over"),
    (8, "v >= over -> v < over"),
    (9, "not found -> found"),
    (10, "raise ValueError(f'no value above {over:.3g}') -> pass"),
    (11, "return min(found, key=abs) - values[0] -> return None"),
    (11, "min(found, key=abs) - values[0] -> min(found, key=abs) + values[0]"),
    (11, "min(found, key=abs) -> min(found)"),
    (11, "0 -> 1"),
}


def test_each_small_mistake_is_made_once_and_in_code_alone() -> None:
    found = mutants("least.py", SOURCE)
    assert sorted((mutant.line, mutant.change) for mutant in found) == sorted(CHANGES)
    assert len({SOURCE, *(mutant.source for mutant in found)}) == len(found) + 1
    for mutant in found:
        assert "Nothing here < changes." in mutant.source and "The least value > over." in mutant.source


def test_every_module_that_is_tried_has_tests_of_its_own() -> None:
    for group, patterns in GROUPS.items():
        paths = [path.relative_to(ROOT).as_posix() for pattern in patterns for path in ROOT.glob(pattern)]
        assert paths, group
        for path in paths:
            assert path.endswith("__init__.py") or (ROOT / mirrored(path)).exists(), path
