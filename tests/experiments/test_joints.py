"""The campaign on joints: its table, and a slice of it."""

import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.joints.draw import SORTS
from experiments.joints.run import answer, rigs, table


def line(sort: str, seed: int, low: float) -> dict:
    number = {"true": 2.0, "value": 2.0, "error": 0.1, "interval": [low, 2.2]}
    row = {"sort": sort, "seed": seed, "seconds": 3.0 + seed, "misfit": 1.0}
    return row | {"numbers": {"axis.inertia": number}}


def test_the_table_counts_by_command_and_number() -> None:
    lines = [line("goal", k, 1.8 if k else 2.1) for k in range(40)]
    text = table([*lines, {"sort": "duty", "seed": 3, "failed": "ValueError()"}])
    assert "| goal | axis.inertia | 40 | 97.5 %" in text
    assert "goal: 40 fits, 22.5 s each (most 42)" in text
    assert text.endswith("duty 3 failed: ValueError()")


def test_the_sorts_of_a_campaign_take_turns() -> None:
    assert [row["sort"] for row in rigs(2, list(SORTS))] == [*SORTS, *SORTS]
    assert len({row["index"] for row in rigs(3, list(SORTS))}) == 12


@pytest.mark.slow
@pytest.mark.parametrize("sort", SORTS)
def test_a_fit_finds_the_numbers_of_a_drawn_joint(sort: str) -> None:
    found = answer(rigs(1, [sort])[0])
    assert found["misfit"] < 1.2
    for number in found["numbers"].values():
        assert abs(number["value"] - number["true"]) < 4.0 * number["error"]
