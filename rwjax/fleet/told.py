"""What is told of a fleet: which rigs changed or have what few have, on its page."""

from pathlib import Path
from typing import Any

import polars as pl

from rwjax.fleet.appeared import appeared
from rwjax.fleet.changes import FALSE, changes
from rwjax.fleet.plan import FleetPlan, Job
from rwjax.fleet.store import REPORTS
from rwjax.fleet.work import report_folder
from rwjax.report.fleet import Fleet, write_fleet
from rwjax.report.html import REPORT


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
    return Fleet(plan.command, own, changes(own, false), appeared(own), false)


def write_told(fleet: Fleet, folder: Path) -> Path:
    """Writes the fleet's page; each rig with a report leads to it.

    Args:
        fleet: What is told.
        folder: Folder of the results.

    Returns:
        Path of the page.

    Raises:
        InputError: It cannot be written.
    """

    def report(row: dict[str, Any]) -> str | None:
        path = f"{REPORTS}/{report_folder(Job(row['rig'], row['when'], '', ()))}/{REPORT}"
        return path if (folder / path).exists() else None

    return write_fleet(fleet, folder, report)
