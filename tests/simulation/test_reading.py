"""Readings between the grid points of the time steps."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.plant import Plant
from rwjax.simulation.reading import Slots, readings
from tests.systems import platform, record, run, wheel

TIME = np.arange(201) * 0.01


class Shown(OneAxis):
    """A platform whose readings are all that a reading may depend on."""

    def outputs(self, t, x, u, seen=None):
        """Time, voltage, angle and rate now and at the moment that is seen."""
        return t, u, *x, *(seen or x)


def shown(age: float | None) -> Plant:
    """The platform, with an encoder that is late or is not."""
    structure = structure_of(platform()).with_effects(*(["sensor.delay"] if age is not None else []))
    plant = plant_of(structure, jnp.asarray([*theta_of(platform(), structure)[: len(structure.names) - 1], age or 0.0]))
    return Shown(plant.structure, plant.numbers, plant.effects)


H, BEGIN = 0.1, 3.0  # s
RATE = np.random.default_rng(4).normal(size=9)  # rad/s, at the grid points; it runs straight between them
ANGLE = 0.7 + np.append(0.0, np.cumsum(0.5 * H * (RATE[1:] + RATE[:-1])))


def moved(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angle and rate a time after the window's beginning [s]; before it the angle went on at its first rate."""
    k = np.clip(np.floor(t / H + 1e-9).astype(int), 0, len(RATE) - 2)
    late, slope = np.maximum(t - k * H, 0.0), (RATE[k + 1] - RATE[k]) / H
    return ANGLE[k] + RATE[k] * late + 0.5 * slope * late**2 + RATE[0] * np.minimum(t, 0.0), RATE[k] + slope * late


@pytest.mark.parametrize("age", [None, 0.0, 0.037, 0.2, 0.33])
def test_readings_show_time_command_and_the_motion_of_their_own_moment(age: float | None) -> None:
    step = np.array([0, 0, 1, 2, 2, 3, 5, 7, 7])
    part = np.array([0.0, 0.3, 0.0, 0.1, 0.95, 0.5, 0.77, 0.0, 0.6])
    u = np.linspace(-1.0, 1.0, len(step))
    states = jnp.asarray(ANGLE), jnp.asarray(RATE)
    slots = Slots(jnp.asarray(u), jnp.asarray(step), jnp.asarray(part))
    found = np.asarray(readings(shown(age), jnp.asarray(H), jnp.asarray(BEGIN), states, slots))
    t = H * (step + part)
    exact = np.stack([BEGIN + t, u, *moved(t), *moved(t - (age or 0.0))], axis=1)
    assert found == pytest.approx(exact, abs=1e-12)


def test_irregular_samples_see_the_motion_of_regular_ones() -> None:
    rng = np.random.default_rng(0)
    fine = np.arange(5001) * 0.002
    u = np.sin(1.3 * fine)
    pick = np.sort(rng.choice(np.arange(1, 5000), size=900, replace=False))
    pick = np.concatenate([[0], pick, [5000]])
    # the command is held between the kept samples: compare with the fine run under that same held command
    held = u[pick][np.searchsorted(pick, np.arange(5001), side="right") - 1]
    reference = run(platform("viscous = 0.02"), record(fine, held), {})["yaw_rad"]
    seen = run(platform("viscous = 0.02"), record(fine[pick], u[pick]), {})["yaw_rad"]
    # one grid step of 5 ms averages the command: acceleration 4 rad/s2 per volt, steps below 0.05 V
    assert np.max(np.abs(seen - reference[pick])) < 0.5 * 4.0 * 0.05 * 0.005


def test_without_inductance_an_irregular_sample_sees_the_current_of_its_own_command() -> None:
    t = np.array([0.0, 0.01, 0.02, 0.03, 0.0427, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1])
    u = np.where(t > 0.0426, -2.0, 2.0)
    y = run(wheel(0.0), record(t, u, {"current_A": np.zeros_like(t)}), {})
    exact = (u - 0.0182 * y["wheel_rad_s"]) / 0.83
    assert np.max(np.abs(y["current_A"] - exact)) < 0.01 * np.ptp(exact)


def test_the_last_current_is_that_of_the_last_command() -> None:
    # without inductance the current follows the voltage at once, at the last sample as at any other
    t = TIME[:51]
    u = np.append(np.full(50, 2.0), -2.0)
    log = record(t, u, {"wheel_rad_s": np.zeros_like(t), "current_A": np.zeros_like(t)})
    y = run(wheel(0.0), log, {})
    assert np.allclose(y["current_A"], (u - 0.0182 * y["wheel_rad_s"]) / 0.83, rtol=1e-12)


def test_a_late_encoder_shows_the_motion_of_a_moment_before() -> None:
    t = np.arange(401) * 0.01
    log = record(t, np.full_like(t, 0.5))
    now = run(platform(), log, {"w": 1.0})["yaw_rad"]
    late = run(platform(), log, {"w": 1.0}, effects={"sensor.delay": {"tau": 0.05}})["yaw_rad"]
    # between grid points the angle is a parabola; the rate is w = 1 rad/s before the log begins
    assert np.max(np.abs(late[5:] - now[:-5])) < 1e-9
    assert np.allclose(late[:5], -0.01 * np.arange(5, 0, -1), atol=1e-12)
