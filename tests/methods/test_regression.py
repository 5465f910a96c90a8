"""Regression: known numbers come back, delays are refused."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import RigError
from rwjax.methods.regression import equation_error, weak_form
from rwjax.rig.read import parse_rig
from tests.joints import joint, logged, servo
from tests.methods.known_numbers import (
    Method,
    finds_a_wheel,
    finds_an_axis,
    finds_an_effect_on_the_command,
    refuses_a_delay,
)
from tests.systems import platform, record, run


# what each is known for: the weak form loses what lies near standstill, filtered accelerations are biased
@pytest.mark.parametrize(("method", "within"), [(weak_form, 0.05), (equation_error, 0.25)])
def test_known_numbers_of_an_axis_come_back(method: Method, within: float) -> None:
    finds_an_axis(method, within)


def test_known_numbers_of_a_wheel_come_back() -> None:
    finds_a_wheel(weak_form, 0.05)


def test_an_effect_on_the_command_is_estimated() -> None:
    finds_an_effect_on_the_command(weak_form, 0.1)


@pytest.mark.parametrize("method", [weak_form, equation_error])
def test_a_method_that_knows_no_delay_says_so(method: Method) -> None:
    refuses_a_delay(method)


T = np.arange(1001) * 0.01
VOLTS = np.where(T > 0.5, 3.0 * np.sign(np.sin(1.7 * T)) + 2.0 * np.sin(5.0 * T), 0.0)
PLAIN = joint(axis__friction__coulomb=0.05, axis__gravity__torque=0.3)
DRIVEN = {
    "voltage": (PLAIN, {"voltage_V": VOLTS}),
    "off": (joint(motor__inductance=5e-3), {"voltage_V": VOLTS, "enabled": ((T % 4.0) < 2.5).astype(float)}),
    "duty": (PLAIN, {"duty": VOLTS / 8.0, "supply_V": np.full(len(T), 8.0)}),
    "current": (PLAIN, {"command_A": 0.1 * VOLTS}),
    "torque": (PLAIN, {"command_Nm": 0.2 * VOLTS}),
    "goal": (servo(PLAIN, kp=2.0, period=0.01), {"goal_rad": 0.6 * np.sin(2.0 * T) + 0.4 * np.sin(7.0 * T)}),
}


@pytest.mark.slow
@pytest.mark.parametrize("by", DRIVEN)
def test_a_joint_is_told_however_it_is_driven(by: str) -> None:
    """The link has 0.01 kg m2, and the motor behind its gear as much again, which is known."""
    rig, columns = DRIVEN[by]
    rig = replace(rig, free=("axis.inertia", "axis.friction.viscous"))
    found = weak_form(
        rig.with_values({"axis.inertia": 0.015, "axis.friction.viscous": 0.03}), [logged(rig, T, **columns)]
    )
    assert found.rig.values["axis.inertia"] == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize(
    ("m", "free", "refused"),
    [(0.0, "rho", False), (0.0, "m", True), (0.6, "rho", True)],
    ids=["at once", "free", "late"],
)
def test_a_state_that_no_reading_tells_is_refused_where_it_acts(m: float, free: str, refused: bool) -> None:
    rig = replace(platform("viscous = 0.02"), effects={"drive.supply_sag": {"rho": 0.05, "m": m, "tau": 1.0}})
    outputs = run(rig, record(T, VOLTS, {"yaw_rad": np.zeros(len(T))}), {})
    log = record(T, VOLTS, {"yaw_rad": outputs["yaw_rad"]})
    rig = replace(rig, free=(f"drive.supply_sag.{free}",))
    if refused:
        with pytest.raises(RigError, match="has drive.supply_sag, whose own state bends the motion"):
            weak_form(rig, [log])
    else:
        assert weak_form(rig, [log]).rig.values["drive.supply_sag.rho"] == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize(
    ("inductance", "c", "free", "logged_too", "refused"),
    [
        (5e-3, 0.02, "motor.torque_constant", (), True),
        (5e-3, 0.02, "motor.torque_constant", ("current_A",), False),
        (5e-3, 0.0, "motor.torque_constant", (), False),
        (5e-3, 0.0, "motor.heating.c", (), True),
        (0.0, 0.02, "motor.torque_constant", (), True),
        (0.0, 0.0, "motor.torque_constant", (), False),
    ],
    ids=["not logged", "logged", "cold", "free", "at once", "at once, cold"],
)
def test_a_winding_that_warms_is_refused_where_it_warms_and_bends_the_current_that_is_not_logged(
    inductance: float, c: float, free: str, logged_too: tuple[str, ...], refused: bool
) -> None:
    rig = parse_rig(
        'kind = "wheel"\n[motor]\ntorque_constant = 0.0182\nresistance = 0.83\nfriction = 4e-6\n'
        f"inductance = {inductance}\n[wheel]\ninertia = 1.24e-4\n[fit]\nfree = [{free!r}]\n"
        f'[effects."motor.heating"]\nc = {c}\ntau = 30.0\n'
    )
    names = ("wheel_rad_s", *logged_too)
    outputs = run(rig, record(T, VOLTS, {name: np.zeros(len(T)) for name in names}), {})
    log = record(T, VOLTS, {name: outputs[name] for name in names})
    if refused:
        with pytest.raises(RigError, match="has motor.heating, whose own state bends the motion"):
            weak_form(rig, [log])
    else:
        assert weak_form(rig, [log]).rig.values["motor.torque_constant"] == pytest.approx(0.0182, rel=0.1)
