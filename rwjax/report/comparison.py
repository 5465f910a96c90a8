"""The comparison of methods as a table and a figure."""

import io
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from rwjax.diagnosis.words import UNIT
from rwjax.methods.comparison import Comparison
from rwjax.report.plots import AFTER, AXIS_LABEL, FLOOR


def table(c: Comparison) -> str:
    """Error on held-out data, numbers with standard errors, time and needs of every method, as text."""
    signals = list(c.floor)
    sheet = Table(box=box.SIMPLE, pad_edge=False)
    for head in ("method", *(f"{name} [{UNIT[name]}]" for name in signals), *c.rig.free, "time [s]", "needs"):
        sheet.add_column(head, no_wrap=head != "needs", justify="left" if head in ("method", "needs") else "right")
    notes = []
    for row in c.rows:
        if row.rig is None:
            cells = ["–"] * (len(signals) + len(c.rig.free))
        else:
            values, spread = row.rig.values, row.rig.standard_error
            cells = [f"{row.rms[name]:.4g}" for name in signals]
            cells += [
                f"{values[name]:.5g} ± {spread[name]:.2g}" if name in spread else f"{values[name]:.5g}"
                for name in c.rig.free
            ]
        sheet.add_row(row.method.name, *cells, f"{row.seconds:.1f}", row.method.needs)
        notes += [f"{row.method.name}: {note}" for note in row.notes]
    sheet.add_row("(floor)", *(f"{c.floor[name]:.4g}" for name in signals), *[""] * (len(c.rig.free) + 2))
    out = io.StringIO()
    console = Console(file=out, width=60 + 24 * (len(signals) + len(c.rig.free)))
    console.print(sheet)
    return f"free-run RMS on held-out data ({c.held_out}); numbers from all logs that may be fitted\n" + "".join(
        f"{line.rstrip()}\n" for line in [*out.getvalue().splitlines(), *notes]
    )


def write_figure(c: Comparison, path: Path) -> Path:
    """Held-out error of every method by output, the floor as a line."""
    rows = [row for row in c.rows if row.rig is not None]
    signals = list(c.floor)
    fig, axes = plt.subplots(1, len(signals), figsize=(4.2 * len(signals) + 1.6, 3.2), squeeze=False, sharey=True)
    for ax, name in zip(axes[0], signals, strict=True):
        value = np.array([row.rms[name] for row in rows])
        ax.barh(range(len(rows)), value, color=AFTER, height=0.6)
        ax.axvline(c.floor[name], color=FLOOR, ls="--", lw=1.2)
        ax.set_xscale("log")
        ax.set_xlabel(f"free-run RMS, {AXIS_LABEL[name]}")
        ax.set_yticks(range(len(rows)), [row.method.name for row in rows])
    axes[0][0].invert_yaxis()
    fig.tight_layout()
    fig.savefig(path, dpi=150)
    plt.close(fig)
    return path
