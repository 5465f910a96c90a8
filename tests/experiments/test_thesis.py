"""The regenerated logs of the thesis and what they must show; its rig as a file, and the commands on it."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest

from experiments.thesis import regenerate
from rwjax import read_log, read_rig
from rwjax.kinds import COEFFICIENTS
from tests.command import rwjax

DATA = Path(__file__).parents[2] / "data" / "thesis"
YAW = DATA / "yaw.toml"
TESTED = ("--kp", "40:100:2", "--kd", "10:10:1")  # (40, 10) and (100, 10)


def test_the_logs_are_what_the_script_writes(tmp_path: Path) -> None:
    angle = regenerate.coast_down()
    regenerate.write(tmp_path / "coast_down.csv", np.zeros(len(angle)), angle)
    assert (tmp_path / "coast_down.csv").read_text() == (DATA / "coast_down.csv").read_text()
    assert {path.stem for path in DATA.glob("*.csv")} == {"coast_down", *regenerate.commands()}


def test_the_platform_stays_put_below_its_dead_band() -> None:
    dead = regenerate.FRICTION(0.0) / regenerate.GAIN
    assert 4.0 < dead < 4.4
    assert np.all(regenerate.platform(np.full(300, 0.99 * dead)) == 0.0)
    assert regenerate.platform(np.full(300, 1.01 * dead))[-1] > 0.0


def test_the_label_travels_with_every_log() -> None:
    rig = read_rig(DATA / "platform.toml")
    for path in DATA.glob("*.csv"):
        assert "not measured" in read_log(path, rig).notes["note"]


def test_the_rig_file_has_the_numbers_of_the_thesis() -> None:
    rig = read_rig(YAW)
    n = rig.numbers
    K, R, b = n["motor.torque_constant"], n["motor.resistance"], n["motor.friction"]
    assert (K, R, n["motor.inductance"], n["wheel.inertia"]) == (0.0182, 0.83, 0.0641, 1.24e-4)  # Table 3.1
    assert b == pytest.approx(4.07e-6, abs=0.005e-6)  # its last digit
    assert K / (R * b + K**2) == pytest.approx(54.39, abs=0.00001)  # eq. 3.3 at the slope of listing A.3
    assert n["axis.inertia"] == pytest.approx(0.0432 + 0.3 * 0.145**2)  # listing A.4
    per_inertia = [n[name] / n["axis.inertia"] for name in COEFFICIENTS]  # b3, b2, b1, b0 of listing A.4
    assert per_inertia == pytest.approx([0.37570, -5.2491e-2, 2.0461e-2, -6.8912e-4])
    assert rig.counts_per_rev == {"axis": 2 * 1024, "wheel": 2 * 1024}  # both edges of one channel


def test_the_readme_s_commands_run_on_the_rig_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def answer(*arguments: object) -> tuple[list[dict[str, str]], str]:
        assert rwjax(monkeypatch, *arguments) == 0
        out, err = capsys.readouterr()
        return list(csv.DictReader(io.StringIO(out))), err

    tested, _ = answer("region", YAW, "--sigma", "0.5", *TESTED)
    assert [row["stable"] for row in tested] == ["1", "1"]  # both of the thesis's pairs lie in its region
    rings = ("--radius", "50:50:1", "--thickness", "5:8:2")
    sized, _ = answer("size", YAW, "--angle", "45", "--seconds", "3", "--amps", "3", *rings)
    thin, thick = (float(row["time_s"]) for row in sized)
    assert thin == np.inf and thick < 3.0  # docs/thesis.md: 7.5 mm are needed, and the wheel's rate binds
    assert sized[1]["limit"] == "wheel rate"


@pytest.mark.slow
def test_the_readme_s_longer_commands_run_on_the_rig_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def answer(*arguments: object) -> tuple[str, str]:
        assert rwjax(monkeypatch, *arguments) == 0
        return capsys.readouterr()

    course, _ = answer("slew", YAW, "--angle", "45", "--amps", "3", "--rpm", "4000")
    last = list(csv.DictReader(io.StringIO(course)))[-1]
    assert float(last["yaw_rad"]) == pytest.approx(0.25 * np.pi, abs=1e-4)
    course, _ = answer("dump", YAW, "--spin", "4000")
    last = list(csv.DictReader(io.StringIO(course)))[-1]
    assert float(last["yaw_rad"]) == 0.0 and abs(float(last["wheel_rad_s"])) < 1e-3
    _, err = answer("sweep", YAW, *TESTED)
    assert "0 of 2 gain pairs settle" in err and "--ki helps" in err  # "a steady-state error stays"
    gains, err = answer("tune", YAW, "--ki", "10", "--sigma", "2")
    assert "tuned: kp" in gains and "settles in" in gains and "margin on the rig alone" in err
