"""Equivalents: what is the same thing for a kind of rig, whatever the logs."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import Hypothesis, candidates
from rwjax.diagnosis.search.equivalents import equivalents
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from tests.diagnosis.simulated import COMMAND, TIME, fits_of, true_log
from tests.systems import platform, record, run, wheel


def test_declared_equivalents_of_a_bias_on_a_platform() -> None:
    rig = platform("viscous = 0.02")
    best = Hypothesis(("axis.bias_torque", "axis.coulomb"))
    same = equivalents(fits_of(rig, true_log(rig)), candidates(rig), best)
    assert {frozenset(e.names) for e in same} == {
        frozenset({"axis.asymmetric_friction"}),
        frozenset({"drive.bias", "axis.coulomb"}),
    }


def test_of_a_set_that_was_not_fitted_none_is_told_by_its_numbers() -> None:
    rig, motor = platform("viscous = 0.02"), wheel()
    curved, wrong = Hypothesis(("axis.coulomb", "drive.curvature")), Hypothesis(("parameter.motor.resistance",))
    assert equivalents(fits_of(rig, true_log(rig)), candidates(rig), curved) == []
    still = record(TIME, COMMAND, {"wheel_rad_s": np.zeros_like(TIME)})
    assert equivalents(fits_of(motor, still), candidates(motor), wrong) == []


@pytest.mark.parametrize(("c", "same"), [(-0.1, [("drive.supply_sag",)]), (0.1, [])])
@pytest.mark.slow
def test_on_a_platform_a_gain_that_falls_may_be_a_supply_that_sags(c: float, same: list[tuple[str, ...]]) -> None:
    rig, curved = platform("viscous = 0.02"), Hypothesis(("drive.curvature",))
    fits = fits_of(rig, true_log(rig, **{"drive.curvature": {"c": c}}))
    SuccessiveHalving(fits).fit([curved], Hypothesis())
    assert [e.names for e in equivalents(fits, candidates(rig), curved)] == same


@pytest.mark.parametrize(("factor", "same"), [(1.2, [("drive.supply_sag",)]), (0.8, [])])
def test_a_winding_of_more_resistance_may_be_a_source_in_series_and_one_of_less_may_not(
    factor: float, same: list[tuple[str, ...]]
) -> None:
    rig, wrong = wheel(), Hypothesis(("parameter.motor.resistance",))
    true = replace(rig, numbers=rig.numbers | {"motor.resistance": factor * rig.numbers["motor.resistance"]})
    asked = record(TIME, 4.0 * COMMAND, {name: np.zeros_like(TIME) for name in ("wheel_rad_s", "current_A")})
    noise = np.random.default_rng(0)
    y = {name: v + noise.normal(0.0, 0.01, len(v)) for name, v in run(true, asked, {}).items() if name in asked.outputs}
    fits = fits_of(rig, record(TIME, 4.0 * COMMAND, y))
    SuccessiveHalving(fits).fit([wrong], Hypothesis())
    assert [e.names for e in equivalents(fits, candidates(rig), wrong)] == same
