"""The command `data`: logs of real rigs that others published."""

from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.options import Quiet
from rwjax.cli.progress import progress
from rwjax.cli.terminal import next_command, say
from rwjax.errors import InputError

Action = Annotated[str | None, typer.Argument(metavar="[fetch", help="fetches a set", show_default=False)]
Name = Annotated[str | None, typer.Argument(metavar="NAME]", help="its name", show_default=False)]
Output = Annotated[Path | None, typer.Option("-o", metavar="DIR", help="folder; the set's name without it")]


def data(action: Action = None, name: Name = None, output: Output = None, quiet: Quiet = False) -> None:
    """Logs of real rigs that others published: which there are, and `data fetch NAME` brings one with a first rig file.

    Example: `rwjax data fetch emps`
    """
    from rwjax.logs.published import SETS, fetch

    if action is None:
        for known, one in SETS.items():
            say(f"{known}: {one.rig}\n  source: {one.source}\n  licence: {one.licence}")
        return
    if action != "fetch":
        raise InputError(
            f"data {action}: is not known; `rwjax data` lists the sets, `rwjax data fetch NAME` brings one"
        )
    if name not in SETS:
        said = f"no published set `{name}`" if name else "which set"
        raise InputError(f"{said}: known are {', '.join(SETS)}, as in `rwjax data fetch {next(iter(SETS))}`")
    with progress(quiet) as show:
        show(f"fetching {name}")
        rig_file, *logs = fetch(name, output or Path(name))
    say(f"source: {SETS[name].source}\nlicence: {SETS[name].licence}")
    say(f"written to {rig_file.parent}\n{next_command('diagnose', rig_file, *logs)}")
