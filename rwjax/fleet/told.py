"""What is told of a fleet: which rigs changed or have what few have, on its page."""

import json
import os
from pathlib import Path
from typing import Any

import polars as pl

from rwjax.errors import InputError
from rwjax.fleet import FALSE
from rwjax.fleet.appeared import appeared
from rwjax.fleet.changes import changes
from rwjax.fleet.page import Fleet, write_fleet
from rwjax.fleet.plan import FleetPlan, Job
from rwjax.fleet.pooled import alike, pooled
from rwjax.fleet.sessions import common, latest, sessions_of
from rwjax.fleet.store import REPORTS
from rwjax.fleet.work import report_folder
from rwjax.report.html import REPORT
from rwjax.text_files import write_files, write_text

NEXT, NEXT_TABLE = "changed.toml", "changed.csv"
"""The plan that diagnoses the rigs that changed, and its table."""
MOST_LISTED = 20
"""Rigs that a note names one by one."""
TABLE = "numbers.csv"
"""Numbers of the rigs, alone and beside their siblings."""


def told(plan: FleetPlan, rows: pl.DataFrame, false: float = FALSE) -> Fleet:
    """What there is to tell of the rigs of a plan.

    Args:
        plan: The plan.
        rows: Results (`rwjax.fleet.store.schema`); those of rigs that the plan has no more do not count.
        false: Share of the alarms that may be false, on average [1].

    Returns:
        All of it.
    """
    wanted = pl.DataFrame(
        [(job.rig, job.when) for job in plan.jobs], {"rig": pl.String, "when": pl.String}, orient="row"
    )
    own = rows.join(wanted, on=["rig", "when"], how="semi").sort("rig", "when")
    sessions = sessions_of(own)
    now = latest(sessions, common(sessions))
    shared, notes = alike(now, plan.shared)
    found = changes(own, false, shared)
    apart = set(found.alarms.filter(against="siblings")["rig"])
    return Fleet(plan.command, own, found, appeared(own), pooled(now, shared, apart), false, (*notes, *_unlogged(plan)))


def _unlogged(plan: FleetPlan) -> list[str]:
    """A sentence on the rig files that have no logs."""
    names = plan.unlogged
    if not names:
        return []
    listed = ", ".join(names) if len(names) <= MOST_LISTED else f"{names[0]} to {names[-1]}"
    have = "rig file has" if len(names) == 1 else "rig files have"
    return [f"{len(names)} {have} no logs, for which nothing was done: {listed}"]


def write_plan_of_changed(plan: FleetPlan, fleet: Fleet, folder: Path) -> Path | None:
    """Writes a plan that diagnoses the rigs that changed, by their latest sessions.

    Args:
        plan: The plan of the fits.
        fleet: What is told of them.
        folder: Folder of the results.

    Returns:
        Path of the plan; None where no rig changed, or where they are diagnosed already.

    Raises:
        InputError: It cannot be written.
    """
    path, table = folder / NEXT, folder / NEXT_TABLE
    if plan.command != "fit":
        return None
    changed = set(fleet.changes.alarms["rig"])
    last = {job.rig: job for job in plan.jobs if job.rig in changed}  # jobs are sorted by session
    if not last:
        for old in (path, table):
            old.unlink(missing_ok=True)
        return None
    shared = f"shared = {json.dumps(plan.shared)}\n" if plan.shared else ""
    options = "".join(f"{name} = {json.dumps(value)}\n" for name, value in plan.options.items())
    rows = [
        (job.rig, job.when, os.path.abspath(job.rig_file), os.path.abspath(log))
        for job in last.values()
        for log in job.logs
    ]
    text = pl.DataFrame(rows, dict.fromkeys(("rig", "when", "rig_file", "log"), pl.String), orient="row").write_csv()
    write_files(
        {
            str(table): text.encode(),
            str(path): f'command = "diagnose"\ntable = "{NEXT_TABLE}"\n{shared}[options]\n{options}'.encode(),
        },
        InputError,
    )
    return path


def write_told(fleet: Fleet, folder: Path) -> Path:
    """Writes the fleet's page, where each rig with a report leads to it, and the table of its numbers.

    Args:
        fleet: What is told.
        folder: Folder of the results.

    Returns:
        Path of the page.

    Raises:
        InputError: It cannot be written.
    """
    done = set(fleet.rows.filter(status="done", command="diagnose").select("rig", "when").iter_rows())

    def report(row: dict[str, Any]) -> str | None:
        if (row["rig"], row["when"]) not in done:
            return None
        path = f"{REPORTS}/{report_folder(Job(row['rig'], row['when'], '', ()))}/{REPORT}"
        return path if (folder / path).exists() else None

    if not fleet.pooled.own.is_empty():
        write_text(folder / TABLE, fleet.pooled.own.write_csv(), InputError)
    return write_fleet(fleet, folder, report)
