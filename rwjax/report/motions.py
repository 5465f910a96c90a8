"""The motion of the held-out runs as the page's script draws it: numbers that can be zoomed into."""

from typing import Any

import numpy as np

from rwjax.diagnosis.result import Diagnosis
from rwjax.report.style import AFTER, AXIS_LABEL, BEFORE, FLOOR

MOST_SAMPLES = 40_000
"""Samples on the page, over all runs: with 9 characters a number and 4 curves 1.4 MB."""
DIGITS = 5
"""Significant digits of what is read off a figure."""


def motions(d: Diagnosis) -> list[dict[str, Any]]:
    """Measured and simulated motion of every held-out run that has read the headline signal, the worst run first.

    Args:
        d: the diagnosis.

    Returns:
        A dictionary for each run: `name`, `label` of the signal with its unit, `time` [s] from its first sample, and `curves`, each with
        `label`, `colour`, `width` [pixel], `dash` and `values` in the signal's unit, None where nothing was read. Where the runs hold more than
        `MOST_SAMPLES` samples, every second one, third one and so on.
    """
    held = {k: e[d.signal] for k, e in d.before.error.items() if d.signal in e and np.isfinite(e[d.signal]).any()}
    stride = -(-sum(map(len, held.values())) // MOST_SAMPLES)
    found = []
    for k in sorted(held, key=lambda k: -float(np.nanmean(held[k] ** 2))):
        log = d.logs[k]
        measured = log.outputs[d.signal]
        curves: list[tuple[str, str, float, list[int] | None, np.ndarray]] = [
            ("measured", FLOOR, 4.0, None, measured),
            ("rig as it is", BEFORE, 1.5, None, measured - held[k]),
        ]
        if d.effects:
            curves.append(("with the effects", AFTER, 1.5, [6, 3], measured - d.after.error[k][d.signal]))
        found.append(
            {
                "name": log.name,
                "label": AXIS_LABEL[d.signal],
                "time": _plain(log.time[::stride] - log.time[0]),
                "curves": [
                    {"label": label, "colour": colour, "width": width, "dash": dash, "values": _plain(values[::stride])}
                    for label, colour, width, dash, values in curves
                ],
            }
        )
    return found


def _plain(values: np.ndarray) -> list[float | None]:
    """Numbers as JSON has them, with the digits that a figure shows."""
    return [float(f"{x:.{DIGITS}g}") if np.isfinite(x) else None for x in values]
