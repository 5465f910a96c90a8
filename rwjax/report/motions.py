"""The motion of the held-out runs as the page's script draws it: numbers that can be zoomed into."""

import math
from collections import Counter
from typing import Any

import numpy as np

from rwjax.diagnosis.result import Diagnosis
from rwjax.errors import printable
from rwjax.report.plots import held_out_errors
from rwjax.report.style import AFTER, AXIS_LABEL, BEFORE, MEASURED_WIDE

MOST_SAMPLES = 40_000
"""Samples of one run on the page: 4 curves of 9 characters a number are 1.4 MB."""
OF_FLOOR = 0.1
"""Rounding of readings, in floors [1]: finer than what a reader zooms in for."""
OF_STEP = 0.01
"""Rounding of times, in steps between samples [1]."""


def motions(d: Diagnosis) -> list[dict[str, Any]]:
    """Measured and simulated motion of every held-out run, or segment of one, that has read the headline signal, the worst first.

    Args:
        d: the diagnosis.

    Returns:
        A dictionary for each: `name`, with the time at which a segment begins [s]; `label` of the signal with its unit; `every`, of how many
        samples one is drawn, more than 1 beyond `MOST_SAMPLES`; `time` [s] as in the log; and `curves`, each with `label`, `colour`,
        `width` [pixel], `dash` and `values` in the signal's unit, None where nothing was read.
    """
    held = held_out_errors(d)
    names = Counter(d.logs[k].name for k in held)
    return [_motion(d, k, error, of_several=names[d.logs[k].name] > 1) for k, error in held.items()]


def _motion(d: Diagnosis, k: int, error: np.ndarray, of_several: bool) -> dict[str, Any]:
    """The motion of one run or segment."""
    log, every = d.logs[k], -(-len(error) // MOST_SAMPLES)
    measured = log.outputs[d.signal]
    curves: list[tuple[str, str, float, list[int] | None, np.ndarray]] = [
        ("measured", MEASURED_WIDE, 4.0, None, measured),
        ("rig as it is", BEFORE, 1.5, None, measured - error),
    ]
    if d.effects:
        curves.append(("with the effects", AFTER, 1.5, [6, 3], measured - d.after.error[k][d.signal]))
    step = float(np.median(np.diff(log.time))) if len(log.time) > 1 else 1.0
    return {
        "name": printable(f"{log.name} from {log.time[0]:.4g} s" if of_several else log.name),
        "label": AXIS_LABEL[d.signal],
        "every": every,
        "time": _plain(log.time[::every], OF_STEP * step),
        "curves": [
            {
                "label": label,
                "colour": colour,
                "width": width,
                "dash": dash,
                "values": _plain(values[::every], OF_FLOOR * d.gaps[d.signal].floor),
            }
            for label, colour, width, dash, values in curves
        ],
    }


def _plain(values: np.ndarray, to: float) -> list[float | None]:
    """Numbers as JSON has them, with the decimals that tell steps of `to`."""
    decimals = max(-math.floor(math.log10(to)), 0) if to > 0.0 else 9
    return [round(float(x), decimals) if np.isfinite(x) else None for x in values]
