"""rwjax: the four terms, fitted."""

import numpy as np

import rwjax
from experiments.peers.problems import Log, Problem

SAYS = "nothing: the four terms were put in by hand"


def given(p: Problem, log: Log) -> dict[str, np.ndarray]:
    """The columns of the command."""
    return {"voltage_V": log.u[:, 0]} if p.kp is None else {"goal_rad": log.u[:, 0], "supply_V": log.u[:, 1]}


def log_of(p: Problem, rig: rwjax.Rig, log: Log) -> rwjax.Log:
    """A log as rwjax takes it."""
    reading = "yaw_rad_s" if p.reads else "position_rad" if rig.kind == "joint" else "position_m"
    return rwjax.Log.from_arrays(rig, time=log.t, **given(p, log), **{reading: log.y})


def fit(p: Problem) -> rwjax.Rig:
    """The four numbers."""
    rig = rwjax.parse_rig(p.text)
    return rwjax.fit(rig, [log_of(p, rig, p.train)]).rig


def run(p: Problem, rig: rwjax.Rig, log: Log) -> np.ndarray:
    """A free run from the first reading."""
    start, name = ({"w": log.y[0]}, "yaw_rad_s") if p.reads else ({"psi": log.y[0]}, "yaw_rad")
    return np.asarray(rwjax.simulate(rig, log.t, given(p, log), start=start)[name])
