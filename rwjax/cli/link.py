"""The commands that talk to a board: `rwjax record`, `run-experiment`, `monitor`; and `decode`, for what one left behind."""

import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import finite, of_file, results
from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.link.play_plan import Task
    from rwjax.rig.model import Rig

RigFile = Annotated[Path, typer.Argument(metavar="RIG", help="rig file (TOML) with `drive.pwm`", show_default=False)]
Port = Annotated[str, typer.Argument(metavar="PORT", help="serial port, such as /dev/ttyACM0", show_default=False)]
Output = Annotated[Path, typer.Option("-o", metavar="LOG.csv", help="the log; beside it .raw and .notes")]
Role = Annotated[str, typer.Option(help="`validate` keeps the log out of fit and choice")]
LOGS = Path("logs")
Quiet = Annotated[bool, typer.Option("--quiet", help="no live view")]


class Kind(StrEnum):
    """Experiments that the board plays."""

    COAST_DOWN = "coast-down"
    SQUARE = "square"
    TRIANGLE = "triangle"
    STAIRCASE = "staircase"
    MULTISINE = "multisine"


def add_to(app: typer.Typer) -> None:
    """Makes these commands known."""
    app.command()(record)
    app.command(name="run-experiment")(run_experiment)
    app.command()(monitor)
    app.command()(decode)


@contextmanager
def _live(rig: "Rig", quiet: bool) -> Iterator[Callable[..., None]]:
    """The live view on a terminal, nothing otherwise."""
    from rich.console import Console
    from rich.live import Live

    from rwjax.link.monitor import View, table

    console, view = Console(stderr=True), View(rig)
    if quiet or not console.is_terminal:
        yield lambda session, sample: None
        return
    with Live(get_renderable=lambda: table(view), console=console, refresh_per_second=5):
        yield view


def _needs_pyserial() -> None:
    try:
        import serial  # noqa: F401
    except ImportError:
        raise InputError("this command talks to a serial port and needs pyserial: pip install pyserial") from None


def _notes(role: str) -> dict[str, str]:
    if role not in ("train", "validate"):
        raise InputError(f"--role {role}: is unknown; it is `train` or `validate`")
    return {"role": role}


def _check(output: Path) -> None:
    from rwjax.link.stream_to_logs import refuse_existing

    if output.suffix != ".csv":
        raise InputError(f"{output}: a log's name ends in .csv")
    refuse_existing(output)


def _record(
    rig: "Rig", port: str, output: Path, notes: dict[str, str], task: "Task", quiet: bool
) -> KeyboardInterrupt | None:
    """Records, and says what is on disk now; raises what ended the recording early, but for Ctrl-C."""
    from rwjax.link.recorder import record as run

    with _live(rig, quiet) as watch:
        done = run(port, rig, output, notes, task.act, watch, task.ready)
    for path in done.logs:
        print(path)
    for remark in done.remarks:
        print(f"note: {remark}", file=sys.stderr)
    raw = output.with_suffix(".raw")
    if isinstance(done.failure, InputError):
        raise InputError(
            f"{done.failure}; {raw} holds all that came" + (", the logs what it shows" if done.logs else "")
        )
    if isinstance(done.failure, Exception):
        raise done.failure
    if not done.logs:
        raise InputError(f"{output}: no log; {raw} holds all that came")
    return done.failure


def record(
    rig: RigFile,
    port: Port,
    output: Output = Path("run.csv"),
    seconds: Annotated[float | None, typer.Option(min=0.1, help="until Ctrl-C without it")] = None,
    role: Role = "train",
    quiet: Quiet = False,
) -> None:
    """Record what the board sends, without arming it."""
    if seconds is not None:
        finite(seconds=seconds)
    _needs_pyserial()
    from rwjax.link.play_plan import Task
    from rwjax.link.recorder import listen
    from rwjax.rig.read import read_one_axis_rig

    _check(output)
    task = Task(lambda session: {}, listen(seconds))
    _record(read_one_axis_rig(rig), port, output, _notes(role), task, quiet)  # Ctrl-C is its usual end


