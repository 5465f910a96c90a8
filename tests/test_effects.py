"""Every effect by itself: in the library, never a source of energy where it is friction, and with the motion it should have."""

import inspect
from types import ModuleType

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.effects import BY_NAME, EFFECTS, axis, drive, wheel
from rwjax.effects.axis import Gravity, PolynomialFriction
from rwjax.effects.ports import AxisDry, AxisTorque, CommandDelay, CommandMap, Effect, Motion, WheelDry
from rwjax.param import parameters
from rwjax.plant import friction_level
from tests.systems import platform, record, run
from tests.systems import wheel as wheel_rig

PORTS = {AxisTorque: "axis", AxisDry: "axis", WheelDry: "wheel", CommandMap: "drive", CommandDelay: "drive"}
OF_THE_RIG_FILE = (
    PolynomialFriction,
    Gravity,
)  # terms that a rig models; nothing is diagnosed as missing of them
TIME = np.arange(1001) * 0.01
REST = np.zeros_like(TIME)


def motion(w: float = 0.0, Omega: float = 0.0) -> Motion:
    zero = jnp.zeros(())
    return Motion(t=zero, u=zero, psi=zero, w=jnp.asarray(w), theta=zero, Omega=jnp.asarray(Omega), i=zero)


def middle(effect: type[Effect]) -> Effect:
    """The effect with every parameter at its first search start, or 0.1."""
    return effect(**{name: jnp.asarray(p.starts[0] if p.starts else 0.1) for name, p in parameters(effect).items()})


@pytest.mark.parametrize("module", [axis, drive, wheel], ids=lambda m: m.__name__)
def test_every_effect_is_in_the_library(module: ModuleType) -> None:
    here = [c for _, c in inspect.getmembers(module, inspect.isclass) if c.__module__ == module.__name__]
    assert {*here} <= {*EFFECTS, *OF_THE_RIG_FILE}


def test_names_are_unique_and_begin_with_the_place_of_their_port() -> None:
    assert len(BY_NAME) == len(EFFECTS) == len({effect.label for effect in EFFECTS})
    for effect in EFFECTS:
        ports = [place for port, place in PORTS.items() if issubclass(effect, port)]
        assert len(ports) == 1 and effect.name.split(".")[0] == ports[0], effect.name


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_null_and_starts_lie_within_bounds(effect: type[Effect]) -> None:
    for name, p in parameters(effect).items():
        low, high = p.bounds
        assert low <= p.null <= high, name
        assert all(low <= start <= high for start in p.starts), name


@pytest.mark.parametrize("effect", [e for e in EFFECTS if issubclass(e, AxisDry | WheelDry)], ids=lambda e: e.name)
@given(speed=st.floats(-30.0, 30.0))
def test_dry_friction_never_adds_energy(effect: type, speed: float) -> None:
    m = motion(w=speed, Omega=speed)
    sign = 1.0 if speed >= 0.0 else -1.0
    assert sign * float(friction_level([middle(effect)], m, sign)) * speed >= 0.0


def test_a_negative_level_is_no_friction() -> None:
    weak = axis.AsymmetricFriction(M_c=jnp.asarray(0.01), d=jnp.asarray(0.03))
    assert float(friction_level([weak], motion(), -1.0)) == 0.0  # 0.01 - 0.03 would drive the axis
    assert float(friction_level([weak], motion(), 1.0)) == pytest.approx(0.04, rel=1e-15)


def test_breakaway_lies_above_sliding_friction() -> None:
    friction = axis.Stribeck(M_c=jnp.asarray(0.05), M_e=jnp.asarray(0.04), v_s=jnp.asarray(0.2))
    levels = [float(friction.level(motion(w=w), 1.0)) for w in (0.0, 0.2, 4.0)]
    assert levels == pytest.approx([0.09, 0.05 + 0.04 / np.e, 0.05], rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_asymmetric_friction_holds_one_way_and_slips_the_other(sign: float) -> None:
    # levels 0.05 +- 0.02 N m against 0.05 N m: forward 0.07 holds, backward 0.03 slips
    friction = {"axis.asymmetric_friction": {"M_c": 0.0, "d": 0.02}}
    y = run(platform(), record(TIME, np.full_like(TIME, sign * 0.05 / 0.4)), {}, effects=friction)
    assert (np.ptp(y["yaw_rad"]) == 0.0) if sign > 0.0 else (y["yaw_rad"][-1] < -0.1)


def test_a_constant_torque_turns_the_axis_as_the_closed_form_says() -> None:
    I, b, M_c, T = 0.1, 0.02, 0.05, 0.08
    y = run(platform(), record(TIME, REST), {}, effects={"axis.bias_torque": {"T": T}})
    exact = (T - M_c) / b * (1.0 - np.exp(-b / I * TIME))
    assert np.max(np.abs(y["yaw_rad_s"] - exact)) < 1e-12 * 1e2  # a linear plant: rounding of 2000 steps


def test_a_constant_torque_below_breakaway_turns_nothing() -> None:
    y = run(platform(), record(TIME, REST), {}, effects={"axis.bias_torque": {"T": -0.049}})
    assert np.ptp(y["yaw_rad"]) == 0.0


def test_commands_within_the_dead_zone_do_nothing_and_others_lose_it() -> None:
    u = np.where(TIME < 5.0, -0.29, 1.3)
    dead = run(platform(), record(TIME, u), {}, effects={"drive.deadzone": {"u_0": 0.3}})
    plain = run(platform(), record(TIME, np.where(TIME < 5.0, 0.0, 1.0)), {})
    assert np.ptp(dead["yaw_rad"][TIME < 5.0]) == 0.0
    assert np.max(np.abs(dead["yaw_rad"] - plain["yaw_rad"])) < 1e-10


def test_an_offset_is_added_to_the_command() -> None:
    u = np.sin(TIME)
    offset = run(platform(), record(TIME, u), {}, effects={"drive.bias": {"u_b": 0.2}})
    assert np.max(np.abs(offset["yaw_rad"] - run(platform(), record(TIME, u + 0.2), {})["yaw_rad"])) < 1e-12


def test_the_dead_zone_comes_before_the_offset() -> None:
    # otherwise the offset could be hidden within the zone
    both = {"drive.deadzone": {"u_0": 0.3}, "drive.bias": {"u_b": 0.2}}
    y = run(platform(), record(TIME, REST), {}, effects=both)
    assert y["yaw_rad"][-1] == pytest.approx(run(platform(), record(TIME, REST + 0.2), {})["yaw_rad"][-1], rel=1e-12)


def test_a_braked_wheel_stops_when_the_closed_form_says() -> None:
    # open circuit is not in the plant: at V = 0 back-EMF brakes too, b_e = b + K^2/R
    K, R, b, J, M_c, Omega0 = 0.0182, 0.83, 4.07e-6, 1.24e-4, 2e-3, 30.0
    t = TIME[:301]
    log = record(t, np.zeros_like(t), {"wheel_rad_s": np.zeros_like(t)})
    y = run(wheel_rig(0.0), log, {"Omega": Omega0}, effects={"wheel.coulomb": {"M_c": M_c}})
    braking = b + K**2 / R
    stop = J / braking * np.log1p(braking * Omega0 / M_c)
    exact = np.where(t < stop, (Omega0 + M_c / braking) * np.exp(-braking / J * t) - M_c / braking, 0.0)
    assert 0.2 < stop < 2.5
    assert np.max(np.abs(y["wheel_rad_s"] - exact)) < 1e-10 * Omega0  # samples beside the stop are exact too
    assert np.all(y["wheel_rad_s"][t > stop + 0.01] == 0.0)
