"""The plan of a campaign as a table for the terminal."""

import io
import math
from collections.abc import Callable
from itertools import groupby

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from rwjax.kinds import GOAL
from rwjax.planning.experiment import Experiment
from rwjax.planning.files import Plan

RPM = 30.0 / math.pi  # 1/min per rad/s
SHOWN: dict[str, tuple[str, Callable[[float], str]]] = {
    "yaw_rad": ("travel\n[rad]", lambda angle: f"{angle:.3g}"),
    "yaw_rad_s": ("rate\n[rad/s]", lambda rate: f"{rate:.3g}"),
    "wheel_rad_s": ("wheel\n[1/min]", lambda rate: f"{RPM * rate:.0f}"),
    "current_A": ("current\n[A]", lambda current: f"{current:.3g}"),
}
"""Outputs whose peaks are shown, with head and format."""
WIDTH = 120
"""Characters of a line of the table."""


def table(plan: Plan) -> str:
    """A plan's runs with their commands, the peaks that they reach in simulation, and what they are for.

    Args:
        plan: the plan; runs that repeat each other share a row.

    Returns:
        The table, one line for each row.
    """
    outputs = [name for name in SHOWN if all(name in run.reaches for run in plan.runs)]
    sheet = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
    columns = {run.experiment.input for run in plan.runs}
    given = "goal\n[rad]" if GOAL in columns else "volts\n[V]"
    for head in ("run", given, "period\n[s]", "length\n[s]", *(SHOWN[name][0] for name in outputs), "for"):
        sheet.add_column(Text(head), no_wrap=head != "for", justify="left" if head in ("run", "for") else "right")
    for _, alike in groupby(plan.runs, key=lambda run: (run.experiment, run.role, run.why)):
        runs = list(alike)
        e, name = runs[0].experiment, runs[0].name + (f" … {runs[-1].name[-1]}" if len(runs) > 1 else "")
        peaks = (SHOWN[output][1](runs[0].reaches[output]) for output in outputs)
        sheet.add_row(Text(name), volts(e), f"{e.period:g}", f"{e.length:g}", *peaks, Text(runs[0].why))
    out = io.StringIO()
    Console(file=out, width=WIDTH).print(sheet)
    return "".join(f"{line.rstrip()}\n" for line in out.getvalue().split("\n") if line.strip())


def volts(experiment: Experiment) -> str:
    """The size of a command, in volts or of a goal in rad.

    Args:
        experiment: the command.

    Returns:
        The level of a coast-down; of any other kind its amplitude, and the offset if there is one.
    """
    amplitude, offset = experiment.amplitude, experiment.offset
    if experiment.kind == "coast-down":
        return f"{amplitude + offset:.3g}"
    return f"±{abs(amplitude):.3g}" + (f" about {offset:.3g}" if offset else "")
