"""The command `run-experiment`: the board plays an experiment or a plan, and what it sends is recorded."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.options import finite, of_file, results
from rwjax.cli.recording import (
    Port,
    Quiet,
    RigFile,
    check_output,
    needs_pyserial,
    read_board_rig,
    record_task,
    role_note,
)
from rwjax.cli.terminal import note
from rwjax.errors import InputError

LOGS = Path("logs")
"""Folder of a plan's logs where the user names none."""


class Kind(StrEnum):
    """Experiments that the board plays."""

    COAST_DOWN = "coast-down"
    SQUARE = "square"
    TRIANGLE = "triangle"
    STAIRCASE = "staircase"
    MULTISINE = "multisine"


DEFAULTS: dict[str, float] = {"volts": 2.0, "offset": 0.0, "period": 4.0, "seconds": 16.0}
"""Of one experiment [V and s], where the user gives nothing."""
Kinds = Annotated[Kind | None, typer.Option(help="what the board plays", show_default=False)]
PlanFile = Annotated[
    Path | None, typer.Option(metavar="PLAN", help="plays the runs of a plan instead: its file or folder")
]
Runs = Annotated[
    list[str] | None, typer.Option("--run", metavar="NAME", help="only this run of the plan; may be repeated")
]
Output = Annotated[
    Path | None,
    typer.Option("-o", metavar="LOG.csv", help="the log, run.csv by default; of a plan the folder of its logs, logs"),
]
Volts = Annotated[float | None, typer.Option(help="amplitude [V]; 2 by default")]
Offset = Annotated[float | None, typer.Option(help="added to it [V]; 0 by default")]
Period = Annotated[
    float | None, typer.Option(help="seconds; coast-down: of drive before the wheel runs free; 4 by default")
]
Seconds = Annotated[float | None, typer.Option(help="length, after 0.6 s of rest; 16 by default")]
Role = Annotated[str | None, typer.Option(help="`validate` keeps the log out of fit and choice")]
Clear = Annotated[bool, typer.Option("--clear", help="clear a latched fault first")]


def run_experiment(
    rig_file: RigFile,
    port: Port,
    kind: Kinds = None,
    plan: PlanFile = None,
    runs: Runs = None,
    output: Output = None,
    volts: Volts = None,
    offset: Offset = None,
    period: Period = None,
    seconds: Seconds = None,
    role: Role = None,
    clear: Clear = False,
    quiet: Quiet = False,
) -> None:
    """Arm the board, let it play an experiment or the runs of a plan, record, disarm. THE RIG MOVES.

    Example: `rwjax run-experiment rig.toml /dev/ttyACM0 --plan plan -o logs`
    """
    if (plan is None) == (kind is None):
        raise InputError("give either --kind for one experiment or --plan for the runs of a plan")
    numbers = {"volts": volts, "offset": offset, "period": period, "seconds": seconds}
    single = {**numbers, "role": role}
    if plan is not None and (given := next((name for name, value in single.items() if value is not None), None)):
        raise InputError(f"--{given}: belongs to one experiment; a plan says it for each run")
    finite(**{name: value for name, value in numbers.items() if value is not None})
    if plan is None and runs:
        raise InputError("--run: belongs to a plan; give one with --plan")
    needs_pyserial()
    if plan is not None:
        _play_plan(rig_file, port, plan, runs, output or LOGS, clear, quiet)
    elif kind is not None:
        wanted = DEFAULTS | {name: value for name, value in numbers.items() if value is not None}
        _play_one(rig_file, port, kind, wanted, role or "train", output or Path("run.csv"), clear, quiet)


def _play_plan(
    rig_file: Path, port: str, plan: Path, runs: list[str] | None, output: Path, clear: bool, quiet: bool
) -> None:
    """Records the runs of a plan one after the other, all of which are checked before the first."""
    from rwjax.link.play_plan import check_plan, tasks_of_plan
    from rwjax.link.recorder import check_new
    from rwjax.planning.envelope import rad_and_degrees
    from rwjax.planning.files import read_plan

    wanted = read_plan(plan)
    with of_file(plan):
        wanted = wanted.only(runs) if runs else wanted
    rig = read_board_rig(rig_file)
    with of_file(plan):
        tasks = tasks_of_plan(wanted, rig, clear)
    for run in wanted.runs:
        check_new(output / f"{run.name}.csv")
    check_plan(port, wanted, rig)
    if (travel := wanted.limits.get("yaw_rad")) is not None:
        followed = "" if "axis" in rig.counts_per_rev else ", and no encoder of the axis tells whether it keeps to it"
        note(f"the axis has to stand in the middle of its travel of {rad_and_degrees(travel)} either way now{followed}")
    with results(output) as folder:
        for run, task in zip(wanted.runs, tasks, strict=True):
            if stopped := record_task(rig, port, folder / f"{run.name}.csv", run.notes, task, quiet):
                raise stopped


def _play_one(
    rig_file: Path,
    port: str,
    kind: Kind,
    wanted: dict[str, float],
    role: str,
    output: Path,
    clear: bool,
    quiet: bool,
) -> None:
    """Records one experiment."""
    from rwjax.link.play_experiment import play
    from rwjax.link.play_plan import Task
    from rwjax.link.rest import at_rest
    from rwjax.planning.experiment import Experiment

    check_output(output)
    experiment = Experiment(kind.value, wanted["volts"], wanted["offset"], wanted["period"], wanted["seconds"])
    rig = read_board_rig(rig_file)
    notes = {"experiment": experiment.words(), **role_note(role)}
    if stopped := record_task(rig, port, output, notes, Task(at_rest, play(experiment, rig, clear)), quiet):
        raise stopped
