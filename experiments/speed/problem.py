"""The benchmark's problem: a platform that sticks and slips, logged in counts, and the same arrays for every contender."""

from dataclasses import astuple, dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from experiments.blind.simulator import STEP, Truth, simulate
from rwjax.fitting.coordinates import Coordinates, coordinates
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.scales import sizes_of
from rwjax.logs.log import Log
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.rig.read import parse_rig
from rwjax.simulation.batch import by_sample

TICK = 0.01  # s
COUNT = 2.0 * np.pi / 2048
TRUTH = Truth(kind=1, gain=0.428, I=0.228, viscous=0.082, coulomb=0.09)
FREE = ("axis.inertia", "axis.friction.viscous", "axis.friction.coulomb")
TRUE = np.array([TRUTH.I, TRUTH.viscous, TRUTH.coulomb])
BELIEVED = TRUE * (0.6, 2.0, 1.5)
FIRST_STATE = (0.1, 0.4)  # rad, rad/s: the log begins in motion, so that both are free

RIG = """
kind = "platform"
[drive]
gain = {gain}
[axis]
inertia = {inertia}
[axis.friction]
viscous = {viscous}
coulomb = {coulomb}
[encoder]
counts_per_rev = 2048
[fit]
free = ["axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"]
"""


def rig(believed: np.ndarray = BELIEVED) -> Rig:
    """The rig file with inertia, viscous and dry friction as believed."""
    inertia, viscous, coulomb = (float(v) for v in believed)
    return parse_rig(RIG.format(gain=TRUTH.gain, inertia=inertia, viscous=viscous, coulomb=coulomb))


class Added(NamedTuple):
    """An effect for the curve over active effects: in the true rig, as believed, and which of its numbers are free."""

    name: str
    truth: dict[str, float]
    believed: dict[str, float]
    free: tuple[str, ...]


STRIBECK = Added(
    "axis.stribeck",
    {"excess": 0.03, "v_s": 0.3},
    {"M_c": 0.0, "M_e": 0.05, "v_s": 0.2},
    ("M_e", "v_s"),
)
EFFECTS = (
    Added("axis.bias_torque", {"bias_torque": 0.01}, {"T": 0.005}, ("T",)),
    Added("drive.deadzone", {"deadzone": 0.05}, {"u_0": 0.08}, ("u_0",)),
    STRIBECK,
    Added("drive.delay", {"delay": 0.02}, {"tau": 0.03}, ("tau",)),
)


def with_effects(*added: Added) -> tuple[Rig, Truth]:
    """The believed rig with some effects, and the true one."""
    base, truth = rig(), TRUTH
    for effect in added:
        truth = replace(truth, **effect.truth)
        free = (*base.free, *(f"{effect.name}.{number}" for number in effect.free))
        base = replace(base, effects=base.effects | {effect.name: effect.believed}, free=free)
    return base, truth


def command(samples: int, seed: int = 0) -> np.ndarray:
    """A switched level with a multisine and rests at 0 V in it [V]."""
    t = np.arange(samples) * TICK
    rng = np.random.default_rng(seed)
    u = 0.5 * np.sign(np.sin(2 * np.pi * t / 7.3 + 0.3))
    for f in (0.11, 0.23, 0.41, 0.73, 1.3):
        u += 0.12 * np.sin(2 * np.pi * f * t + rng.uniform(0.0, 2 * np.pi))
    return np.round(np.where(np.mod(t, 19.0) > 14.5, 0.0, u), 3)


def log(seconds: float = 60.0, seed: int = 0, truth: Truth = TRUTH) -> Log:
    """Log of a simulated run, in counts."""
    return _log(seconds, seed, astuple(truth))


@cache
def _log(seconds: float, seed: int, truth: tuple) -> Log:
    samples = round(seconds / TICK)
    t, u = np.arange(samples) * TICK, command(samples, seed)
    x = simulate(t, u, t, np.array([*FIRST_STATE, 0.0, 0.0, 0.0]), Truth(*truth).array(), STEP)
    psi = COUNT * np.round(x[:, 0] / COUNT)
    return Log(
        name=f"{seconds:g} s",
        time=t,
        command=u,
        outputs={"yaw_rad": psi},
        resolution={"yaw_rad": COUNT},
        notes={},
        validate=False,
        supply=None,
        origin=0.0,
    )


@dataclass(frozen=True)
class Arrays:
    """What a contender gets: command and readings with their weight at 100 Hz, the grid step, the start of the fit.

    The residual is `weight * (simulated - reading)`; `believed` (3,) the numbers, `first` (2,) the initial state.
    """

    command: np.ndarray
    reading: np.ndarray
    weight: np.ndarray
    step: float
    substeps: int
    believed: np.ndarray
    first: np.ndarray


def posed(record: Log, r: Rig | None = None) -> tuple[Problem, Coordinates, np.ndarray]:
    """Problem, coordinates and numbers as `fit` makes them; without a rig, of the one believed."""
    r = rig() if r is None else r
    structure = structure_of(r)
    theta = theta_of(r, structure)
    free = np.array([name in r.free for name in structure.names])
    moves = coordinates(theta, free, bounds_of(r, structure), sizes_of(r, structure, theta, [record]))
    return pose(structure, (record,)), moves, theta


def arrays(record: Log) -> Arrays:
    """The problem of a log without anything of the library in it."""
    problem, _, _ = posed(record)
    n = len(record.time)
    step = float(problem.batch.h[0])
    return Arrays(
        command=record.command,
        reading=record.outputs["yaw_rad"],
        weight=by_sample(problem.batch, 0, problem.batch.weight[0, :, :, :1], n)[:, 0],
        step=step,
        substeps=round(TICK / step),
        believed=BELIEVED.copy(),
        first=problem.start[0].copy(),
    )


def first_states(reading: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Angle and rate at some samples by parabolas through 15 readings, for contenders that need a state per window."""
    found = []
    for s in starts:
        first, last = max(0, s - 7), min(len(reading), s + 8)
        c = np.polyfit((np.arange(first, last) - s) * TICK, reading[first:last], 2)
        found.append((c[2], c[1]))
    return np.array(found)
