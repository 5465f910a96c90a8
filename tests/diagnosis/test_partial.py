"""Partial: names that hold beside something that no effect explains, and imitations that do not."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import Hypothesis, coordinate_of
from rwjax.diagnosis.partial import claimed, further_laws, why_not_held
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.settings import PartialSettings, Settings
from tests.diagnosis.several_runs import run_of, searched

DRY, BIAS, OFFSET, SPRING = (
    Hypothesis((name,)) for name in ("axis.coulomb", "axis.bias_torque", "drive.bias", "axis.spring")
)
FRICTION = {"axis.coulomb": {"M_c": 0.06}}
PUSHED = {"axis.bias_torque": {"T": 0.02}}


def test_a_true_name_holds_beside_a_motion_that_nothing_explains() -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY, BIAS, SPRING)
    assert search.comparison.excess(DRY) > 100.0  # far from the noise
    claim = claimed(search, Choice(DRY))
    assert claim is not None and claim.named == DRY and claim.alternatives == ()


def test_a_name_of_which_every_run_asks_for_another_amount_does_not_hold() -> None:
    logs = [run_of(k, {"axis.bias_torque": {"T": torque}}) for k, torque in enumerate((0.02, 0.02, 0.08))]
    search = searched(logs, BIAS, SPRING)
    search.fits.settings = replace(Settings(), partial=PartialSettings(needed=0.0))
    why = why_not_held(search.fits, BIAS, "axis.bias_torque")
    assert why == "some runs or sizes of the command do not tell how much of it they ask for"
    assert claimed(search, Choice(BIAS)) is None


def test_one_run_is_too_few_to_say_that_every_run_agrees() -> None:
    search = searched([run_of(0, PUSHED)], BIAS, SPRING)
    assert why_not_held(search.fits, BIAS, "axis.bias_torque") == "too few runs tell whether it is the same in each"


def test_of_a_set_the_names_stay_that_hold() -> None:
    both = DRY.plus("axis.spring")  # of which there is none; three random walks happen to look a little like it
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY, both)
    assert (
        why_not_held(search.fits, both, "axis.spring") == "it is not needed beside a remainder that is coloured noise"
    )
    claim = claimed(search, Choice(both))
    assert claim is not None and claim.named == DRY


def test_what_leaves_as_much_stands_beside_the_name_and_many_such_leave_nothing_to_claim() -> None:
    search = searched([run_of(k, PUSHED, disturbed=0.03) for k in range(3)], BIAS, OFFSET, DRY)
    claim = claimed(search, Choice(BIAS))
    assert claim is not None and claim.named == BIAS and claim.alternatives == (OFFSET,)
    fits = search.fits
    fits.settings = replace(Settings(), partial=PartialSettings(as_much=1e9, alternatives=1))
    assert claimed(search, Choice(BIAS)) is None


def test_a_name_that_leaves_something_of_its_own_coordinate_has_not_the_right_form() -> None:
    truth = {"axis.quadratic_drag": {"c": 0.04}}
    linear, drag = Hypothesis(("parameter.axis.friction.viscous",)), Hypothesis(("axis.quadratic_drag",))
    search = searched(
        [run_of(k, truth) for k in range(3)], linear, drag, BIAS, linear.plus(*drag.names), linear.plus(*BIAS.names)
    )
    laws = further_laws(search.fits, linear)
    assert laws["yaw_rate"] > 0.9 > laws[coordinate_of("axis.bias_torque")]
    search.fits.settings = replace(Settings(), partial=PartialSettings(law_left=np.inf))
    assert (
        why_not_held(search.fits, linear, linear.names[0])
        == "a further law of its coordinate removes part of what it leaves"
    )
    search.fits.settings = replace(Settings(), partial=PartialSettings(law_left=np.inf, further_law=1.0))
    assert (
        why_not_held(search.fits, linear, linear.names[0])
        == "what it leaves is nearest to a further law of its own coordinate"
    )
    assert further_laws(search.fits, drag) == {}  # which leaves nothing


def test_where_a_set_reaches_the_noise_the_evidence_says_what_stands_beside_it() -> None:
    search = searched([run_of(k, PUSHED) for k in range(3)], BIAS, DRY)
    assert search.comparison.excess(BIAS) < 0.1
    assert claimed(search, Choice(BIAS, (OFFSET,), (OFFSET,))) == (BIAS, (OFFSET,), (OFFSET,))


@pytest.mark.parametrize("limits", [PartialSettings(differs=0.0, sigmas=0.0), PartialSettings(harms=0.0)])
def test_stricter_limits_let_nothing_hold(limits: PartialSettings) -> None:
    search = searched([run_of(k, FRICTION) for k in range(3)], DRY, BIAS)
    assert why_not_held(search.fits, DRY, "axis.coulomb") is None
    search.fits.settings = replace(Settings(), partial=limits)
    assert why_not_held(search.fits, DRY, "axis.coulomb") is not None