def run_experiment(
    rig: RigFile,
    port: Port,
    kind: Annotated[Kind | None, typer.Option(help="what the board plays", show_default=False)] = None,
    plan: Annotated[
        Path | None, typer.Option(metavar="PLAN", help="plays the runs of a plan instead: its file or folder")
    ] = None,
    runs: Annotated[
        list[str] | None, typer.Option("--run", metavar="NAME", help="only this run of the plan; may be repeated")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", metavar="LOG.csv", help="the log, run.csv by default; of a plan the folder of its logs, logs"
        ),
    ] = None,
    volts: Annotated[float | None, typer.Option(help="amplitude [V]; 2 by default")] = None,
    offset: Annotated[float | None, typer.Option(help="added to it [V]; 0 by default")] = None,
    period: Annotated[
        float | None, typer.Option(help="seconds; coast-down: of drive before the wheel runs free; 4 by default")
    ] = None,
    seconds: Annotated[float | None, typer.Option(help="length, after 0.6 s of rest; 16 by default")] = None,
    role: Annotated[str | None, typer.Option(help="`validate` keeps the log out of fit and choice")] = None,
    clear: Annotated[bool, typer.Option("--clear", help="clear a latched fault first")] = False,
    quiet: Quiet = False,
) -> None:
    """Arm the board, let it play an experiment or the runs of a plan, record, disarm. THE RIG MOVES."""
    if (plan is None) == (kind is None):
        raise InputError("give either --kind for one experiment or --plan for the runs of a plan")
    single = {"volts": volts, "offset": offset, "period": period, "seconds": seconds, "role": role}
    if plan is not None and (given := next((name for name, value in single.items() if value is not None), None)):
        raise InputError(f"--{given}: belongs to one experiment; a plan says it for each run")
    finite(**{name: value for name, value in single.items() if isinstance(value, float)})
    if plan is None and runs:
        raise InputError("--run: belongs to a plan; give one with --plan")
    _needs_pyserial()
    from rwjax.link.play_experiment import play
    from rwjax.link.play_plan import Task, check_plan, tasks_of_plan
    from rwjax.link.recorder import check_new
    from rwjax.link.rest import at_rest
    from rwjax.planning.envelope import rad_and_degrees
    from rwjax.planning.experiment import Experiment
    from rwjax.planning.files import read_plan
    from rwjax.rig.read import read_one_axis_rig

    if plan is not None:
        wanted = read_plan(plan)
        with of_file(plan):
            wanted = wanted.only(runs) if runs else wanted
        believed = read_one_axis_rig(rig)
        with of_file(plan):
            tasks = tasks_of_plan(wanted, believed, clear)
        for run in wanted.runs:
            check_new((output or LOGS) / f"{run.name}.csv")
        check_plan(port, wanted, believed)
        if (travel := wanted.limits.get("yaw_rad")) is not None:
            followed = (
                "" if "axis" in believed.counts_per_rev else ", and no encoder of the axis tells whether it keeps to it"
            )
            print(
                f"the axis has to stand in the middle of its travel of {rad_and_degrees(travel)} either way now{followed}",
                file=sys.stderr,
            )
        with results(output or LOGS) as folder:
            for run, task in zip(wanted.runs, tasks, strict=True):
                if stopped := _record(believed, port, folder / f"{run.name}.csv", run.notes, task, quiet):
                    raise stopped
    elif kind is not None:
        log = output or Path("run.csv")
        _check(log)
        asked = ((volts, 2.0), (offset, 0.0), (period, 4.0), (seconds, 16.0))
        one = Experiment(kind.value, *(default if value is None else value for value, default in asked))
        believed = read_one_axis_rig(rig)
        notes = {"experiment": one.words(), **_notes(role or "train")}
        if stopped := _record(believed, port, log, notes, Task(at_rest, play(one, believed, clear)), quiet):
            raise stopped


def monitor(rig: RigFile, port: Port) -> None:
    """Show what the board sends, until Ctrl-C."""
    _needs_pyserial()
    if not sys.stderr.isatty():
        raise InputError("monitor draws on a terminal, and stderr is none; `rwjax record` writes what the board sends")
    from rwjax.link.port import open_port
    from rwjax.link.recorder import listen
    from rwjax.link.session import Session
    from rwjax.rig.read import read_one_axis_rig

    believed = read_one_axis_rig(rig)
    with _live(believed, quiet=False) as watch, closing(open_port(port)) as line:
        session = Session(line, watch=watch)
        session.greet()
        try:
            listen(None)(session)
        except KeyboardInterrupt:
            pass


def decode(
    rig: RigFile,
    raw: Annotated[Path, typer.Argument(metavar="RAW", help="raw stream of a recording (.raw)", show_default=False)],
    output: Annotated[Path | None, typer.Option("-o", metavar="LOG.csv", help="beside the stream without it")] = None,
) -> None:
    """Logs from a raw stream, such as a recording that was killed has left."""
    from rwjax.link.stream_to_logs import write_logs
    from rwjax.rig.read import read_one_axis_rig

    if raw.is_dir():
        raise InputError(f"{raw}: is a folder; give the path of a raw stream")
    target = output or raw.with_suffix(".csv")
    _check(target)
    logs, remarks = write_logs(raw, read_one_axis_rig(rig), target)
    if not logs:
        why = "; ".join(remarks) or "is this a raw stream of the testbed's board?"
        raise InputError(f"{raw}: holds no stretch of samples for a log; {why}")
    print(*logs, sep="\n")
    for remark in remarks:
        print(f"note: {remark}", file=sys.stderr)
