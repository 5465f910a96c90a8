"""Where: the missing torque against what was planted and against nothing."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, parse_rig
from rwjax.diagnosis.localise.body_motion import read_body
from rwjax.diagnosis.localise.where import Missing, locate, missing_torque, tells_torque
from rwjax.diagnosis.settings import LocalisationSettings
from rwjax.fitting.fit import fit
from rwjax.fitting.prediction import every_output
from rwjax.plant.from_rig import structure_of
from rwjax.rig.model import Rig
from tests.diagnosis.localise.measured import as_given
from tests.diagnosis.simulated import true_log
from tests.systems import platform

SETTINGS = LocalisationSettings()


def missing(rig: Rig, fitted_to: Log, log: Log) -> Missing:
    """Missing torque of a log on a rig that was fitted to another one."""
    fitted = fit(rig, [fitted_to]).fit
    fitted = replace(fitted, problem=replace(fitted.problem, logs=(log,)))
    read = read_body(fitted, 0, "yaw", SETTINGS)
    assert read is not None
    return missing_torque(fitted, 0, every_output(fitted.problem, fitted.theta, fitted.start)[0], read, SETTINGS)


@pytest.mark.slow
def test_a_true_rig_misses_no_torque_whatever_it_models() -> None:
    rig = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02\ncoulomb = 0.05\n'
        'static = 0.12\nstribeck_velocity = 0.3\n[effects."axis.bias_torque"]\nT = 0.03\n[fit]\nfree = ["axis.inertia"]'
    )
    log = true_log(rig)
    found = missing(rig, log, log)
    bent = np.abs(found.torque) > 4.0 * found.deviation
    assert np.mean(bent) < 0.12  # the smoother cannot follow the instants of stick and slip
    rate = np.abs(found.coordinates["yaw_rate"])
    for low, high in ((0.1, 0.4), (0.4, 1.0), (1.0, 2.0)):
        assert abs(np.median(found.torque[(rate > low) & (rate < high)])) < 0.01  # bias and Stribeck are ten times that


def test_a_missing_bias_is_read_off_at_its_size() -> None:
    rig = platform()
    log = true_log(rig, **{"axis.bias_torque": {"T": 0.03}})
    found = missing(rig, true_log(rig), log)
    sliding = np.abs(found.coordinates["yaw_rate"]) > 0.3
    assert np.median(found.torque[sliding]) == pytest.approx(0.03, rel=0.15)


def test_what_is_named_is_where_the_gap_lies_and_else_what_removes_most() -> None:
    rig, shares = platform("viscous = 0.02"), {"yaw": 0.2, "yaw_rate": 0.7}
    fitted = as_given(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.03}}))
    found = locate(fitted, (0,), shares, None, SETTINGS, deep=False)
    assert found is not None and found.coordinate == found.drawn == "yaw_rate" and found.share == 0.7
    assert not found.regimes and not found.bands and found.momentum is None and found.interval is not None
    assert found.json() == {"shares": shares, "regimes": [], "bands": [], "momentum": None}
    named = locate(fitted, (0,), shares, "load", SETTINGS, deep=False)
    assert named is not None and named.coordinate == "load" and named.share == 0.0 and named.interval is None
    assert named.drawn == "voltage"
    assert locate(fitted, (0,), {}, None, SETTINGS) is None


def test_what_a_run_carries_besides_is_part_of_the_inertia() -> None:
    rig = platform("viscous = 0.02")
    heavy = replace(rig, numbers=rig.numbers | {"axis.inertia": 2.0 * rig.numbers["axis.inertia"]})
    log = replace(
        true_log(heavy, **{"axis.bias_torque": {"T": 0.03}}), added={"axis.inertia": rig.numbers["axis.inertia"]}
    )
    found = missing(rig, true_log(rig), log)
    assert np.median(found.torque[np.abs(found.coordinates["yaw_rate"]) > 0.3]) == pytest.approx(0.03, rel=0.15)


def test_where_the_motion_hides_the_torque_no_range_is_read_off() -> None:
    rig = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02\n'
        '[effects."drive.lag"]\nT = 0.05\n[fit]\nfree = ["axis.inertia"]'
    )
    found = locate(as_given(rig, true_log(rig)), (0,), {"yaw_rate": 0.7}, None, SETTINGS)
    assert found is not None and found.coordinate == "yaw_rate" and found.drawn is None and found.interval is None
    assert not found.regimes and not found.missing


def test_readings_without_a_sign_hide_the_torque() -> None:
    structure = structure_of(platform("viscous = 0.02"))
    assert tells_torque(structure) and not tells_torque(structure._replace(unsigned=("yaw_rad_s",)))
