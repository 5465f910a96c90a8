"""The command `check`: what it prints, and its status."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax.cli.check import check
from rwjax.errors import InputError
from rwjax.logs.write import write_log
from rwjax.rig.write import write_rig
from tests.fitting.questions.test_numbers import RIG, U, log


@pytest.mark.parametrize("factor", [1.0, 57.3])
def test_logs_in_other_units_end_with_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], factor: float
) -> None:
    run = log(U)
    (tmp_path / "rig.toml").write_text(write_rig(RIG))
    write_log(
        tmp_path / "run.csv", {"time_s": run.time, "voltage_V": run.command, "yaw_rad": factor * run.outputs["yaw_rad"]}
    )
    files = tmp_path / "rig.toml", [tmp_path / "run.csv"]
    if factor == 1.0:
        check(*files, as_json=False, quiet=True)
        said = capsys.readouterr().out.splitlines()
        assert said[-2].startswith("nothing odd was found")
        assert said[-1] == f"next: rwjax fit {tmp_path / 'rig.toml'} {tmp_path / 'run.csv'}"
        return
    with pytest.raises(InputError, match=r"rig\.toml: .*degrees"):
        check(*files, as_json=True, quiet=True)
    said = json.loads(capsys.readouterr().out)
    assert said["schema"] == "rwjax.check/1" and not said["usable"]
    assert said["findings"][0]["about"] == "units" and np.isclose(said["logs"][0]["seconds"], 5.99)


def test_a_question_is_printed_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = log(U)
    (tmp_path / "rig.toml").write_text(write_rig(RIG))
    columns = {"time_s": run.time, "voltage_V": run.command, "yaw_rad": 57.3 * run.outputs["yaw_rad"]}
    write_log(tmp_path / "run.csv", columns)
    with pytest.raises(InputError) as error:
        check(tmp_path / "rig.toml", [tmp_path / "run.csv"], as_json=False, quiet=True)
    printed = capsys.readouterr()
    assert (printed.out + printed.err + str(error.value)).count("are the readings in degrees?") == 1
    assert str(error.value).endswith("rig: settle what is asked about under `units`, in the logs or in the file")


def test_logs_that_tell_nothing_are_not_said_to_be_ready_for_a_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "rig.toml").write_text(write_rig(RIG))
    run = log(0.0 * U)
    columns = {"time_s": run.time, "voltage_V": run.command, "yaw_rad": run.outputs["yaw_rad"]}
    write_log(tmp_path / "run.csv", columns)
    check(tmp_path / "rig.toml", [tmp_path / "run.csv"], as_json=False, quiet=True)
    said = capsys.readouterr().out.splitlines()
    assert said[-2].startswith("- numbers: these logs tell nothing of axis.inertia, ") and "`rwjax plan`" in said[-2]
    assert said[-1] == f"next: rwjax plan {tmp_path / 'rig.toml'} --volts VOLTS"
    assert sum(line.startswith("- numbers: ") for line in said) == 1


@pytest.mark.parametrize(
    ("free", "role", "suggested"), [(("axis.inertia",), "", "fit"), ((), "", "diagnose"), ((), "validate", "")]
)
def test_the_next_command_is_one_that_the_files_allow(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], free: tuple[str, ...], role: str, suggested: str
) -> None:
    run = log(U)
    (tmp_path / "rig.toml").write_text(write_rig(replace(RIG, free=free)))
    columns = {"time_s": run.time, "voltage_V": run.command, "yaw_rad": run.outputs["yaw_rad"]}
    write_log(tmp_path / "run.csv", columns, {"role": role} if role else None)
    check(tmp_path / "rig.toml", [tmp_path / "run.csv"], as_json=False, quiet=True)
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith(f"next: rwjax {suggested} " if suggested else "no log to fit on: every one is marked ")


@pytest.mark.parametrize("as_json", [False, True])
def test_readings_that_wrap_stand_first_and_are_what_is_to_be_settled(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], as_json: bool
) -> None:
    (tmp_path / "rig.toml").write_text(write_rig(RIG))
    run = log(U)
    y = np.mod(9.5 * run.outputs["yaw_rad"] + 1.0, 2.0 * np.pi)
    write_log(tmp_path / "run.csv", {"time_s": run.time, "voltage_V": run.command, "yaw_rad": y})
    with pytest.raises(InputError) as error:
        check(tmp_path / "rig.toml", [tmp_path / "run.csv"], as_json=as_json, quiet=True)
    out = capsys.readouterr().out
    if as_json:
        found = json.loads(out)["findings"]
        assert "it wraps" in str(error.value) and [one["about"] for one in found][:2] == ["readings", "units"]
        return
    assert "readings wrap: settle what stands first under `readings`" in str(error.value)
    first, second = [line for line in out.splitlines() if line.startswith("- ")][:2]
    assert first.startswith("- readings: ") and "it wraps" in first and second.startswith("- units: ")


def test_logs_that_have_to_be_mended_are_checked_again_before_a_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "rig.toml").write_text(write_rig(RIG))
    run = log(U)
    y = run.outputs["yaw_rad"] + 1e-4 * np.random.default_rng(0).normal(size=len(run.time))
    y[300:360] = y[300]
    write_log(tmp_path / "run.csv", {"time_s": run.time, "voltage_V": run.command, "yaw_rad": y})
    check(tmp_path / "rig.toml", [tmp_path / "run.csv"], as_json=True, quiet=True)
    assert "frozen" in {one["kind"] for one in json.loads(capsys.readouterr().out)["findings"]}
    check(tmp_path / "rig.toml", [tmp_path / "run.csv"], as_json=False, quiet=True)
    first, ahead = capsys.readouterr().out.splitlines()[-2:]
    assert first == (
        "mend first what stands under `readings` in run.csv, then check again; where the rig did rest there, `rwjax fit` takes the logs "
        "as they are"
    )
    assert ahead == f"next: rwjax check {tmp_path / 'rig.toml'} {tmp_path / 'run.csv'}"


@pytest.mark.parametrize("every", [True, False])
def test_logs_without_readings_are_for_no_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str], every: bool) -> None:
    (tmp_path / "rig.toml").write_text(write_rig(RIG))
    run = log(U)
    write_log(tmp_path / "bare.csv", {"time_s": run.time, "voltage_V": run.command})
    columns = {"time_s": run.time, "voltage_V": run.command, "yaw_rad": run.outputs["yaw_rad"]}
    write_log(tmp_path / "run.csv", columns)
    files = [tmp_path / "bare.csv", *([] if every else [tmp_path / "run.csv"])]
    check(tmp_path / "rig.toml", files, as_json=False, quiet=True)
    assert capsys.readouterr().out.splitlines()[-1] == (
        f"next: rwjax predict {tmp_path / 'rig.toml'} {tmp_path / 'bare.csv'}"
        if every
        else f"next: rwjax fit {tmp_path / 'rig.toml'} {tmp_path / 'run.csv'}"
    )


def test_no_volts_are_asked_for_where_the_rig_file_knows_its_supply(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig = replace(RIG, numbers=RIG.numbers | {"drive.supply": 12.0})
    (tmp_path / "rig.toml").write_text(write_rig(rig))
    still = np.zeros(200)
    write_log(tmp_path / "run.csv", {"time_s": 0.01 * np.arange(200), "voltage_V": still, "yaw_rad": still})
    check(tmp_path / "rig.toml", [tmp_path / "run.csv"], as_json=False, quiet=True)
    assert capsys.readouterr().out.splitlines()[-1] == f"next: rwjax plan {tmp_path / 'rig.toml'}"


def test_logs_with_readings_that_are_all_kept_for_validation_are_for_no_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "rig.toml").write_text(write_rig(RIG))
    run = log(U)
    columns = {"time_s": run.time, "voltage_V": run.command}
    write_log(tmp_path / "bare.csv", columns)
    write_log(tmp_path / "run.csv", columns | {"yaw_rad": run.outputs["yaw_rad"]}, {"role": "validate"})
    check(tmp_path / "rig.toml", [tmp_path / "bare.csv", tmp_path / "run.csv"], as_json=False, quiet=True)
    last = capsys.readouterr().out.splitlines()[-1]
    assert last == (
        "no log to fit on: every one with readings is marked `# role: validate`; give one without that line"
    )
