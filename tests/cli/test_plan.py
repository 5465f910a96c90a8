"""`rwjax plan`, as a user calls it."""

import json
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from rwjax.planning.experiment import Experiment
from rwjax.planning.files import Plan, Run, read_plan, write_plan
from tests.cli.shell import DEMO, ROOT
from tests.command import rwjax as within


def test_a_plan_is_written_and_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    demo = DEMO / "rig.toml"
    assert within(monkeypatch, "plan", demo, "--volts", 6, "--rate", 5, "-o", tmp_path / "plan") == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    *told, written_to, then, ahead = lines
    assert written_to.endswith(f"written to {tmp_path / 'plan' / 'plan.toml'}") and max(map(len, told)) <= 120
    assert then == "record them, then look at their logs" and ahead == f"next: rwjax check {demo} LOGS"
    written = tomllib.loads((tmp_path / "plan" / "plan.toml").read_text())
    assert written["rig"] == "thesis platform" and written["limits"] == {"voltage_V": 6.0, "yaw_rad_s": 5.0}
    for run in written["runs"]:
        assert (tmp_path / "plan" / f"{run['name']}.csv").exists() and run["reaches"]["yaw_rad_s"] <= 5.0
    assert {run["role"] for run in written["runs"]} == {"train", "validate"}
    told = {name for run in written["runs"] for name in run["tells_apart"]}
    assert "drive.lag" in told and "drive.goal_delay" not in told  # the rig has no servo
    unlimited, frictionless, by_hand = err.splitlines()
    assert (
        unlimited.endswith("--travel (travel of the axis [rad]); the volts alone bound it")
        and "known inertia" in by_hand
    )
    assert "holds no dry friction" in frictionless  # the demo's file, though its rig sticks
    assert within(monkeypatch, "plan", demo, "--volts", 6, "--rate", 5, "-o", tmp_path / "b", "--json", "--quiet") == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == written and err == ""
    earlier = tmp_path / "b" / "plan.toml"
    own = earlier.read_text()
    for rig, said in (
        ("thesis platform", ""),
        ("bench", "note: this replaces the plan of rig `bench` and its runs\n"),
    ):
        write_plan(tmp_path / "b", replace(read_plan(earlier), rig=rig))
        assert within(monkeypatch, "plan", demo, "--volts", 6, "--rate", 5, "-o", tmp_path / "b") == 0
        notes = capsys.readouterr().err
        assert said in notes and ("replaces" in notes) == bool(said)
    edited = (
        own.replace("length_s", "length_s  ", 1),
        own.replace("length_s = ", "length_s = 1", 1),
        own + "# mine\n",
        "rig =",
    )
    for text in edited:
        earlier.write_text(text)
        before = {path.name: path.read_bytes() for path in (tmp_path / "b").iterdir()}
        assert within(monkeypatch, "plan", demo, "--volts", 6, "--rate", 5, "-o", tmp_path / "b") == 2
        refusal = (
            f"rwjax: {earlier}: is not as `rwjax plan` wrote it, and would be replaced; give another folder with -o"
        )
        assert capsys.readouterr().err == f"{refusal}, or move that file\n"
        assert {path.name: path.read_bytes() for path in (tmp_path / "b").iterdir()} == before


