"""The command `export`: a rig for other tools."""

from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import Quiet, RigFile, check_file, of_file
from rwjax.cli.progress import progress
from rwjax.cli.terminal import document, note, say

if TYPE_CHECKING:
    from rwjax.logs.log import Log
    from rwjax.rig.model import Rig


class Target(StrEnum):
    """The tools that a rig may be written for."""

    MJCF = "mjcf"
    C = "c"
    PYTHON_CONTROL = "python-control"
    JSON = "json"


Logs = Annotated[
    list[Path] | None,
    typer.Argument(metavar="[LOG…]", help="logs, to say how large what is left out is", show_default=False),
]
To = Annotated[Target, typer.Option("--to", help="the tool", show_default=False)]
Output = Annotated[Path | None, typer.Option("-o", metavar="FILE", help="stdout without it")]


def export(rig_file: RigFile, to: To, log_files: Logs = None, output: Output = None, quiet: Quiet = False) -> None:
    """Write RIG for another tool: a MuJoCo model, a C header with feed-forward, a python-control plant, or JSON. Says what the tool cannot express, and with logs how far that moves free runs."""
    from rwjax.errors import InputError
    from rwjax.export.targets import export as exported
    from rwjax.logs.read import read_logs
    from rwjax.rig.read import read_rig
    from rwjax.text_files import write_text

    if output is not None:
        check_file(output, rig_file, *(log_files or ()))
    rig = read_rig(rig_file)
    with of_file(rig_file):
        found = exported(rig, to.value)
    with progress(quiet) as show:
        logs = read_logs(log_files, rig) if log_files else ()
        show("working out what is left out")
        lines = [f"not in it: {name}: {why}{_size(rig, name, logs)}" for name, why in found.left_out.items()]
    if output is None:
        document(found.text)
    else:
        write_text(output, found.text, InputError)
        say(f"written to {output}")
    note(*lines)


def _size(rig: "Rig", name: str, logs: "Sequence[Log]") -> str:
    """How far an effect moves free runs of the logs, beside the error of the rig; nothing for what is no effect of its own."""
    from rwjax.export.targets import moved_by
    from rwjax.rig.columns import unit_of

    if not logs or name not in rig.effects:
        return ""
    moved: Mapping[str, float] = moved_by(rig, name, logs)
    return "; it moves " + ", ".join(f"{output} by {rms:.3g} {unit_of(output)} rms" for output, rms in moved.items())
