"""Readings in another unit or of the other sign than the rig file's numbers make them: no fit finds such a mistake."""

import numpy as np

from rwjax.fit.problem import START_S, Problem, starts_at_rest
from rwjax.grid import by_sample
from rwjax.log import Log
from rwjax.rig_names import is_angle
from rwjax.simulate import free_run

ALIKE = 0.8
"""Correlation of measured and simulated motion from which the one follows the other."""
UNITS = {
    "_rad": (("degrees", 180.0 / np.pi),),
    "_rad_s": (("1/min", 30.0 / np.pi), ("°/s", 180.0 / np.pi)),
    "_A": (("mA", 1000.0),),
}
"""Units that readings are taken in by mistake, by the end of the column's name: how many of them make one of the right."""
ABOUT = 1.6
"""Factor by which the rig file's numbers may be off besides."""


def mistaken(problem: Problem, theta: np.ndarray) -> list[str]:
    """A sentence for every output that goes the other way than the rig's own numbers `theta` say, or as many times as far
    as another unit would make it: the median over the logs that begin at rest, where the command alone sets the rig in
    motion."""
    y = np.asarray(free_run(problem.structure, theta, problem.start, problem.batch)[0])
    found = []
    for j, name in enumerate(problem.structure.outputs):
        told = [
            _compare(log, name, by_sample(problem.batch, k, y[k, ..., j], len(log.time)))
            for k, log in enumerate(problem.logs)
            if name in log.outputs and problem.batch.weight[k].any() and starts_at_rest(log)
        ]
        alike, times = np.median(told, axis=0) if told else (0.0, 0.0)
        if not abs(alike) > ALIKE:
            continue
        if times < 0.0:
            found.append(
                f"{name} goes against what the rig file's numbers give: is its sign, or that of the command, wrong?"
            )
        for unit, many in next((units for end, units in UNITS.items() if name.endswith(end)), ()):
            if 1.0 / ABOUT < abs(times) / many < ABOUT:
                found.append(
                    f"{name} is {abs(times):.3g} times what the rig file's numbers give: are the readings in {unit}? "
                    f"Divide them by {many:.5g}"
                )
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
