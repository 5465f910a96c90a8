"""The command `export`: a rig for other tools."""

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import Quiet, RigFile, check_file, of_file
from rwjax.cli.progress import progress
from rwjax.cli.terminal import document, note, say

if TYPE_CHECKING:
    from rwjax.export import Exported
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
    typer.Argument(
        metavar="[LOG…]",
        help="logs, to say how large what is left out is, and for a duty's supply_V where RIG has no drive.supply",
        show_default=False,
    ),
]
To = Annotated[Target, typer.Option("--to", help="the tool", show_default=False)]
Output = Annotated[Path | None, typer.Option("-o", metavar="FILE", help="stdout without it")]

Answer = Annotated[
    Path | None,
    typer.Option("--fit", metavar="FILE", help="of `fit --json`, or a diagnosis.json: covariance and noise for JSON"),
]


def export(
    rig_file: RigFile,
    to: To,
    log_files: Logs = None,
    answer: Answer = None,
    output: Output = None,
    quiet: Quiet = False,
) -> None:
    """Write RIG for another tool: a MuJoCo model, a C header with feed-forward, a python-control plant, or JSON. Says what the tool cannot express, and of a MuJoCo model, with logs, how far that moves free runs. Replaces FILE.

    Example: `rwjax export fitted.toml --to mjcf -o rig.xml`
    """
    from rwjax.errors import InputError, RigError
    from rwjax.export.targets import export as exported
    from rwjax.export.targets import with_logged_supply
    from rwjax.logs.read import read_logs
    from rwjax.rig.read import read_rig
    from rwjax.text_files import write_text

    if output is not None:
        check_file(output, rig_file, *(log_files or ()), *([answer] if answer else ()))
    rig = read_rig(rig_file)
    with progress(quiet) as show:
        show("working out what is left out")
        logs = read_logs(log_files, rig) if log_files else ()
        rig, supply = with_logged_supply(rig, to.value, logs)
        with of_file(rig_file, RigError):
            found = exported(rig, to.value, answer)
        notes = [supply] if supply else []
        notes += [f"not in it: {name}: {why}" for name, why in found.left_out.items()]
        if logs:
            notes += _size(rig, found, logs)
    if output is None:
        document(found.text)
    else:
        write_text(output, found.text, InputError)
        own = ["for a model of your own, with gear 1:", *(f"  {line}" for line in found.own)] if found.own else []
        say("\n".join([f"written to {output}", *own]))
    note(*rig.cautions, *notes)


def _size(rig: "Rig", found: "Exported", logs: "Sequence[Log]") -> list[str]:
    """How far what is left out moves free runs of the logs, where the file is a model that can be played."""
    from rwjax.errors import InputError
    from rwjax.export.targets import moved_by
    from rwjax.rig.columns import unit_of

    if found.held is None:
        return ["the logs are not used: how far what is left out moves their runs is said with `--to mjcf` alone"]
    if {*found.left_out} == {*found.uncounted}:
        return ["no rig file is without it, so that no run says how far it moves them"] if found.left_out else []
    try:
        moved = moved_by(rig, found.held, logs)
    except InputError as why:
        return [f"how far what is left out moves runs cannot be said: {why}"]
    far = ", ".join(f"{v:.3g} {unit_of(k)} rms ({k})" for k, v in moved.items())
    if found.uncounted:
        far += f"; not counting {', '.join(found.uncounted)}, which no rig file is without"
    off = any(log.enabled is not None and not log.enabled.all() for log in logs)
    switch = "torque is off in both runs where `enabled` is 0; the model has no such switch, and that is not counted"
    return [f"what is left out moves free runs by {far}", *([switch] if off else [])]
