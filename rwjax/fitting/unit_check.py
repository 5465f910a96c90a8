"""Readings in another unit or of the other sign than the rig file's numbers make them: no fit finds such a mistake."""

from collections.abc import Mapping, Sequence

import numpy as np

from rwjax.fitting.initial_guess import START_S, starts_at_rest
from rwjax.fitting.problem import Problem
from rwjax.kinds import is_angle
from rwjax.logs.log import Log
from rwjax.simulation.batch import by_sample
from rwjax.simulation.shooting import free_run

ALIKE = 0.8
"""Correlation of measured and simulated motion from which the one follows the other."""
UNITS = {
    "_rad": (("degrees", 180.0 / np.pi),),
    "_rad_s": (("1/min", 30.0 / np.pi), ("°/s", 180.0 / np.pi)),
    "_A": (("mA", 1000.0),),
}
"""Units that readings are taken in by mistake, by the end of the column's name: how many of them make one of the right."""
COUNTED = 180.0 / np.pi
"""Times that an angle in degrees is one in rad; what is even larger may be counted."""
EDGES = 4.0
"""Edges that an encoder counts for each of its lines."""
MILLI = 1e-3
"""What is seen of the motion where a command is given in thousandths of its unit."""
ABOUT = 1.6
"""Factor by which the rig file's numbers may be off besides."""
GIVEN = "what the rig file's numbers give"


class Question(str):
    """A note that asks whether readings are of another unit or sign."""


def check_units(problem: Problem, theta: np.ndarray) -> list[Question]:
    """`check_readings` of a problem's logs, simulated with the rig's own numbers `theta`."""
    y = np.asarray(free_run(problem.structure, theta, problem.start, problem.batch)[0])
    names = problem.structure.outputs
    runs = []
    for k, log in enumerate(problem.logs):
        if problem.batch.weight[k].any():
            samples = by_sample(problem.batch, k, y[k], len(log.time))
            runs.append((log, {name: samples[:, j] for j, name in enumerate(names)}))
    return check_readings(runs)


def check_readings(runs: Sequence[tuple[Log, Mapping[str, np.ndarray]]]) -> list[Question]:
    """A sentence for every output that goes the other way than in a simulation with the rig file's numbers, or as many times
    as far as another unit would make it: the median over the logs that begin at rest, where the command alone sets the rig in
    motion; and one where all of them are as if the command were given in thousandths. `runs`: logs, each with the simulated
    readings by output."""
    found, small = [], []
    for name in dict.fromkeys(name for log, _ in runs for name in log.outputs):
        told = [
            _compare(log, name, simulated[name])
            for log, simulated in runs
            if name in log.outputs and starts_at_rest(log)
        ]
        alike, times = np.median(told, axis=0) if told else (0.0, 0.0)
        small.append(abs(alike) > ALIKE and 1.0 / ABOUT < abs(times) / MILLI < ABOUT)
        if not abs(alike) > ALIKE:
            continue
        if times < 0.0:
            found.append(Question(f"{name} goes against {GIVEN}: is its sign, or that of the command, wrong?"))
        size = f"{name} is {abs(times):.3g} times {GIVEN}"
        units = next((units for end, units in UNITS.items() if name.endswith(end)), ())
        for unit, many in units:
            if 1.0 / ABOUT < abs(times) / many < ABOUT:
                found.append(Question(f"{size}: are the readings in {unit}? Divide them by {many:.5g}"))
        if any(log.resolution.get(name) for log, _ in runs):
            for many, do in ((EDGES, "times 4"), (1.0 / EDGES, "divided by 4")):
                if 1.0 / ABOUT < abs(times) / many < ABOUT:
                    found.append(Question(f"{size}: a line has 4 edges; should its encoder's counts_per_rev be {do}?"))
        if is_angle(name) and abs(times) > ABOUT * COUNTED:
            turn, column = f"about {2.0 * np.pi * abs(times):.2g} to a turn", name.removesuffix("_rad") + "_counts"
            found.append(Question(f"{size}: are the readings counts, {turn}? Their column is called {column}"))
    if small and all(small):
        found.append(Question(f"all readings are a thousandth of {GIVEN}: is the command in mV? Divide it by 1000"))
    return found


def _compare(log: Log, name: str, simulated: np.ndarray) -> tuple[float, float]:
    """Correlation of measured and simulated motion, and how many times the one is the other."""
    a, b = (_motion(log, name, values) for values in (log.outputs[name], simulated))
    seen = np.isfinite(a) & np.isfinite(b)
    a, b = a[seen], b[seen]
    own, both = float(b @ b), float(a @ b)
    return (both / np.sqrt(own * float(a @ a)), both / own) if both else (0.0, 0.0)


def _motion(log: Log, name: str, values: np.ndarray) -> np.ndarray:
    """A rate as it is; of an angle what it changes within 0.5 s, since a free axis drifts."""
    if not is_angle(name):
        return values
    later = np.searchsorted(log.time, log.time + START_S)
    first = np.flatnonzero(later < len(log.time))
    return values[later[first]] - values[first]
