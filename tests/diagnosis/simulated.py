"""Logs of a simulated platform, and fits to them, for tests of the diagnosis."""

from dataclasses import replace

import numpy as np

from rwjax import Log
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.settings import Settings
from rwjax.fitting.batched_runs import together
from rwjax.fitting.secant import with_residual
from rwjax.rig.model import Rig
from tests.systems import record, run

TIME = np.arange(2001) * 0.01
COMMAND = np.where(TIME > 0.6, 0.9 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME), 0.0)


def true_log(rig: Rig, noise: float = 2e-4, **effects: dict) -> Log:
    """What the rig with some effects would have read under `COMMAND`."""
    y = run(rig, record(TIME, COMMAND), {}, effects=effects or None)["yaw_rad"]
    return record(TIME, COMMAND, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, noise, len(y))})


def fits_of(rig: Rig, log: Log, settings: Settings | None = None) -> ModelFits:
    """Fits to one log."""
    return ModelFits.of(rig, [log], [0], settings)


def moved_to(fits: ModelFits, hypothesis: Hypothesis, numbers: dict[str, float], *, ended: bool = False) -> None:
    """Puts the best fit of a hypothesis at other numbers."""
    best = fits.known(hypothesis)
    theta = best.theta.copy()
    for name, value in numbers.items():
        theta[best.problem.structure.names.index(name)] = value
    fits.put(hypothesis, together([with_residual(replace(best, theta=theta))])[0], ended=ended)
