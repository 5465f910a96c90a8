"""What the commands that talk to a board share: their arguments, the live view, and a recording's end."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.terminal import note, say
from rwjax.errors import InputError, RigError

if TYPE_CHECKING:
    from rwjax.link.play_plan import Task
    from rwjax.rig.model import Rig

RigFile = Annotated[Path, typer.Argument(metavar="RIG", help="rig file (TOML) with `drive.pwm`", show_default=False)]
Port = Annotated[str, typer.Argument(metavar="PORT", help="serial port, such as /dev/ttyACM0", show_default=False)]
Quiet = Annotated[bool, typer.Option("--quiet", help="no live view")]


@contextmanager
def live_view(rig: "Rig", quiet: bool) -> Iterator[Callable[..., None]]:
    """The live view on a terminal, nothing otherwise.

    Args:
        rig: the rig whose board sends.
        quiet: whether the user wants none.

    Yields:
        Function of a session and a sample, to call with every sample that comes.
    """
    from rich.console import Console
    from rich.live import Live

    from rwjax.link.monitor import View, table

    console, view = Console(stderr=True), View(rig)
    if quiet or not console.is_terminal:
        yield lambda session, sample: None
        return
    with Live(get_renderable=lambda: table(view), console=console, refresh_per_second=5):
        yield view


def needs_pyserial() -> None:
    """Checks that serial ports can be talked to.

    Raises:
        InputError: pyserial is not installed.
    """
    try:
        import serial  # noqa: F401
    except ImportError:
        raise InputError("this command talks to a serial port and needs pyserial: pip install pyserial") from None


def read_board_rig(rig_file: Path) -> "Rig":
    """The rig of a file from which a board can be recorded.

    Args:
        rig_file: the file.

    Returns:
        The rig.

    Raises:
        RigError: it says nothing about pulses or counts, has two axes, or cannot be read.
    """
    from rwjax.link.channels import pwm_of
    from rwjax.rig.read import read_one_axis_rig

    rig = read_one_axis_rig(rig_file)
    try:
        pwm_of(rig)
    except RigError as error:
        raise RigError(f"{rig_file}: {f'{error}'.removeprefix(f'{rig.name}: ')}") from None
    return rig


def role_note(role: str) -> dict[str, str]:
    """A log's note on its role.

    Args:
        role: what the user gave.

    Returns:
        The note by its name.

    Raises:
        InputError: the role is none that a log may have.
    """
    from rwjax.logs.sheet import ROLES

    if role not in ROLES:
        raise InputError(f"--role {role}: is unknown; it is `train` or `validate`")
    return {"role": role}


def check_output(output: Path) -> None:
    """Checks the path of a new log.

    Args:
        output: the path that the user gave.

    Raises:
        InputError: its name does not end in .csv, or a file is there.
    """
    from rwjax.link.stream_to_logs import refuse_existing

    if output.suffix != ".csv":
        raise InputError(f"{output}: a log's name ends in .csv")
    refuse_existing(output)


def record_task(
    rig: "Rig", port: str, output: Path, notes: dict[str, str], task: "Task", quiet: bool
) -> KeyboardInterrupt | None:
    """Records what the board sends during a task, and prints what is on disk then.

    Args:
        rig: the rig whose board sends.
        port: serial port.
        output: path of the log.
        notes: notes of the log, by name.
        task: what the board is asked to do, and when it is ready.
        quiet: whether the user wants no live view.

    Returns:
        The Ctrl-C that ended the recording early, if one did.

    Raises:
        InputError: the recording failed, or there is no log.
    """
    from rwjax.link.recorder import record as run

    with live_view(rig, quiet) as watch:
        done = run(port, rig, output, notes, task.act, watch, task.ready)
    for path in done.logs:
        say(str(path))
    note(*done.remarks)
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
