"""The level of several dry frictions on one body."""

import jax.numpy as jnp
import pytest

from rwjax.effects.axis_friction import AsymmetricFriction, Coulomb, FrictionDrift
from rwjax.effects.effect import Motion
from rwjax.plant.dry_friction import friction_level, friction_sum

ZERO = jnp.zeros(())
MOTION = Motion(t=ZERO, V=ZERO, psi=ZERO, w=ZERO, theta=ZERO, Omega=ZERO, i=ZERO, load=ZERO, sensed=ZERO, own={})


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
