"""Dumping the wheel's momentum into static friction: the bound, the axis that does not move, and one that does."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax import Rig, parse_rig
from rwjax.control import momentum_dump
from rwjax.control.drive_limits import Limits
from rwjax.control.momentum_dump import dump
from rwjax.control.open_loop import at_rest, open_loop, steady_state
from rwjax.errors import InputError, RigError
from tests.systems import MOTOR, reaction

SPIN, HOLDS, J, K, R = 400.0, 0.015, 1.24e-4, 0.0182, 0.83
TESTBED = reaction(f"coulomb = 0.01\nstatic = {HOLDS}\nstribeck_velocity = 0.2")
LIMITS = Limits(12.0, 3.0)


@pytest.mark.parametrize("spin", [SPIN, pytest.param(-SPIN, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_the_wheel_stops_near_the_bound_and_the_axis_does_not_move(spin: float) -> None:
    told: list[str] = []
    found = dump(TESTBED, spin, LIMITS, progress=told.append)
    assert told[0] == "looking at what friction holds" and told[1].startswith("looking for the least time: search 1")
    assert found.bound == pytest.approx(J * SPIN / (0.9 * HOLDS))
    assert found.bound < found.time < 1.05 * found.bound
    assert np.all(np.asarray(found.best.angle) == 0.0)  # held, not nearly held
    assert abs(float(found.best.wheel[-1])) < 1e-3 * SPIN
    assert np.max(np.abs(found.best.torque)) < 0.9 * HOLDS * 1.001


@pytest.mark.slow
def test_a_stop_faster_than_the_bound_moves_the_axis() -> None:
    found = dump(TESTBED, SPIN, LIMITS, margin=0.98)
    structure, theta, start = steady_state(TESTBED, SPIN)
    for share, moves in ((1.0, False), (0.9, True)):
        run = open_loop(structure, theta, found.best.command[:-1], share * found.time, start)
        assert bool(np.any(np.asarray(run.angle) != 0.0)) == moves


@pytest.mark.slow
def test_a_held_load_takes_its_part_of_the_friction() -> None:
    load = 0.006
    loaded = parse_rig(
        f'kind = "reaction"\n{MOTOR}\n[axis]\ninertia = 0.0495\n[axis.friction]\ncoulomb = {HOLDS}\n'
        f'[effects."axis.bias_torque"]\nT = {load}'
    )
    assert dump(loaded, SPIN, LIMITS).bound == pytest.approx(J * SPIN / (0.9 * HOLDS - load))
    assert dump(loaded, -SPIN, LIMITS).bound == pytest.approx(J * SPIN / (0.9 * HOLDS + load))


def loose(effects: str = "", friction: str = "coulomb = 0.01") -> Rig:
    """A rig whose current follows at once."""
    return parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n[wheel]\ninertia = {J}\n[axis]\ninertia = 0.0495\n'
        f"[axis.friction]\n{friction}\n{effects}"
    )


@pytest.mark.parametrize(("spin", "margin"), [(200.0, 0.5), (-400.0, 0.5), (100.0, 0.9)])
@pytest.mark.slow
def test_little_friction_is_used_as_far_as_commands_held_in_steps_can(spin: float, margin: float) -> None:
    found = dump(loose(friction="viscous = 0.002\ncoulomb = 0.005"), spin, Limits(10.0), margin)
    room = margin * 0.005
    assert found.bound == pytest.approx(J * abs(spin) / room)
    # over a step, T/300, the wheel slows by spin/300, and a command held at its mean brakes by half of that back-EMF too much at first
    ripple = K**2 / R * abs(spin) / 600.0
    assert found.bound < found.time < 1.01 * J * abs(spin) / (room - ripple)
    assert np.all(np.asarray(found.best.angle) == 0.0) and abs(float(found.best.wheel[-1])) < 1e-3 * abs(spin)


@pytest.mark.slow
def test_friction_that_grows_with_the_torque_holds_more_of_it() -> None:
    found = dump(loose('[effects."axis.load_friction"]\nmu = 0.4'), 300.0, Limits(10.0))
    assert found.bound == pytest.approx(J * 300.0 / (0.9 * 0.01 / (1.0 - 0.9 * 0.4)))  # T = 0.9 (0.01 + 0.4 T)
    assert found.bound < found.time < 1.03 * found.bound


@pytest.mark.slow
def test_no_bound_is_claimed_where_the_load_changes() -> None:
    periodic = '[effects."axis.periodic_torque"]\ns = 0.002\nc = 0.0\nomega = 3.0'
    found = dump(loose(periodic), 100.0, Limits(10.0))
    assert found.bound == 0.0 and np.all(np.asarray(found.best.angle) == 0.0)


@pytest.mark.parametrize(
    ("wheel", "angle", "words"),
    [
        (0.0, 0.01, r"the axis moves by 0\.57°; begin at a lower rate of the wheel$"),
        (4.0, 0.0, r"1 % of the rate are left; raise the voltage or the current$"),
        (0.0, 0.0, r"static friction is used beyond its share"),
    ],
)
def test_what_a_dump_lacks_is_said(wheel: float, angle: float, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    still = at_rest(loose())
    tried = still._replace(angle=jnp.array([0.0, angle]), wheel=jnp.array([SPIN, wheel]))
    monkeypatch.setattr(momentum_dump, "minimum_time", lambda *_: (tried, 1.0))
    with pytest.raises(InputError, match=rf"^spin 3819\.72 1/min \(400 rad/s\): no dump was found: {words}"):
        dump(loose(), SPIN, Limits(10.0))


def test_a_wheel_that_the_voltage_cannot_hold_is_to_blame(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = at_rest(loose())._replace(angle=jnp.array([0.0, 1e-20]), wheel=jnp.array([SPIN, 0.0]))
    monkeypatch.setattr(momentum_dump, "minimum_time", lambda *_: (tried, 1.0))
    brakes = (K * SPIN - 5.0) * K / R  # what 5 V leave of the back-EMF
    words = rf"the back-EMF brakes with {brakes:.3g} N m whatever .* bears 0\.009 N m; begin at a lower rate"
    with pytest.raises(InputError, match=words):
        dump(loose(), SPIN, Limits(5.0))


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(RigError, match=r"`axis\.presliding`: the axis moves a little before it is held; leave it out"):
        dump(loose('[effects."axis.presliding"]\nM_c = 0.0\nx_s = 1e-3'), SPIN, LIMITS)
    with pytest.raises(RigError, match="nothing holds the axis"):
        dump(reaction(), SPIN, LIMITS)
    with pytest.raises(InputError, match="other than 0"):
        dump(TESTBED, 0.0, LIMITS)
    with pytest.raises(InputError, match=r"margin 1\.5"):
        dump(TESTBED, SPIN, LIMITS, margin=1.5)
