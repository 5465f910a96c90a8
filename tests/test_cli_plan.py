"""`rwjax plan`, as a user calls it."""

import json
import tomllib
from pathlib import Path

import pytest

from tests.command import rwjax

DATA = Path(__file__).parents[1] / "data"


def test_a_plan_is_written_and_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    demo = DATA / "demo" / "rig.toml"
    assert rwjax(monkeypatch, "plan", demo, "--volts", 6, "--rate", 5, "-o", tmp_path / "plan") == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert lines[-1].endswith(f"written to {tmp_path / 'plan' / 'plan.toml'}") and max(map(len, lines[:-1])) <= 120
    written = tomllib.loads((tmp_path / "plan" / "plan.toml").read_text())
    assert written["rig"] == "thesis platform" and written["limits"] == {"voltage_V": 6.0, "yaw_rad_s": 5.0}
    for run in written["runs"]:
        assert (tmp_path / "plan" / f"{run['name']}.csv").exists() and run["reaches"]["yaw_rad_s"] <= 5.0
    assert {run["role"] for run in written["runs"]} == {"train", "validate"}
    unlimited, frictionless, by_hand = err.splitlines()
    assert unlimited.endswith("--travel (travel of the axis [rad])") and "known inertia" in by_hand
    assert "holds no dry friction" in frictionless  # the demo's file, though its rig sticks
    assert rwjax(monkeypatch, "plan", demo, "--volts", 6, "--rate", 5, "-o", tmp_path / "b", "--json", "--quiet") == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == written and err == ""


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "RIG: nothing says how many volts the drive gives; add --volts, such as --volts 12"),
        (("--volts", "-1"), "--volts -1: has to be positive"),
        (("--volts", "inf"), "--volts inf: has to be a finite number"),
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
    rig = DATA / "demo" / "rig.toml"
    assert rwjax(monkeypatch, "plan", rig, "-o", tmp_path / "plan", *arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("rwjax: " + said.replace("RIG", str(rig))) and error.count("\n") == 1
    assert not (tmp_path / "plan").exists()
