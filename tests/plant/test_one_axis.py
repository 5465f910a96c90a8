"""The equations of rigs with one axis or none, written out."""

import jax.numpy as jnp
import pytest

from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import OneAxis
from rwjax.rig.model import Rig
from tests.systems import platform, reaction, wheel

K, R, L, B, J = 0.0182, 0.83, 0.0641, 4.07e-6, 1.24e-4
T0 = jnp.zeros(())


def of(rig: Rig, **effects: dict[str, float]) -> OneAxis:
    """The rig's plant with effects, by names with `_` for the dot."""
    structure = structure_of(rig).with_effects(*(name.replace("_", ".", 1) for name in effects))
    given = {f"{e.replace('_', '.', 1)}.{name}": v for e, values in effects.items() for name, v in values.items()}
    theta = [given.get(name, value) for name, value in zip(structure.names, theta_of(rig, structure), strict=True)]
    return one_axis_plant_of(structure, jnp.asarray(theta))


def state(*values: float) -> tuple:
    """A state of these numbers."""
    return tuple(jnp.asarray(v) for v in values)


def test_a_wheel_turns_by_its_motor() -> None:
    Omega, i, V = 40.0, 1.5, 6.0
    found = of(wheel()).field(T0, state(0.3, Omega, i), jnp.asarray(V))
    assert [float(v) for v in found] == pytest.approx([Omega, (K * i - B * Omega) / J, (V - R * i - K * Omega) / L])


def test_without_inductance_the_current_follows_the_voltage() -> None:
    Omega, V = 40.0, 6.0
    plant = of(wheel(0.0))
    i = (V - K * Omega) / R
    assert float(plant.motion(T0, state(0.3, Omega), jnp.asarray(V)).i) == pytest.approx(i)
    assert float(plant.field(T0, state(0.3, Omega), jnp.asarray(V))[1]) == pytest.approx((K * i - B * Omega) / J)


def test_a_wheels_motor_turns_the_body_the_other_way() -> None:
    w, Omega, i = 0.5, 40.0, 1.5
    found = of(reaction()).field(T0, state(0.1, w, 0.3, Omega, i), jnp.asarray(6.0))
    assert float(found[1]) == pytest.approx((-(K * i - B * Omega) - 0.0026 * w) / 0.0495)


def test_dry_friction_holds_a_resting_axis_and_opposes_a_sliding_one() -> None:
    plant, k, b, M_c, I = of(platform()), 0.4, 0.02, 0.05, 0.1
    for w, u, friction in ((2.0, 0.1, M_c), (-2.0, 0.1, -M_c), (0.0, 0.1, k * 0.1), (0.0, 1.0, M_c), (0.0, -1.0, -M_c)):
        x = state(0.0, w)
        found = plant.with_friction(T0, x, jnp.asarray(u), x)
        assert float(found.rates[1]) == pytest.approx((k * u - b * w - friction) / I, abs=1e-15)
        assert float(found.torques[0].free) == pytest.approx(k * u - b * w)
        assert float(found.torques[0].excess) == pytest.approx(
            max(abs(k * u - b * w) - M_c, 0.0) * (1 if u > 0 else -1)
        )


def test_friction_of_the_wheel_pushes_the_body() -> None:
    plant = of(reaction(), wheel_coulomb={"M_c": 0.01})
    ((body, _), *_) = plant.bodies()
    rates = dict(zip(plant.structure.states, body.reaction, strict=True))
    assert float(rates["Omega"]) == pytest.approx(-1.0 / J) and float(rates["w"]) == pytest.approx(1.0 / 0.0495)


def test_the_drive_maps_delays_and_limits_its_command() -> None:
    plant = of(platform(), drive_bias={"u_b": 0.25}, drive_delay={"tau": 0.03})
    assert float(plant.act(jnp.asarray(1.0))) == pytest.approx(1.25)
    assert float(plant.delay()) == pytest.approx(0.03) and not plant.filters
    limited = of(wheel(), motor_current_limit={"i_m": 2.0})
    assert [float(v) for v in limited.within_limits(state(0.0, 0.0, -5.0))] == [0.0, 0.0, -2.0]
    assert of(platform()).delay() is None


def test_smooth_friction_is_the_exact_one_of_sliding_bodies_and_pushes_the_body_that_carries_the_wheel() -> None:
    plant = of(reaction("viscous = 0.0026\ncoulomb = 0.01"), wheel_coulomb={"M_c": 2e-4})
    x, u = state(0.1, -0.4, 2.0, 30.0, 1.5), jnp.asarray(6.0)
    exact = [float(v) for v in plant.with_friction(T0, x, u, x).rates]
    assert [float(v) for v in plant.with_smooth_friction(T0, x, u, jnp.asarray(1e-3))] == pytest.approx(
        exact, rel=1e-12
    )
    wide, free = plant.with_smooth_friction(T0, x, u, jnp.asarray(0.4)), plant.field(T0, x, u)
    change = [float(a - b) for a, b in zip(wide, free, strict=True)]
    on_axis = (0.01 * float(jnp.tanh(1.0)) + 2e-4) / 0.0495
    assert change == pytest.approx([0.0, on_axis, 0.0, -2e-4 / J, 0.0], rel=1e-9)


def test_no_current_leaves_what_its_driver_allows() -> None:
    plant, narrow = of(wheel(), motor_current_limit={"i_m": 1.5}), jnp.asarray(0.01)
    at, within = (plant.with_smooth_friction(T0, state(0.0, 0.0, i), jnp.asarray(6.0), narrow)[2] for i in (1.5, 1.4))
    back = plant.with_smooth_friction(T0, state(0.0, 0.0, 1.5), jnp.asarray(-6.0), narrow)[2]
    assert float(at) == 0.0 and float(within) > 0.0 and float(back) == pytest.approx((-6.0 - R * 1.5) / L)
