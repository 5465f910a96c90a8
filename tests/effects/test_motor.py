"""Effects in the motor beside their closed forms."""

import jax.numpy as jnp
import pytest

from rwjax.effects.motor import DriverLimit, Heating, Saturation
from tests.effects.rigs import motion


def test_the_torque_per_ampere_halves_where_a_i_squared_is_one_and_either_way_alike() -> None:
    saturation = Saturation(a=jnp.asarray(0.25), m=jnp.asarray(1.0))
    assert float(saturation.factor(jnp.asarray(2.0))) == float(saturation.factor(jnp.asarray(-2.0))) == 0.5
    assert float(saturation.factor(jnp.asarray(0.0))) == 1.0


def test_with_an_exponent_of_one_half_the_torque_itself_has_a_limit() -> None:
    saturation = Saturation(a=jnp.asarray(0.25), m=jnp.asarray(0.5))
    assert float(saturation.factor(jnp.asarray(1e4))) * 1e4 == pytest.approx(2.0, rel=1e-6)  # 1/√a


def test_a_driver_limits_at_its_number() -> None:
    assert float(DriverLimit(i_m=jnp.asarray(3.0)).limit()) == 3.0


def test_a_warm_winding_settles_where_heating_and_cooling_are_equal() -> None:
    heating, i, tau = Heating(c=jnp.asarray(0.02), tau=jnp.asarray(10.0)), 1.5, 10.0
    q = 0.02 * i**2 * tau / (1.0 - 0.02 * i**2 * tau)  # c i² (1 + q) = q/tau
    settled = motion()._replace(i=jnp.asarray(i), own={"motor.heating:q": jnp.asarray(q)})
    assert float(heating.drift(settled)[0]) == pytest.approx(0.0, abs=1e-16)
    assert float(heating.resistance(settled)) == pytest.approx(1.0 + q, rel=1e-15)
