"""Judged: held-out errors, each worked out once."""

import pytest

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.judged import Judged, errors_of_the_rig
from rwjax.diagnosis.layout import laid_out
from rwjax.diagnosis.model_fits import ModelFits
from tests.diagnosis.several_runs import RIG, run_of

DRY, PUSHED = (Hypothesis((name,)) for name in ("axis.coulomb", "axis.bias_torque"))


def judged() -> Judged:
    """Three runs with dry friction, of which the rig has none."""
    layout = laid_out(RIG, [run_of(k, {"axis.coulomb": {"M_c": 0.06}}) for k in range(3)])
    fits = ModelFits.of(RIG, layout.logs, layout.train)
    fits(NOTHING)
    return Judged(fits, layout, errors_of_the_rig(fits, layout), "yaw_rad")


def test_the_errors_of_a_hypothesis_are_worked_out_once_and_fitted_where_no_search_has_begun_it() -> None:
    found = judged()
    assert DRY not in found.fits
    errors = found(DRY)
    assert found(DRY) is errors and found(NOTHING) is found.before
    assert found.rms(DRY) < 0.05 * found.rms(NOTHING) and found.gap_of(DRY).closed > 0.95
    assert found.gaps(errors)["yaw_rad"] == found.gap_of(DRY)
    assert found.rung(DRY).rms == found.rms(DRY)


@pytest.mark.slow
def test_prepared_side_by_side_they_are_those_of_one_after_the_other() -> None:
    together, alone = judged(), judged()
    together.prepare([DRY, NOTHING, PUSHED])
    assert [together.rms(e) for e in (DRY, PUSHED)] == [alone.rms(e) for e in (DRY, PUSHED)]


def test_after_a_search_everything_is_worked_out_anew() -> None:
    found = judged()
    errors = found(DRY)
    again = found.anew()
    assert again.fits is found.fits and again(DRY) is not errors and again.rms(DRY) == found.rms(DRY)
    now = errors_of_the_rig(found.fits, found.layout).rms("yaw_rad")  # its fit has changed beside the other
    assert again.before.rms("yaw_rad") == now != found.before.rms("yaw_rad")
