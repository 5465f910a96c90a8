"""Questions about readings in another unit, or of the other sign, than the rig file's numbers lead to.

No fit finds such a mistake: it bends the numbers instead.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from rwjax.fitting.initial_guess import START_S, starts_at_rest
from rwjax.fitting.problem import Problem
from rwjax.kinds import is_angle
from rwjax.logs.log import Log
from rwjax.simulation.batch import by_sample
from rwjax.simulation.free_run import free_run

ALIKE = 0.8
"""Correlation of measured and simulated motion from which one follows the other [1]."""
UNITS = {
    "_rad": (("degrees", 180.0 / np.pi),),
    "_rad_s": (("1/min", 30.0 / np.pi), ("°/s", 180.0 / np.pi)),
    "_A": (("mA", 1000.0),),
}
"""Units that readings are taken in by mistake, by the end of the column's name: how many of them make the SI unit."""
COUNTED = 180.0 / np.pi
"""Ratio of an angle in degrees to one in rad; a still larger one may be in counts [1]."""
EDGES = 4.0
"""Edges that an encoder counts for each of its lines [1]."""
MILLI = 1e-3
"""Ratio of measured to simulated motion where a command is given in thousandths of its unit [1]."""
ABOUT = 1.6
"""Factor by which the rig file's numbers may be wrong besides [1]."""
GIVEN = "what the rig file's numbers give"


class Question(str):
    """A note that asks whether readings are in another unit or of the other sign."""


def check_units(problem: Problem, theta: np.ndarray) -> list[Question]:
    """Questions about a problem's readings, against a free run.

    Args:
        problem: Logs and structure.
        theta: The rig file's own numbers `(t,)` [SI].

    Returns:
        The questions of `check_readings`.
    """
    y = np.asarray(free_run(problem.structure, theta, problem.start, problem.batch, stepper=problem.stepper)[0])
    names = problem.structure.outputs
    runs = []
    for k, log in enumerate(problem.logs):
        if problem.batch.weight[k].any():
            samples = by_sample(problem.batch, k, y[k], len(log.time))
            runs.append((log, {name: samples[:, j] for j, name in enumerate(names)}))
    return check_readings(runs)


def check_readings(runs: Sequence[tuple[Log, Mapping[str, np.ndarray]]]) -> list[Question]:
    """Questions about readings that contradict a simulation with the rig file's numbers.

    An output is asked about where it moves the other way, or as many times as far as another unit would make it. Its
    size is the median over the logs that begin at rest, where the command alone sets the rig in motion. One question is
    about the command, where all outputs are as if it were given in thousandths.

    Args:
        runs: Logs, each with its simulated readings `(time,)` [SI] by output.

    Returns:
        The questions, one sentence each.
    """
    found, small = [], []
    for name in dict.fromkeys(name for log, _ in runs for name in log.outputs):
        compared = [
            _compare(log, name, simulated[name])
            for log, simulated in runs
            if name in log.outputs and starts_at_rest(log)
        ]
        alike, times = np.median(compared, axis=0) if compared else (0.0, 0.0)
        small.append(abs(alike) > ALIKE and 1.0 / ABOUT < abs(times) / MILLI < ABOUT)
        if abs(alike) > ALIKE:
            if times < 0.0:
                found.append(Question(f"{name} goes against {GIVEN}: is its sign, or that of the command, wrong?"))
            found += _about_size(name, abs(times), counted=any(log.resolution.get(name) for log, _ in runs))
    if small and all(small):
        found.append(Question(f"all readings are a thousandth of {GIVEN}: is the command in mV? Divide it by 1000"))
    return found


def _about_size(name: str, times: float, *, counted: bool) -> list[Question]:
    """Questions about an output that moves so many times as far as simulated; `counted`: by an encoder."""
    found = []
    size = f"{name} is {times:.3g} times {GIVEN}"
    units = next((units for end, units in UNITS.items() if name.endswith(end)), ())
    for unit, many in units:
        if 1.0 / ABOUT < times / many < ABOUT:
            found.append(Question(f"{size}: are the readings in {unit}? Divide them by {many:.5g}"))
    if counted:
        for many, do in ((EDGES, "times 4"), (1.0 / EDGES, "divided by 4")):
            if 1.0 / ABOUT < times / many < ABOUT:
                found.append(Question(f"{size}: a line has 4 edges; should its encoder's counts_per_rev be {do}?"))
    if is_angle(name) and times > ABOUT * COUNTED:
        turn, column = f"about {2.0 * np.pi * times:.2g} to a turn", name.removesuffix("_rad") + "_counts"
        found.append(Question(f"{size}: are the readings counts, {turn}? Their column is called {column}"))
    return found


def _compare(log: Log, name: str, simulated: np.ndarray) -> tuple[float, float]:
    """Correlation of measured and simulated motion, and how many times the simulated one the measured one is."""
    a, b = (_motion(log, name, values) for values in (log.outputs[name], simulated))
    seen = np.isfinite(a) & np.isfinite(b)
    a, b = a[seen], b[seen]
    own, both = float(b @ b), float(a @ b)
    return (both / np.sqrt(own * float(a @ a)), both / own) if both else (0.0, 0.0)


def _motion(log: Log, name: str, values: np.ndarray) -> np.ndarray:
    """A rate as it is; for an angle its change within 0.5 s, since a free axis drifts."""
    if not is_angle(name):
        return values
    later = np.searchsorted(log.time, log.time + START_S)
    first = np.flatnonzero(later < len(log.time))
    return values[later[first]] - values[first]
