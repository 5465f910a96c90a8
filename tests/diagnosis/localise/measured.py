"""Measured logs and where their gap lies, for tests."""

import numpy as np

from rwjax.diagnosis.localise.where import Where, locate
from rwjax.diagnosis.settings import Settings
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import sizes_of
from rwjax.logs.log import Log
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import Evaluation
from tests.systems import record, run

TIME = np.arange(1001) * 0.01
PUSH = 0.9 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME)
COMMAND = np.where(TIME > 0.6, PUSH, 0.0)
COASTS = np.where(np.mod(TIME, 3.0) < 2.0, COMMAND, 0.0)
NOISE = {"yaw_rad": 2e-4, "yaw_rad_s": 2e-3, "wheel_rad_s": 0.3, "current_A": 0.01}


def as_given(rig: Rig, *logs: Log) -> Fit:
    """The rig's own numbers as a fit."""
    structure = structure_of(rig)
    theta, problem = theta_of(rig, structure), pose(structure, logs)
    free = np.array([name in rig.free for name in structure.names])
    moves = coordinates(theta, free, bounds_of(rig, structure), sizes_of(rig, structure, theta, list(logs)))
    unused = Evaluation(*[np.zeros(0)] * 7)
    return Fit(problem, moves, theta, problem.start, 0.0, unused, True, 0)


def measured(
    rig: Rig, command: np.ndarray, told: np.ndarray, names: tuple[str, ...], seed: int, **effects: dict
) -> Log:
    """Noisy readings of a run under `command` where the log tells of `told`."""
    y = run(rig, record(TIME, command), {}, effects=effects or None)
    rng = np.random.default_rng(seed)
    return record(TIME, told, {name: y[name] + NOISE[name] * rng.normal(size=len(TIME)) for name in names})


def located(rig: Rig, *logs: Log) -> Where:
    found = locate(as_given(rig, *logs), tuple(range(len(logs))), {"time": 1.0}, "time", Settings().localisation)
    assert found is not None
    return found
