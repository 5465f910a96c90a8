"""The end of a step in which a body stops, turns, breaks away or stays."""

import jax.numpy as jnp
import pytest

from rwjax.plant.plant import BodyTorque
from rwjax.plant.stick import Stop, stopped

I, LEVEL = 0.1, 0.05


def after(w0: float, torque: tuple[float, float], h: float = 1.0) -> tuple[Stop, float]:
    """End of a step with torques at both ends, and the speed that it would have if the body slid on as it did."""
    sign = (w0 > 0.0) - (w0 < 0.0)
    stages = [BodyTorque(jnp.asarray(M), jnp.asarray(M - min(max(M, -LEVEL), LEVEL))) for M in torque]
    a = [(M - sign * LEVEL) / I if sign else float(stage.excess) / I for M, stage in zip(torque, stages, strict=True)]
    w1 = w0 + h * (a[0] + a[1]) / 2.0
    angle1 = h * w0 + h**2 * (a[0] + (a[1] - a[0]) / 3.0) / 2.0
    pair = tuple(jnp.asarray(v) for v in (w0, w1)), tuple(jnp.asarray(v) for v in (0.0, angle1))
    levels = jnp.asarray(LEVEL), jnp.asarray(LEVEL)
    return stopped(*pair, jnp.asarray(a[0]), jnp.asarray(h), jnp.asarray(I), levels, (stages[0], stages[1])), w1


def test_a_body_that_does_not_reach_rest_is_left_alone() -> None:
    end, w1 = after(2.0, (0.02, 0.03))
    assert not bool(end.mended) and float(end.rate) == w1


def test_a_body_stops_where_its_deceleration_says_and_stays() -> None:
    end, w1 = after(0.4, (0.0, 0.0))  # 0.5 rad/s2 stops it after 0.8 s
    assert w1 < 0.0 and bool(end.mended)
    assert float(end.rate) == 0.0
    assert float(end.angle) == pytest.approx(0.4**2 / (2.0 * 0.5), rel=1e-12)


def test_a_body_that_is_pushed_back_turns_and_goes_on_against_the_other_friction() -> None:
    end, _ = after(0.5, (-0.2, -0.2))  # slows with 2.5 rad/s2, stops after 0.2 s, then gains 1.5 rad/s2
    assert float(end.rate) == pytest.approx(-1.5 * 0.8, rel=1e-12)
    assert float(end.angle) == pytest.approx(0.5**2 / 5.0 - 0.5 * 1.5 * 0.8**2, rel=1e-12)


def test_a_resting_body_stays_within_its_level_and_breaks_away_beyond() -> None:
    held, _ = after(0.0, (0.03, -0.04))
    assert float(held.rate) == float(held.angle) == 0.0 and bool(held.mended)
    away, w1 = after(0.0, (0.04, 0.06))  # the level is passed in the middle of the step
    assert float(away.rate) == pytest.approx(0.5 * w1, rel=1e-12) and 0.0 < float(away.angle)
