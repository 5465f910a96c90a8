"""The command `fleet`: a command for every rig of a plan, on Dask."""

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rwjax.cli.interrupt import CLEAR, end, first
from rwjax.cli.options import Json, Quiet, positive
from rwjax.cli.progress import progress
from rwjax.cli.terminal import document, note, say
from rwjax.errors import InputError
from rwjax.fleet import FALSE
from rwjax.report.answer import json_text

if TYPE_CHECKING:
    from rwjax.fleet.page import Fleet

PlanFile = Annotated[Path, typer.Argument(metavar="PLAN", help="plan of the fleet (TOML)", show_default=False)]
Output = Annotated[
    Path, typer.Option("-o", metavar="DIR", help="folder of the results; what is done there is not done again")
]
Workers = Annotated[int | None, typer.Option(min=1, metavar="N", help="processes; one for each processor without it")]
Memory = Annotated[
    str | None,
    typer.Option(metavar="SIZE", help="memory of each process, as 2GiB; its share of what there is without it"),
]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="a Dask scheduler that runs already, as tcp://host:8786")
]
FalseAlarms = Annotated[
    float, typer.Option("--false-alarms", metavar="SHARE", help="share of the alarms that may be false")
]
STOPPING = "rwjax: stopping, which takes some seconds; what is done is kept"
"""What the first Ctrl-C says, while the cluster closes."""


def fleet(
    plan_file: PlanFile,
    output: Output = Path("fleet"),
    workers: Workers = None,
    memory: Memory = None,
    scheduler: Scheduler = None,
    false: FalseAlarms = FALSE,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Fit, check, diagnose or compare many rigs, by a plan; says which of them changed. What is killed goes on where it was.

    Example: `rwjax fleet fleet.toml --workers 8`
    """
    from rwjax.fleet.plan import read_plan
    from rwjax.fleet.run import run
    from rwjax.fleet.told import told, write_plan_of_changed, write_told

    positive(**{"false-alarms": false})
    if false >= 1.0:
        raise InputError(f"--false-alarms {false:g}: is a share; give one below 1, as 0.01")
    if scheduler is not None and (workers is not None or memory is not None):
        raise InputError(
            "--workers and --memory: a cluster that runs already has its own; leave out them or --scheduler"
        )
    plan = read_plan(plan_file)
    with progress(quiet, lines=True) as show:
        show("starting the cluster")
        try:
            with first(_stopping):
                rows = run(plan, output, scheduler=scheduler, workers=workers, memory=memory, progress=show)
        except KeyboardInterrupt:
            note(f"{output} holds what is done; the same command goes on from there")
            raise
        show("drawing")
        found = told(plan, rows, false)
        page, following = write_told(found, output), write_plan_of_changed(plan, found, output)
    if as_json:
        document(json_text(_json(found, output), indent=1) + "\n")
    else:
        ask = [f"  why they changed: rwjax fleet {following} -o {output / 'changed'}"] if following else []
        say("\n".join([f"{found}\n  page: {page}", *ask]))
    if found.rows.filter(status="done").is_empty():
        raise InputError(f"{plan_file}: no job was done; {page} says why each failed")


def _stopping() -> bool:
    """Says that Ctrl-C was heard, ignores the next ones until the cluster is closed, and lets the run be interrupted."""
    end()
    with suppress(OSError):
        os.write(2, f"{CLEAR if os.isatty(2) else ''}{STOPPING}\n".encode())
    return False


def _json(found: "Fleet", output: Path) -> dict[str, Any]:
    """What the command has found as plain objects."""
    from rwjax.fleet.page import failures, outcomes
    from rwjax.fleet.store import RESULTS

    return {
        "schema": "rwjax.fleet/1",
        "command": found.command,
        "results": str(output / RESULTS),
        "jobs": found.rows.height,
        "outcomes": outcomes(found.rows),
        "false_alarms": found.false,
        "compared": len(found.changes.rigs),
        "compared_with_itself": len(found.changes.earlier),
        "notes": found.notes,
        "numbers": found.pooled.fleet.to_dicts(),
        "changed": found.changes.alarms.to_dicts(),
        "lacking": found.changes.lacking.to_dicts(),
        "appeared": found.appeared.to_dicts(),
        "failed": failures(found.rows).select("rig", "when", "line").to_dicts(),
    }
