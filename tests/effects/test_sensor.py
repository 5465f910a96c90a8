"""Effects on the reading beside their closed forms."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.effects import sensor
from tests.effects.rigs import DRY, FREE, RIGS, TIME, go, motion


@pytest.mark.parametrize("tau", [0.04, 0.0373])
def test_a_late_reading_is_a_late_command_where_there_is_one_encoder(tau: float) -> None:
    u = np.where(TIME < 0.3, 0.0, 0.6 * np.sign(np.sin(2.3 * TIME)) + 0.2 * np.sin(9.0 * TIME))
    for rig, within in ((DRY, 1e-12 if tau == 0.04 else 5e-3), (FREE, 1e-5)):
        late = go(rig, u, {}, {"sensor.delay": {"tau": tau}})["yaw_rad"]
        command = go(rig, u, {}, {"drive.delay": {"tau": tau}})["yaw_rad"]
        # a late command within a step enters it by its mean, which stick and slip feel
        assert np.max(np.abs(late - command)) < within * np.max(np.abs(command))


def test_other_sensors_than_the_encoder_are_not_late() -> None:
    u = 2.0 * np.sin(3.0 * TIME)
    plain, late = (go(RIGS["reaction"], u, {}, {"sensor.delay": {"tau": tau}}) for tau in (0.0, 0.05))
    assert np.array_equal(late["wheel_rad_s"], plain["wheel_rad_s"]) and np.array_equal(
        late["current_A"], plain["current_A"]
    )
    assert np.max(np.abs(late["yaw_rad"][5:] - plain["yaw_rad"][:-5])) < 1e-12


@given(angle=st.floats(-10.0, 10.0), rate=st.floats(-5.0, 5.0))
def test_an_eccentric_encoder_reads_the_rate_of_the_angle_that_it_reads(angle: float, rate: float) -> None:
    read = partial(sensor.Eccentricity(*map(jnp.asarray, (0.1, -0.05, 0.04, 0.03))).read, motion=motion())
    psi, w = jnp.asarray(angle), jnp.asarray(rate)
    slope = jax.grad(lambda psi: read(psi, w)[0])(psi)
    assert float(read(psi, w)[1]) == pytest.approx(rate * float(slope), abs=1e-12)
