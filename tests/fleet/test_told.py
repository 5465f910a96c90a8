"""What is told of a fleet: rigs of the plan alone, each leading to its report."""

import os
from pathlib import Path

import polars as pl

from rwjax.fleet.plan import FleetPlan, Job, read_plan
from rwjax.fleet.store import REPORTS, schema
from rwjax.fleet.told import told, write_plan_of_changed, write_told
from rwjax.fleet.work import failed, report_folder

JOBS = tuple(Job(name, "", "rig.toml", ()) for name in ("a", "b & c"))
FAILED = [failed(job, "diagnose", "no <log>") for job in (*JOBS, Job("gone", "", "", ()))]
ROWS = pl.DataFrame(FAILED, schema=schema())
MISSING = {"status": "done", "verdict": "unknown", "effects": []}


def test_rigs_that_the_plan_has_no_more_do_not_count() -> None:
    assert told(FleetPlan("diagnose", {}, JOBS), ROWS).rows["rig"].to_list() == ["a", "b & c"]


def test_rig_files_without_logs_are_said() -> None:
    plan = FleetPlan("diagnose", {}, JOBS)
    assert told(plan._replace(unlogged=("r6",)), ROWS).notes == [
        "1 rig file has no logs, for which nothing was done: r6"
    ]
    many = told(plan._replace(unlogged=tuple(f"r{k:02d}" for k in range(30))), ROWS)
    assert "note: 30 rig files have no logs, for which nothing was done: r00 to r29\n" in str(many)
    assert not told(plan, ROWS).notes


def test_a_rig_leads_to_its_report_where_there_is_one(tmp_path: Path) -> None:
    for job in JOBS:
        page = tmp_path / REPORTS / report_folder(job) / "report.html"
        page.parent.mkdir(parents=True)
        page.write_text("")
    rows = pl.DataFrame([FAILED[0], FAILED[1] | MISSING], schema=schema())
    text = write_told(told(FleetPlan("diagnose", {}, JOBS), rows), tmp_path).read_text()
    link = f'<a href="reports/{report_folder(JOBS[1])}/report.html">b &amp; c</a>'
    assert link in text and text.count("<a href") == 1
    assert "no &lt;log&gt;" in text  # an older report of a rig that failed is none of this run


def test_the_rigs_that_changed_are_the_next_plan(tmp_path: Path) -> None:
    jobs = tuple(Job(name, when, "rig.toml", (f"{name} {when}.csv",)) for name in ("a", "b, c") for when in ("1", "2"))
    plan = FleetPlan("fit", {"force": True, "segments": 2.0}, jobs, ("axis.inertia",))
    none = told(plan, ROWS)
    alarm = {"rig": "b, c", "when": "2", "against": "itself", "number": "axis.inertia", "or": "", "p": 0.0}
    found = none._replace(
        changes=none.changes._replace(alarms=pl.DataFrame([alarm], schema=none.changes.alarms.schema))
    )
    path = write_plan_of_changed(plan, found, tmp_path)
    assert path is not None
    assert read_plan(path)._replace(jobs=()) == plan._replace(command="diagnose", jobs=())
    assert read_plan(path).jobs == (Job("b, c", "2", os.path.abspath("rig.toml"), (os.path.abspath("b, c 2.csv"),)),)
    assert write_plan_of_changed(plan, none, tmp_path) is None and not path.exists()
