"""Slews: the ideal law against its integrals, the fastest one against closed forms of simple rigs."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax import parse_rig
from rwjax.control.drive_limits import Limits
from rwjax.control.on_off import on_off
from rwjax.control.open_loop import command_delay
from rwjax.control.slew import slew
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.shooting import plant_of
from rwjax.simulation.step import propagator, sliding_step, step
from tests.systems import platform, reaction, record, run

K, R, J, I = 0.0182, 0.83, 1.24e-4, 0.0495
AMPS, TOP = 3.0, 4000.0 * 2.0 * np.pi / 60.0
TORQUE = K * AMPS
LIMITS = Limits(20.0, AMPS, TOP)  # V: so high that the current alone limits the torque


def rig(friction: float = 0.0, inductance: float = 0.0):
    dry = f"[axis.friction]\ncoulomb = {friction}" if friction else ""
    lag = f"inductance = {inductance}" if inductance else ""
    return parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n{lag}\n[wheel]\ninertia = {J}\n'
        f"[axis]\ninertia = {I}\n{dry}"
    )


@given(st.floats(0.02, 20.0), st.floats(1e-3, 0.2), st.floats(20.0, 900.0))
def test_the_ideal_law_turns_the_axis_by_its_angle(angle: float, torque: float, top: float) -> None:
    law = on_off(I, J, angle, torque, top)
    t = np.linspace(0.0, law.time, 20_001)
    wheel = law.wheel(t)
    assert np.max(wheel) <= top * (1.0 + 1e-9) and wheel[-1] == pytest.approx(0.0, abs=1e-9 * top)
    assert np.max(np.abs(np.diff(wheel))) <= torque / J * (t[1] - t[0]) * (
        1.0 + 1e-6
    )  # never more than the motor's torque
    turned = np.sum(0.5 * (wheel[1:] + wheel[:-1])) * (t[1] - t[0])  # trapezoids, exact but where the law bends
    h = t[1] - t[0]
    bends = 4.0 * h * min(torque / J * h, np.max(wheel))  # what trapezoids miss
    assert law.turned(np.array([law.time]))[0] == pytest.approx(turned, rel=1e-9, abs=bends)
    assert J / I * turned == pytest.approx(angle, rel=1e-9, abs=J / I * bends)  # eq. 4.2
    assert law.hold < 1e-9 * law.time or law.top == top


def exact(angle: float, friction: float) -> float:
    """Least time under a constant torque and dry friction, the wheel unlimited: full drive, then full brake."""
    gains, loses = (TORQUE - friction) / I, (TORQUE + friction) / I
    peak = np.sqrt(2.0 * angle / (1.0 / gains + 1.0 / loses))
    return peak / gains + peak / loses


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
    found = slew(rig(), angle, LIMITS)
    ideal = on_off(I, J, angle, TORQUE, TOP)
    assert ideal.hold > 0.0 and ideal.time * (1.0 - 1e-4) < found.time < 1.01 * ideal.time
    assert np.mean(np.abs(found.best.wheel) > 0.99 * TOP) > 0.5 * ideal.hold / ideal.time


def test_an_inductance_is_reckoned_with() -> None:
    friction, angle = 0.01, np.radians(20.0)
    found = slew(rig(friction, 0.0641), angle, LIMITS)
    assert exact(angle, friction) * (1.0 - 1e-4) < found.time < 1.1 * exact(angle, friction)
    # what the current still does at the end is within what friction holds: the axis stays
    assert abs(float(found.best.torque[-1])) <= 0.5 * friction * 1.01
    assert float(found.best.rate[-1]) == pytest.approx(0.0, abs=1e-6)


def test_the_ideal_law_falls_short_by_what_friction_takes() -> None:
    friction, angle = 1e-3 * TORQUE, np.radians(30.0)
    found = slew(rig(friction), angle, LIMITS)
    lost = 0.5 * friction / I * found.ideal.time**2  # the axis slows down at M/I all the way
    assert found.miss == pytest.approx(-lost, rel=0.01)


def test_a_wheel_that_turns_the_other_way_beforehand_goes_further() -> None:
    with pytest.raises(InputError, match="90° are not reached"):
        slew(rig(0.02, 0.0641), np.radians(90.0), LIMITS)
    found = slew(rig(0.02, 0.0641), np.radians(90.0), LIMITS, spin=TOP)
    assert float(found.best.angle[-1]) == pytest.approx(np.radians(90.0), rel=1e-4)


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


@pytest.mark.parametrize(
    ("held", "effect", "spin", "words"),
    [
        ("[axis.gravity]\ntorque = 0.002\nangle = 0.5", "", 0.0, "the axis turns"),
        ("", '[effects."axis.bias_torque"]\nT = 0.02', 0.0, "the axis turns"),
        ("", '[effects."drive.bias"]\nu_b = 0.1', 0.0, "the wheel changes its rate"),
        ("", '[effects."wheel.coulomb"]\nM_c = 1e-4', 50.0, "the wheel changes its rate"),
        (
            "",
            '[effects."axis.periodic_torque"]\ns = 0.001\nc = 0.0\nomega = 3.0',
            0.0,
            "`axis.periodic_torque` changes",
        ),
        ("", '[effects."axis.bias_torque"]\nT = 0.005', 50.0, ""),
    ],
)
def test_a_delay_counts_only_where_the_rig_waits(held: str, effect: str, spin: float, words: str) -> None:
    friction = "viscous = 0.001" if held else "coulomb = 0.01"
    late = parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n[wheel]\ninertia = {J}\n[axis]\ninertia = {I}\n'
        f'[axis.friction]\n{friction}\n{held}\n{effect}\n[effects."drive.delay"]\ntau = 0.2'
    )
    if not words:
        assert command_delay(late, spin) == 0.2
        return
    with pytest.raises(InputError, match=f"^{words}.* the drive's delay of 0.2 s; leave the delay out$"):
        slew(late, np.radians(5.0), LIMITS, spin)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(InputError, match="take a `reaction` rig"):
        slew(platform(), 1.0, LIMITS)
    with pytest.raises(InputError, match=r"`drive\.lag`: .* leave it out$"):
        slew(replace(rig(), effects={"drive.lag": {"T": 0.1}}), 1.0, LIMITS)
    with pytest.raises(InputError, match="limit `volts` inf"):
        slew(rig(), 1.0, Limits(np.inf))
    with pytest.raises(InputError, match="limit `amps` -1: has to be positive"):
        slew(rig(), 1.0, Limits(10.0, -1.0))
    with pytest.raises(InputError, match="other than 0"):
        slew(rig(), 0.0, LIMITS)
    with pytest.raises(InputError, match="no torque is left at a wheel rate"):
        slew(replace(reaction(), effects={"wheel.coulomb": {"M_c": 1e-3}}), 1.0, Limits(10.0, 0.01))
    with pytest.raises(InputError, match="the limits allow"):
        slew(rig(), 1.0, LIMITS, spin=2.0 * TOP)


def test_a_sliding_axis_goes_on_through_rest_where_a_real_one_sticks() -> None:
    text = 'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\ncoulomb = 0.05'
    structure = structure_of(parse_rig(text))
    plant, h, zero = (
        plant_of(structure, jnp.asarray(theta_of(parse_rig(text), structure))),
        jnp.asarray(0.01),
        jnp.zeros(()),
    )
    p = propagator(plant, h)
    slid = stuck = (zero, jnp.asarray(0.1))  # psi, w; friction slows by 0.5 rad/s2
    for _ in range(50):
        slid = sliding_step(plant, p, zero, slid, zero, h, jnp.ones(()))
        stuck = step(plant, p, zero, stuck, zero, h)
    t = 0.5
    assert [float(v) for v in slid] == pytest.approx([0.1 * t - 0.25 * t**2, 0.1 - 0.5 * t])
    assert [float(v) for v in stuck] == pytest.approx([0.01, 0.0])
