"""The level of several dry frictions on one body."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects.axis_friction import AsymmetricFriction, Coulomb, FrictionDrift
from rwjax.effects.effect import Motion
from rwjax.plant.dry_friction import friction_level, friction_sum, smooth_friction

ZERO = jnp.zeros(())
MOTION = Motion(*(ZERO,) * 10, own={})


def test_levels_add_up_and_each_is_raised_by_the_shares_of_the_others() -> None:
    drift = FrictionDrift(
        d=jnp.asarray(0.5), B=ZERO, tau=jnp.asarray(5.0), s=ZERO
    )  # at the beginning half as much again
    dry = [Coulomb(M_c=jnp.asarray(0.2)), Coulomb(M_c=jnp.asarray(0.1)), drift]
    assert float(friction_sum(dry, MOTION, 1.0)) == pytest.approx(1.5 * 0.3)


def test_a_level_never_drives_a_body() -> None:
    weak = [AsymmetricFriction(M_c=jnp.asarray(0.01), d=jnp.asarray(0.03))]
    assert float(friction_sum(weak, MOTION, -1.0)) == pytest.approx(-0.02)
    assert float(friction_level(weak, MOTION, -1.0)) == 0.0
    assert float(friction_level(weak, MOTION, 1.0)) == pytest.approx(0.04)
    assert float(friction_level([], MOTION, 1.0)) == 0.0


def test_smooth_friction_takes_power_tends_to_its_level_and_is_odd_where_that_is_the_same_both_ways() -> None:
    rates, width = np.array([-3.0, -0.02, -1e-4, 0.0, 1e-4, 0.02, 3.0]), jnp.asarray(0.01)
    for d in (0.0, 0.03, 0.3):  # the last would drive it one way, and is no friction there
        dry = [AsymmetricFriction(M_c=jnp.asarray(0.05), d=jnp.asarray(d))]
        found = np.array([float(smooth_friction(dry, MOTION, jnp.asarray(w), width)) for w in rates])
        assert np.all(rates * found >= 0.0) and found[3] == 0.0
        assert found[[0, -1]] == pytest.approx([-max(0.05 - d, 0.0), 0.05 + d], rel=1e-12)
        assert d or np.array_equal(found, -found[::-1])
        assert found[5] == pytest.approx((0.05 + d) * np.tanh(2.0))
