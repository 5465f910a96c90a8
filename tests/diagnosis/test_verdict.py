"""The verdict's rules."""

from dataclasses import replace

import pytest

from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.settings import Limits, Settings
from rwjax.diagnosis.verdict import closes_in_part, judge, left_elsewhere, stands_out, verdict

LIMITS = Limits()


def test_a_search_that_was_ended_claims_nothing() -> None:
    gap = Gap(5.0, 1.1, 1.0, 0.97, (0.95, 1.0), 1.0)
    rival = (Hypothesis(("drive.bias",)),)
    for choice in (chosen("axis.coulomb"), chosen("axis.coulomb", alternatives=rival), chosen()):
        assert judge(replace(choice, complete=False), {"yaw_rad": gap}, "yaw_rad", LIMITS) == "unknown"
        nothing = {"yaw_rad": Gap(1.0, 1.0, 1.0, None, None, None)}
        assert judge(replace(choice, complete=False), nothing, "yaw_rad", LIMITS) == "unknown"


def chosen(*names: str, alternatives: tuple[Hypothesis, ...] = ()) -> Choice:
    return Choice(Hypothesis(names), alternatives)


@pytest.mark.parametrize(
    ("choice", "gap", "outcome"),
    [
        (chosen(), Gap(1.0, 1.0, 1.0, None, None, None), "none"),
        (chosen(), Gap(1.2, 1.2, 1.0, 0.0, (0.0, 0.0), 0.0), "none"),
        (chosen(), Gap(5.0, 5.0, 1.0, 0.0, (0.0, 0.0), 0.0), "unknown"),
        (chosen("axis.coulomb"), Gap(5.0, 1.1, 1.0, 0.97, (0.95, 1.0), 1.0), "effect"),
        (chosen("axis.coulomb"), Gap(5.0, 3.0, 1.0, 0.5, (0.4, 0.6), 0.6), "unknown"),
        (chosen("axis.coulomb"), Gap(21.0, 4.0, 1.0, 0.85, (0.8, 0.9), 0.9), "unknown"),  # a visible part is left
        (chosen("axis.coulomb"), Gap(81.0, 4.0, 1.0, 0.9625, (0.95, 0.97), 0.97), "unknown"),  # … however small a share
        (chosen("axis.coulomb"), Gap(7.0, 1.9, 1.0, 0.85, (0.8, 0.9), 0.9), "effect"),
        (chosen("axis.coulomb", "drive.lag"), Gap(21.0, 4.0, 1.0, 0.85, (0.8, 0.9), 0.9), "unknown"),
        (chosen("axis.coulomb", "drive.lag"), Gap(21.0, 1.2, 1.0, 0.93, (0.9, 0.95), 0.95), "effect"),
        # hardly anything is closed: no name, however wide the interval
        (chosen("axis.coulomb"), Gap(5.0, 4.6, 1.0, 0.1, (-1.0, 0.85), 0.85), "unknown"),
        (
            chosen("axis.coulomb", alternatives=(Hypothesis(("wheel.coulomb",)),)),
            Gap(5.0, 1.1, 1.0, 0.97, (0.95, 1.0), 1.0),
            "ambiguous",
        ),
    ],
)
def test_the_outcomes_of_a_search(choice: Choice, gap: Gap, outcome: str) -> None:
    assert judge(choice, {"yaw_rad": gap}, "yaw_rad", LIMITS) == outcome


@pytest.mark.parametrize(
    ("other", "outcome"),
    [
        (Gap(1.0, 1.0, 1.0, None, None, None), "effect"),
        (Gap(9.0, 1.9, 1.0, 0.9, None, None), "effect"),
        (Gap(9.0, 2.1, 1.0, 0.9, None, None), "unknown"),
        (Gap(4.0, 4.0, 1.0, 0.0, None, None), "unknown"),  # which the names do not touch
    ],
)
def test_no_name_is_the_whole_answer_beside_another_output_that_keeps_a_visible_part(other: Gap, outcome: str) -> None:
    gaps = {"yaw_rad": Gap(5.0, 1.1, 1.0, 0.97, (0.95, 1.0), 1.0), "current_A": other}
    assert judge(chosen("axis.coulomb"), gaps, "yaw_rad", LIMITS) == outcome
    assert left_elsewhere(gaps, "yaw_rad", LIMITS) == (None if outcome == "effect" else "current_A")
    both = gaps | {"yaw_rad": Gap(9.0, 3.0, 1.0, 0.75, None, None)}
    assert left_elsewhere(both, "yaw_rad", LIMITS) is None  # the headline itself keeps a part, which is what is told


def test_other_limits_give_another_outcome() -> None:
    gap = Gap(5.0, 3.0, 1.0, 0.5, (0.4, 0.6), 0.6)
    assert verdict(1, False, gap, LIMITS) == "unknown"
    assert verdict(1, False, gap, replace(LIMITS, barely=0.5, explained=0.5, doubt=3.0)) == "effect"
    assert verdict(1, False, gap, replace(LIMITS, at_floor=3.0, doubt=3.0)) == "effect"
    assert verdict(0, False, gap, replace(LIMITS, doubt=10.0)) == "none" != verdict(0, False, gap, LIMITS)


def test_names_that_hold_have_to_close_half_of_the_gap() -> None:
    assert closes_in_part(Gap(5.0, 3.0, 1.0, 0.5, None, None), Settings(), followed=False)
    assert not closes_in_part(Gap(5.0, 3.1, 1.0, 0.475, None, None), Settings(), followed=False)
    assert not closes_in_part(Gap(1.0, 1.0, 1.0, None, None, None), Settings(), followed=False)
    assert closes_in_part(Gap(5.0, 2.0, 1.0, 0.75, None, None), Settings(), followed=True)
    assert not closes_in_part(Gap(5.0, 2.1, 1.0, 0.725, None, None), Settings(), followed=True)


def test_a_gap_stands_out_where_it_is_a_floor_above_its_floor() -> None:
    assert not stands_out(Gap(1.0, 1.0, 1.0, None, None, None), LIMITS)
    assert not stands_out(Gap(1.4, 1.4, 1.0, 0.0, None, None), LIMITS)
    assert stands_out(Gap(1.42, 1.42, 1.0, 0.0, None, None), LIMITS)
    assert not stands_out(Gap(1.42, 1.42, 1.0, 0.0, None, None), replace(LIMITS, nothing=2.0))
