"""Slews: the ideal law against its integrals, the fastest one against closed forms of simple rigs."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.drive_limits import Limits
from rwjax.control.on_off import on_off
from rwjax.control.slew import slew
from rwjax.errors import InputError, RigError
from tests.control.current_limited_rig import AMPS, LIMITS, TOP, I, J, K, R
from tests.systems import platform, reaction, record, run

TORQUE = K * AMPS


def rig(friction: float = 0.0, inductance: float = 0.0):
    dry = f"[axis.friction]\ncoulomb = {friction}" if friction else ""
    lag = f"inductance = {inductance}" if inductance else ""
    return parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n{lag}\n[wheel]\ninertia = {J}\n'
        f"[axis]\ninertia = {I}\n{dry}"
    )


def exact(angle: float, friction: float) -> float:
    """Least time under a constant torque and dry friction, the wheel unlimited: full drive, then full brake."""
    gains, loses = (TORQUE - friction) / I, (TORQUE + friction) / I
    peak = np.sqrt(2.0 * angle / (1.0 / gains + 1.0 / loses))
    return peak / gains + peak / loses


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.01])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_fastest_slew_is_nearly_the_exact_one_and_never_faster(friction: float, way: float) -> None:
    angle = np.radians(20.0)
    found = slew(rig(friction), way * angle, LIMITS)
    best, least = found.best, exact(angle, friction)
    assert least * (1.0 - 1e-4) < found.time < 1.01 * least  # one piece of 30 in which the torque changes its sign
    assert float(best.angle[-1]) == pytest.approx(way * angle, rel=1e-4)
    assert abs(float(best.rate[-1])) < 1e-3 * angle
    assert np.max(np.abs(best.current)) < AMPS * 1.001 and np.max(np.abs(best.wheel)) < TOP * 1.001


def test_the_wheel_s_limit_makes_a_hold() -> None:
    angle = np.radians(90.0)
    told: list[str] = []
    found = slew(rig(), angle, LIMITS, progress=told.append)
    assert told[0] == "following the ideal law on the rig" and told[1].startswith(
        "looking for the least time: search 1"
    )
    ideal = on_off(I, J, angle, TORQUE, TOP)
    assert ideal.hold > 0.0 and ideal.time * (1.0 - 1e-4) < found.time < 1.01 * ideal.time
    assert np.mean(np.abs(found.best.wheel) > 0.99 * TOP) > 0.5 * ideal.hold / ideal.time


@pytest.mark.slow
def test_an_inductance_is_reckoned_with() -> None:
    friction, angle = 0.01, np.radians(20.0)
    found = slew(rig(friction, 0.0641), angle, LIMITS)
    assert exact(angle, friction) * (1.0 - 1e-4) < found.time < 1.1 * exact(angle, friction)
    # what the current still does at the end is within what friction holds: the axis stays
    assert abs(float(found.best.torque[-1])) <= 0.5 * friction * 1.01
    assert float(found.best.rate[-1]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
def test_the_ideal_law_falls_short_by_what_friction_takes() -> None:
    friction, angle = 1e-3 * TORQUE, np.radians(30.0)
    found = slew(rig(friction), angle, LIMITS)
    lost = 0.5 * friction / I * found.ideal.time**2  # the axis slows down at M/I all the way
    assert found.miss == pytest.approx(-lost, rel=0.01)


@pytest.mark.slow
def test_a_wheel_that_turns_the_other_way_beforehand_goes_further() -> None:
    with pytest.raises(InputError, match=r"^angle 90° \(1\.5708 rad\): is not reached"):
        slew(rig(0.02, 0.0641), np.radians(90.0), LIMITS)
    found = slew(rig(0.02, 0.0641), np.radians(90.0), LIMITS, spin=TOP)
    assert float(found.best.angle[-1]) == pytest.approx(np.radians(90.0), rel=1e-4)


@pytest.mark.slow
def test_an_angle_beyond_what_friction_leaves_of_the_momentum_is_said_with_it() -> None:
    friction = 0.02
    reach = np.degrees((J * TOP) ** 2 / (2.0 * I * friction))
    words = (
        rf"what resists the axis, 0\.02 N m at least, takes the {J * TOP:.3g} N m s .* within {reach:.3g}°; turn less"
    )
    with pytest.raises(InputError, match=words):
        slew(rig(friction), np.radians(3.0 * reach), LIMITS)


@pytest.mark.slow
def test_with_a_delay_the_same_commands_do_the_same_so_much_later() -> None:
    angle = np.radians(20.0)
    plain = slew(rig(0.01), angle, LIMITS)
    h = float(plain.best.time[1])
    delay = 5.0 * h
    late = replace(rig(0.01), effects={"drive.delay": {"tau": delay}, "sensor.delay": {"tau": 0.05}})
    found = slew(late, angle, LIMITS)
    assert found.delay == delay and found.time == plain.time + delay
    for ours, other in zip(found.best, plain.best, strict=True):
        assert np.array_equal(ours, other)
    # given to the rig, delay and all: a free run of another part of the library, the encoder read at once
    command = np.concatenate([np.zeros(10), np.asarray(found.best.command[:-1]), np.zeros(6)])  # the first: held before
    time, only = h * np.arange(316.0), replace(late, effects={"drive.delay": {"tau": delay}})
    seen = run(only, record(time, command), {})["yaw_rad"]
    assert seen[15:] == pytest.approx(np.asarray(found.best.angle), abs=1e-9) and np.all(seen[:16] == 0.0)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(RigError, match="take a `reaction` rig"):
        slew(platform(), 1.0, LIMITS)
    with pytest.raises(RigError, match=r"`drive\.lag`: .* leave it out$"):
        slew(replace(rig(), effects={"drive.lag": {"T": 0.1}}), 1.0, LIMITS)
    with pytest.raises(InputError, match="limit `volts` inf"):
        slew(rig(), 1.0, Limits(np.inf))
    with pytest.raises(InputError, match="limit `amps` -1: has to be positive"):
        slew(rig(), 1.0, Limits(10.0, -1.0))
    with pytest.raises(InputError, match="other than 0"):
        slew(rig(), 0.0, LIMITS)
    with pytest.raises(InputError, match=r"^amps 0.01: no torque is left at a wheel rate of .* 1/min \("):
        slew(replace(reaction(), effects={"wheel.coulomb": {"M_c": 1e-3}}), 1.0, Limits(10.0, 0.01))
    with pytest.raises(InputError, match=r"takes .* s at least with limits of 10 V, 1e-09 A; 86400 s, a day, at most"):
        slew(rig(), 1.0, Limits(10.0, 1e-9))
    with pytest.raises(InputError, match=r"^spin .* 1/min \(.* rad/s\): the limits allow .* 1/min \("):
        slew(rig(), 1.0, LIMITS, spin=2.0 * TOP)
