"""Effects on the command beside their closed forms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects import drive
from tests.effects.rigs import REST, TIME
from tests.systems import platform, record, run


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


def test_a_curve_has_one_slope_by_its_bend_on_either_side_of_none() -> None:
    def by_c(c: float, u: float) -> float:
        given = {"p": jnp.asarray(0.1), "u_1": jnp.asarray(3.0)}
        return float(jax.grad(lambda c: drive.Curvature(c=c, **given).command(jnp.asarray(u)))(jnp.asarray(c)))

    for u in (2.0, -2.0):
        assert by_c(0.0, u) == pytest.approx(by_c(1e-9, u), rel=1e-6) == pytest.approx(by_c(-1e-9, u), rel=1e-6)
