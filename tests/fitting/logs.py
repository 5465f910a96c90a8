"""Runs and logs that several tests of the fit share."""

from dataclasses import replace

import numpy as np

from rwjax import Log
from rwjax.rig.model import Rig
from tests.systems import record, run

TIME = np.arange(1001) * 0.01


FREE = '"axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'


ALL = '"drive.gain", "axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'


def log_of(rig, command=None, noise: float = 0.0, **more):
    u = np.where(TIME > 0.6, 0.6 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME), 0.0)
    u = u if command is None else command
    y = run(rig, record(TIME, u), {})["yaw_rad"]
    return record(TIME, u, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, noise, len(y))}, **more)


def runs_of(rig: Rig, inertias: list[float]) -> list[Log]:
    """One run of the rig for each inertia, named `a.csv`, `b.csv`, …"""
    truths = [rig.with_values({"axis.inertia": inertia}) for inertia in inertias]
    logs = [log_of(truth, noise=1e-3) for truth in truths]
    return [replace(log, name=f"{name}.csv") for name, log in zip("abcdef", logs, strict=False)]


def red(samples: int, rho: float, size: float, seed: int) -> np.ndarray:
    """Correlated noise of a standard deviation."""
    white = np.random.default_rng(seed).normal(0.0, size * np.sqrt(1.0 - rho**2), samples)
    red = np.zeros(samples)
    for k in range(1, samples):
        red[k] = rho * red[k - 1] + white[k]
    return red
