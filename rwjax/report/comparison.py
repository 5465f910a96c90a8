"""The comparison of identification methods as a figure."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rwjax.methods.comparison import Comparison
from rwjax.report.png import write_png
from rwjax.report.style import AFTER, AXIS_LABEL, FLOOR


def draw_comparison(comparison: Comparison) -> Figure:
    """Held-out error of every method by output, the noise floor as a line.

    Args:
        comparison: the methods on the same logs.

    Returns:
        A figure with one panel for each output.
    """
    rows = [row for row in comparison.rows if row.rig is not None]
    signals = list(comparison.floor)
    figure = Figure(figsize=(4.2 * len(signals) + 1.6, 3.2))
    axes = figure.subplots(1, len(signals), squeeze=False, sharey=True)
    for ax, name in zip(axes[0], signals, strict=True):
        errors = np.array([row.rms[name] for row in rows])
        ax.barh(range(len(rows)), np.where(np.isfinite(errors), errors, np.nan), color=AFTER, height=0.6)
        ax.axvline(comparison.floor[name], color=FLOOR, ls="--", lw=1.2)
        ax.set_xscale("log")
        ax.set_xlabel(f"free-run RMS, {AXIS_LABEL[name]}")
        ax.set_yticks(range(len(rows)), [row.method.name for row in rows])
    axes[0][0].invert_yaxis()
    figure.tight_layout()
    return figure


def write_figure(comparison: Comparison, path: Path) -> Path:
    """Draws the comparison into a file.

    Args:
        comparison: the methods on the same logs.
        path: PNG file to write.

    Returns:
        The path.

    Raises:
        InputError: the file cannot be written.
    """
    return write_png(draw_comparison(comparison), path)
