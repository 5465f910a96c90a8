"""Loads and stops of the axis beside their closed forms."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects.axis import Backlash
from rwjax.effects.effect import Motion
from tests.effects.rigs import FREE, REST, TIME, go, motion
from tests.systems import platform, record, run

PLAY = {"g": 0.1, "s": 0.3, "k": 200.0, "c": 0.8}


def test_an_end_stop_takes_energy_and_never_pulls() -> None:
    stop = {"axis.end_stop": {"high": 1.0, "low": -1.0, "k": 40.0, "d": 1.0}}
    y = go(FREE, REST, {"w": 1.0}, stop)
    assert (
        -1.0 < y["yaw_rad_s"][TIME > 1.5][0] < -0.3 and np.min(y["yaw_rad"]) > -1.05
    )  # back, and off the other stop too
    away = (np.abs(y["yaw_rad"]) < 0.98)[1:] & (np.abs(y["yaw_rad"]) < 0.98)[:-1]
    assert np.max(np.abs(np.diff(y["yaw_rad_s"])[away])) < 1e-12


def test_a_constant_torque_below_breakaway_turns_nothing() -> None:
    y = run(platform(), record(TIME, REST), {}, effects={"axis.bias_torque": {"T": -0.049}})
    assert np.ptp(y["yaw_rad"]) == 0.0


def _twisted(twist: Any, slip: Any) -> Motion:
    own = {"axis.backlash:twist": jnp.asarray(twist), "axis.backlash:slip": jnp.asarray(slip)}
    return motion()._replace(own=own)


@pytest.mark.parametrize(
    ("begin", "end"),
    [
        ((0.02, 1.0), (0.08, 2.0)),  # it sets in
        ((-0.08, 0.1), (-0.03, 0.1)),  # it lets go
        ((0.06, 1.0), (0.09, 0.5)),
        ((0.0, 1.0), (0.04, 1.0)),
        ((-0.07, 0.0), (0.09, 0.0)),  # from one side to the other
        ((0.05, 1.0), (0.05, 1.0)),
        ((0.08, 1.0), (0.05, 1.0)),  # up to the edge
        ((0.08, -2.0), (0.03, -2.0)),  # it rebounds, and never pulls
        ((0.06, -1.0), (0.045, -1.5)),
        ((-0.06, 4.0), (-0.055, 1.0)),
    ],
)
def test_the_mean_torque_of_play_is_that_over_a_step_of_even_motion(
    begin: tuple[float, float], end: tuple[float, float]
) -> None:
    play = Backlash(**{name: jnp.asarray(value) for name, value in PLAY.items()})
    shares = (np.arange(20000) + 0.5) / 20000
    twist, slip = (a + shares * (b - a) for a, b in zip(begin, end, strict=True))
    mean = np.mean(np.asarray(jax.vmap(lambda at, by: play.torque(_twisted(at, by)))(twist, slip)))
    assert float(play.mean_torque(_twisted(*begin), _twisted(*end))) == pytest.approx(mean, rel=1e-3, abs=1e-9)


@pytest.mark.parametrize(
    ("play", "coulomb", "within"),
    [(PLAY, 0.0, 0.001), ({"g": 0.3, "s": 0.3, "k": 400.0, "c": 2.0}, 0.0, 0.005), (PLAY | {"c": 4.0}, 0.15, 0.02)],
)
def test_play_is_followed_through_its_impacts(play: dict[str, float], coulomb: float, within: float) -> None:
    u, y = np.sin(2.0 * np.pi * 1.1 * TIME[:401]), [0.0]
    g, s, k, c = play.values()
    psi, w, twist, drive, h = 0.0, 0.0, 0.0, 0.0, 2e-5  # the drive's own rate
    for volts in u[:-1]:
        for _ in range(500):
            over = twist - min(max(twist, -0.5 * g), 0.5 * g)
            side = np.sign(over)
            T = side * max(side * (k * over + c * (drive - w)), 0.0)
            drive += h * (0.4 * volts - T) / (0.1 * s)
            free = T - 0.02 * w
            holds = min(max(free, -coulomb), coulomb) if w == 0.0 else coulomb * np.sign(w)
            new = w + h * (free - holds) / (0.1 * (1.0 - s))
            w = 0.0 if new * w < 0.0 else new
            psi, twist = psi + h * w, twist + h * (drive - w)
        y.append(psi)
    rig = platform(f"viscous = 0.02\ncoulomb = {coulomb}")
    found = run(rig, record(TIME[:401], u), {}, effects={"axis.backlash": play})
    assert np.max(np.abs(found["yaw_rad"] - y)) < within * np.ptp(y)
