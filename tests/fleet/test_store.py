"""Results on disk: what is done is found again, the latest row counts, and other results are refused."""

import re
from pathlib import Path

import pytest

from rwjax import __version__
from rwjax.errors import InputError
from rwjax.fleet.plan import FleetPlan, Job
from rwjax.fleet.store import ABOUT, PARTS, RESULTS, Store
from rwjax.fleet.work import failed

PLAN = FleetPlan("fit", {}, tuple(Job(name, "", f"{name}.toml", (f"{name}.csv",)) for name in "abc"))


def row(job: Job, status: str = "done", **more: object) -> dict:
    """A row of a job."""
    return failed(job, "fit", "") | {"status": status} | more


def test_what_is_done_is_left_out_and_what_failed_is_not(tmp_path: Path) -> None:
    a, b, c = PLAN.jobs
    with Store(tmp_path / "out", PLAN) as store:
        store.add([row(a), row(b, "failed", line="why")])
        assert store.left(PLAN.jobs) == [b, c]
    with Store(tmp_path / "out", PLAN) as store:  # by another process, later
        assert store.left(PLAN.jobs) == [b, c]
        store.add([row(b)])
        assert store.left(PLAN.jobs) == [c]


def test_two_processes_do_not_write_one_folder(tmp_path: Path) -> None:
    with Store(tmp_path, PLAN), pytest.raises(InputError, match="another process writes results there; wait for it"):
        Store(tmp_path, PLAN)
    with Store(tmp_path, PLAN) as store:
        assert store.gathered().is_empty()


def test_a_rig_whose_files_changed_is_left_again(tmp_path: Path) -> None:
    with Store(tmp_path, PLAN) as store:
        store.add([row(PLAN.jobs[0], inputs="as they were")])
        assert PLAN.jobs[0] in store.left(PLAN.jobs)


def test_the_latest_row_counts_also_over_gathered_ones(tmp_path: Path) -> None:
    job = PLAN.jobs[0]
    with Store(tmp_path, PLAN) as store:
        store.add([row(job, "failed", line="why")])
        assert store.gathered()["status"].to_list() == ["failed"]
        store.add([row(job, numbers=[{"name": "J", "value": 1.0, "standard_error": 0.1}], covariance=[0.01])])
        found = store.gathered()
        assert found["status"].to_list() == ["done"] and found["numbers"].to_list()[0][0]["value"] == 1.0
        assert not list((tmp_path / PARTS).iterdir()) and store.gathered().equals(found)


def test_parts_that_were_not_removed_after_gathering_do_not_double_a_rig(tmp_path: Path) -> None:
    with Store(tmp_path, PLAN) as store:
        store.add([row(job) for job in PLAN.jobs])
        part = next((tmp_path / PARTS).iterdir())
        kept = part.read_bytes()
        store.gathered()
    part.write_bytes(kept)  # killed between the two
    with Store(tmp_path, PLAN) as store:
        assert store.gathered()["rig"].to_list() == ["a", "b", "c"]


def test_results_of_another_command_are_not_mixed_in(tmp_path: Path) -> None:
    with Store(tmp_path, PLAN):
        pass
    for _ in range(2):  # and the folder is free again
        with pytest.raises(InputError, match=r'holds results of .*"fit".*, not of .*"check".*; give another folder'):
            Store(tmp_path, PLAN._replace(command="check"))


def test_what_results_are_of_is_said_as_a_plan_has_it(tmp_path: Path) -> None:
    with Store(tmp_path, PLAN._replace(options={"segments": 2.0, "force": True})):
        pass
    said = re.escape(f'holds results of command = "fit", force = true, segments = 2.0, rwjax {__version__}, not of')
    with pytest.raises(InputError, match=said):
        Store(tmp_path, PLAN)
    (tmp_path / ABOUT).write_text("mine")
    with pytest.raises(InputError, match="holds results of what rwjax did not write, not of command"):
        Store(tmp_path, PLAN)


def test_a_column_of_somebody_else_is_left_aside(tmp_path: Path) -> None:
    with Store(tmp_path, PLAN) as store:
        store.add([row(PLAN.jobs[0])])
        table = store.gathered().with_columns(mine=1)
        table.write_parquet(tmp_path / RESULTS)
        assert store.gathered()["rig"].to_list() == ["a"]


def test_a_file_that_is_no_table_is_named(tmp_path: Path) -> None:
    with Store(tmp_path, PLAN) as store:
        (tmp_path / RESULTS).write_text("no")
        with pytest.raises(InputError, match=r"results\.parquet: is no table of results"):
            store.left(PLAN.jobs)
