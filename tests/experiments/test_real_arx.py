"""The plain baseline: a linear system made by hand is found again, and what diverges has no finite error."""

import numpy as np
import pytest

from experiments.real.arx import Equation, best, rms
from rwjax.logs.log import Log

STEP = 0.01  # s


def log(name: str, seed: int) -> Log:
    """y[k] = 1.6 y[k-1] - 0.65 y[k-2] + 0.2 u[k-1] + 0.1 u[k-2] + 0.05."""
    u = np.repeat(np.random.default_rng(seed).uniform(-1.0, 1.0, 30), 20)
    y = np.zeros(len(u))
    for k in range(2, len(u)):
        y[k] = 1.6 * y[k - 1] - 0.65 * y[k - 2] + 0.2 * u[k - 1] + 0.1 * u[k - 2] + 0.05
    return Log(name, STEP * np.arange(len(u)), u, {"yaw_rad": y}, {"yaw_rad": 0.0}, {}, False, None, 0.0)


def test_a_linear_system_is_found_again() -> None:
    found = best([log("first.csv", 1)], "yaw_rad")
    assert found.step == pytest.approx(STEP)
    assert rms(found, [log("second.csv", 2)], "yaw_rad") < 1e-3


def test_a_run_that_diverges_is_infinitely_wrong() -> None:
    found = Equation(STEP, 1, np.array([2.0, 1.0, 0.1]))
    assert rms(found, [log("first.csv", 1)], "yaw_rad") == np.inf
