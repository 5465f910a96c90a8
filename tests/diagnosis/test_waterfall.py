"""The waterfall: numbers with their errors, and how far they move."""

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.search.successive_halving import fitted
from rwjax.diagnosis.waterfall import rung
from rwjax.fitting.uncertainty import uncertainty
from tests.diagnosis.simulated import fits_of, true_log
from tests.systems import platform


def test_a_step_tells_the_rig_s_numbers_their_shift_and_the_effect_s_numbers() -> None:
    rig, named = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",))
    fits = fits_of(rig, true_log(rig, **{"axis.coulomb": {"M_c": 0.03}}))
    first = rung(rig, (), fits(Hypothesis()), 0.5)
    assert first.drift == {"axis.inertia": (0.0, 0.0)} and not first.own and first.rms == 0.5
    found = fitted(fits, named)
    second = rung(rig, named.names, found, 0.1, first.numbers)
    (before, error), (after, new_error) = first.numbers["axis.inertia"], second.numbers["axis.inertia"]
    assert after == pytest.approx(0.1, rel=0.01) and new_error == uncertainty(found).standard_error["axis.inertia"]
    sigmas, percent = second.drift["axis.inertia"]
    assert percent == pytest.approx(100.0 * (after - before) / before)
    assert sigmas == pytest.approx((after - before) / np.hypot(error, new_error))
    assert {*second.own} == {"axis.coulomb.M_c"} and second.own["axis.coulomb.M_c"][0] == pytest.approx(0.03, rel=0.05)


def test_a_number_that_was_nothing_shifts_by_no_percentage() -> None:
    rig = platform()
    found = fits_of(rig, true_log(rig))(Hypothesis())
    sigmas, percent = rung(rig, (), found, 0.1, {"axis.inertia": (0.0, np.inf)}).drift["axis.inertia"]
    assert np.isnan(percent) and np.isnan(sigmas)
