"""The corrected rig: the rig file with what is named."""

import pytest

from rwjax import parse_rig, write_rig
from rwjax.diagnosis.corrected_rig import corrected_rig
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.search.successive_halving import fitted
from rwjax.fitting.uncertainty import uncertainty
from tests.diagnosis.simulated import fits_of, true_log
from tests.systems import platform


def test_the_corrected_rig_has_the_effect_at_its_estimates_and_can_be_read_again() -> None:
    rig, named = platform("viscous = 0.02"), Hypothesis(("axis.bias_torque",))
    found = fitted(fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.03}})), named)
    corrected = corrected_rig(rig, named, found, uncertainty(found))
    assert corrected.effects["axis.bias_torque"]["T"] == pytest.approx(0.03, rel=0.05)
    assert corrected.free == (*rig.free, "axis.bias_torque.T")
    assert corrected.numbers["drive.gain"] == rig.numbers["drive.gain"]
    again = parse_rig(write_rig(corrected))
    assert again.free == corrected.free and {*again.effects} == {"axis.bias_torque"}


def test_other_effects_of_the_same_program_stay_out_of_it() -> None:
    rig = platform("viscous = 0.02")
    found = fits_of(rig, true_log(rig))(Hypothesis())
    corrected = corrected_rig(rig, Hypothesis(), found, uncertainty(found))
    assert corrected.effects == {} and corrected.free == rig.free
