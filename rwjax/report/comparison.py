"""The comparison of identification methods, as a table and a figure."""

import io
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from rich import box
from rich.console import Console
from rich.table import Table

from rwjax.diagnosis.words import UNIT
from rwjax.methods.comparison import Comparison, Row
from rwjax.report.style import AFTER, AXIS_LABEL, FLOOR


def table(comparison: Comparison) -> str:
    """Error on held-out data, estimates, time and needs of every method, as text.

    Args:
        comparison: the methods on the same logs.

    Returns:
        A heading, a table with one row for each method and one for the noise floor, and the methods' notes.
    """
    signals, free = list(comparison.floor), comparison.rig.free
    sheet = Table(box=box.SIMPLE, pad_edge=False)
    for head in ("method", *(f"{name} [{UNIT[name]}]" for name in signals), *free, "time [s]", "needs"):
        sheet.add_column(head, no_wrap=head != "needs", justify="left" if head in ("method", "needs") else "right")
    for row in comparison.rows:
        sheet.add_row(row.method.name, *_cells(row, signals, free), f"{row.seconds:.1f}", row.method.needs)
    sheet.add_row("(floor)", *(f"{comparison.floor[name]:.4g}" for name in signals), *[""] * (len(free) + 2))
    notes = [f"{row.method.name}: {note}" for row in comparison.rows for note in row.notes]
    out = io.StringIO()
    Console(file=out, width=60 + 24 * (len(signals) + len(free))).print(sheet)
    head = f"free-run RMS on held-out data ({comparison.held_out}); numbers from all logs that may be fitted\n"
    return head + "".join(f"{line.rstrip()}\n" for line in [*out.getvalue().splitlines(), *notes])


def _cells(row: Row, signals: list[str], free: tuple[str, ...]) -> list[str]:
    """Errors and estimates of a method; dashes where it could not be used."""
    if row.rig is None:
        return ["–"] * (len(signals) + len(free))
    values, error = row.rig.values, row.rig.standard_error
    estimates = [f"{values[name]:.5g}" + (f" ± {error[name]:.2g}" if name in error else "") for name in free]
    return [*(f"{row.rms[name]:.4g}" for name in signals), *estimates]


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
        ax.barh(range(len(rows)), np.array([row.rms[name] for row in rows]), color=AFTER, height=0.6)
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
        path: file to write; its ending names the format.

    Returns:
        The path.
    """
    draw_comparison(comparison).savefig(path, dpi=150)
    return path
