"""Simulated fleets, and how their alarms are counted."""

from pathlib import Path

import polars as pl
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.fleet.draw import DESIGN, SESSIONS, drawn, name_of, write_fleet  # reason: behind the skip
from experiments.fleet.wear import counted, interval  # reason: behind the skip
from rwjax.fleet.plan import read_plan  # reason: behind the skip


def test_a_worn_rig_is_itself_but_for_its_wear() -> None:
    sound, worn = drawn(3, 0, "", 0.05), drawn(3, 0, "worn", 0.05)
    assert worn[0] == sound[0] and worn[1].coulomb == pytest.approx(1.05 * sound[1].coulomb)
    assert worn[1].I == sound[1].I == sound[0].I != DESIGN.I
    assert drawn(3, 0, "appears", 0.05)[1].deadzone > 0.0 == sound[1].deadzone


@pytest.mark.slow
def test_a_fleet_on_disk_is_what_its_plan_reads(tmp_path: Path) -> None:
    label = write_fleet(tmp_path, 4, worn=0.25, appears=0.25, processes=1)
    assert sorted(label.values()) == ["appears", "worn"]
    plan = read_plan(tmp_path / "fit.toml")
    assert [(job.rig, job.when) for job in plan.jobs] == [(name_of(k), when) for k in range(4) for when in SESSIONS]


@pytest.mark.slow
def test_a_scheduler_that_is_killed_loses_no_rig(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("distributed", reason="a fleet needs the extra `fleet`")
    from experiments.fleet.scale import restart

    write_fleet(tmp_path, 12, processes=1)
    restart(tmp_path, 12)
    assert "| scheduler | 0 | 0 |" in capsys.readouterr().out


def test_alarms_are_counted_by_kind_of_rig() -> None:
    alarms = pl.DataFrame(
        {
            "rig": ["a", "b", "c", "c"],
            "number": ["axis.inertia", "misfit", "misfit", "x"],
            "or": ["axis.friction.coulomb", "", "", ""],
        }
    )
    found = counted({"a": "worn", "b": "appears", "d": "worn"}, alarms, 10)
    assert list(found.values()) == [(1, 2), (1, 1), (1, 7), (1, 3)]


def test_an_interval_is_that_of_clopper_and_pearson() -> None:
    assert interval(0, 10) == "0 of 10: 0.0 % (0.0 to 30.8)"  # 1 - 0.025 ** 0.1
    assert interval(10, 10).endswith("(69.2 to 100.0)") and interval(0, 0) == "-"