def test_a_plan_that_is_edited_meanwhile_is_not_replaced(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = Run("one", Experiment("square", 1.0, 0.0, 1.0, 1.0), "train", "", (), {})
    path = write_plan(tmp_path, Plan("thesis platform", {}, (run,)))
    edited = path.read_text() + "# mine\n"

    def recommend(*given: object) -> object:
        path.write_text(edited)
        return (run,), ()

    monkeypatch.setattr("rwjax.planning.campaign.recommend", recommend)
    assert within(monkeypatch, "plan", DEMO / "rig.toml", "--volts", 6, "-o", tmp_path) == 2
    assert capsys.readouterr().err.startswith(
        f"rwjax: {path}: is not as `rwjax plan` wrote it, and would be replaced; "
    )
    assert path.read_text() == edited and {each.name for each in tmp_path.iterdir()} == {"one.csv", "plan.toml"}


def test_a_folder_of_logs_is_refused_and_stays_as_it_is(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = tmp_path / "logs"
    logs.mkdir()
    for log in ("square.csv", "mixed.csv"):
        shutil.copy(DEMO / log, logs)
    assert within(monkeypatch, "plan", DEMO / "rig.toml", "--volts", 6, "--rate", 5, "-o", logs) == 2
    said = "is not the CSV of a run that a plan here wrote, and would be replaced; write the plan into another folder, or move"
    assert capsys.readouterr().err == f"rwjax: {logs / 'square.csv'}: {said} that file\n"
    assert {path.name: path.read_bytes() for path in logs.iterdir()} == {
        log: (DEMO / log).read_bytes() for log in ("square.csv", "mixed.csv")
    }


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "RIG: nothing says how many volts the drive gives; add --volts, such as --volts 12"),
        (("--volts", "-1"), "--volts -1: has to be positive"),
        (("--volts", "1e300"), "--volts 1e+300: has to lie between -1e+12 and 1e+12"),
        (("--volts", "1e9"), "--volts 1e+09: a voltage lies between 1e-09 and 1e+06 V"),
        (("--volts", "12", "--rate", "1e9"), "--rate 1e+09: a rate lies between 1e-12 and 1e+06 rad/s"),
        (("--volts", "12", "--travel", "1e-10"), "--travel 1e-10: an angle lies between 1e-09 and 1e+09 rad"),
        (("--volts", "inf"), "--volts inf: has to be a finite number"),
        (
            ("--travel", "a turn"),
            "--travel a turn: has to be a number of rad, such as 0.7 (a linear axis: m), or of degrees",
        ),
        (("--travel", "-40deg"), "--travel -0.698132: has to be positive"),
        (("--goal", "half"), "--goal half: has to be a number of rad, such as 0.7"),
        (
            ("--goal", "1", "--volts", "5"),
            "--goal and --volts: the runs are goals of the servo or voltages; leave one out",
        ),
        (("--goal", "1"), "RIG: `goal_rad` needs the loop that follows it; write [drive.servo] in the rig file"),
        (
            ("--volts", "12", "--rpm", "100"),
            "RIG: --rpm: a `platform` rig has no rate of the wheel; leave the option out",
        ),
    ],
)
def test_a_plan_that_cannot_be_made_is_one_line(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: tuple[str, ...],
    said: str,
) -> None:
    rig = DEMO / "rig.toml"
    assert within(monkeypatch, "plan", rig, "-o", tmp_path / "plan", *arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("rwjax: " + said.replace("RIG", str(rig))) and error.count("\n") == 1
    assert not (tmp_path / "plan").exists()


@pytest.mark.slow
def test_travel_is_rad_or_with_deg_behind_it_degrees(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = {}
    testbed = ROOT / "data" / "testbed" / "rig.toml"
    for given in ("0.5235988", "30deg", "30°", "30"):
        assert within(monkeypatch, "plan", testbed, "--travel", given, "-o", tmp_path / "plan") == 0
        said[given] = capsys.readouterr()
        limits = tomllib.loads((tmp_path / "plan" / "plan.toml").read_text())["limits"]
        assert limits["yaw_rad"] == pytest.approx(30.0 if given == "30" else 0.5235988, rel=1e-6)
        assert "-0.0\n" not in (tmp_path / "plan" / "plan.toml").read_text()
    assert said["30deg"].out == said["0.5235988"].out == said["30°"].out
    assert "the runs keep to 0.523599 rad (30°; a linear axis: 0.523599 m) either way" in said["30deg"].err
    assert (
        "note: --travel 30 is rad, 4.77 turns, if the axis turns; degrees are written --travel 30deg" in said["30"].err
    )
    assert "turns" not in said["30deg"].err + said["0.5235988"].err
