"""The command `record`: what the board sends, without arming it."""

from pathlib import Path
from typing import Annotated

import typer

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

Output = Annotated[Path, typer.Option("-o", metavar="LOG.csv", help="the log; beside it .raw and .notes")]
Seconds = Annotated[float | None, typer.Option(min=0.1, max=86_400.0, help="until Ctrl-C without it")]
Role = Annotated[str, typer.Option(help="`validate` keeps the log out of fit and choice")]


def record(
    rig_file: RigFile,
    port: Port,
    output: Output = Path("run.csv"),
    seconds: Seconds = None,
    role: Role = "train",
    quiet: Quiet = False,
) -> None:
    """Record what the board sends, without arming it.

    Example: `rwjax record rig.toml /dev/ttyACM0 -o run.csv --seconds 20`
    """
    needs_pyserial()
    from rwjax.link.play_plan import Task
    from rwjax.link.recorder import listen

    check_output(output)
    task = Task(lambda session: {}, listen(seconds))
    record_task(read_board_rig(rig_file), port, output, role_note(role), task, quiet)  # Ctrl-C is its usual end
