"""A plan carried out on a cluster of two processes, and what is begun again."""

from pathlib import Path

import polars as pl
import pytest

from rwjax.errors import InputError
from rwjax.fleet.plan import read_plan
from rwjax.fleet.run import run
from rwjax.fleet.store import schema
from rwjax.fleet.work import carried_out
from tests.fleet.small import write_small

pytest.importorskip("distributed", reason="a fleet needs the extra `fleet`")


@pytest.mark.slow
def test_a_cluster_gives_what_one_process_gives_and_does_nothing_twice(tmp_path: Path) -> None:
    plan = read_plan(write_small(tmp_path))
    (tmp_path / "logs" / "b" / "fast.csv").write_text("time_s\n")  # one rig fails, and is tried again
    said: list[str] = []
    rows = run(plan, tmp_path / "out", workers=2, progress=said.append)
    alone = pl.DataFrame([carried_out(job, "fit", {}, "") for job in plan.jobs], schema=schema()).sort("rig")
    assert rows.drop("seconds").equals(alone.drop("seconds"))
    assert rows["status"].to_list() == ["done", "failed", "done"]
    assert "3 of 3 jobs" in said[2] and said[-1].startswith("failed ones once more, 1 of 1 jobs")
    again: list[str] = []
    assert run(plan, tmp_path / "out", workers=1, progress=again.append)["seconds"][0] == rows["seconds"][0]
    assert all("of 1 jobs" in one for one in again)  # the failed one alone


def test_a_shared_number_that_no_fit_estimates_is_said_before_anything_is_done(tmp_path: Path) -> None:
    plan = read_plan(write_small(tmp_path, ("a",)))._replace(shared=("drive.gain",))
    with pytest.raises(
        InputError, match=r"`shared` holds drive.gain, which .*rig.toml does not leave free; it leaves free axis.i"
    ):
        run(plan, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_worker_that_is_killed_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import psutil

    plan = read_plan(write_small(tmp_path, tuple("abcdefgh")))
    killed: list[int] = []

    def kill(text: str) -> None:
        if not killed:
            workers = [p for p in psutil.Process().children(recursive=True) if "spawn_main" in " ".join(p.cmdline())]
            killed.append(workers[-1].pid)
            workers[-1].kill()

    rows = run(plan, tmp_path / "out", workers=2, progress=kill)
    assert killed and rows["rig"].to_list() == list("abcdefgh") and set(rows["status"]) == {"done"}
