"""Questions stop a command before its work begins, and leave nothing behind."""

from pathlib import Path

import numpy as np
import pytest

from rwjax import write_log, write_rig
from rwjax.diagnosis import diagnosis
from rwjax.fitting import fit
from rwjax.methods import comparison
from tests.cli.shell import DEMO, Shell
from tests.cli.test_compare import Result as Compared
from tests.fitting.questions.runs import LOGS, RIG, TIME
from tests.report.diagnosed import diagnosed, draws_one_figure


@pytest.fixture
def slow_clock(shell: Shell) -> Shell:
    """A folder with a rig and two of its logs, whose times are ten times too long."""
    (shell.folder / "rig.toml").write_text(write_rig(RIG))
    for log in LOGS[:2]:
        write_log(log.name, {"time_s": 10.0 * log.time, "voltage_V": log.command, "yaw_rad": log.outputs["yaw_rad"]})
    return shell


@pytest.mark.parametrize("command", ["fit", "diagnose", "compare"])
def test_a_question_ends_a_command_before_its_work(
    command: str, slow_clock: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("the search was begun")

    for module, name in ((fit, "fit"), (comparison, "compare"), (diagnosis, "diagnose")):
        monkeypatch.setattr(module, name, never)
    before = sorted(slow_clock.folder.iterdir())
    status, out, err = slow_clock(command, "rig.toml", "square.csv", "chirp.csv", "-o", "out", "--quiet")
    assert (status, out, len(err.splitlines())) == (2, "", 1)
    assert "is the time in units of 0.1 s? Divide `time_s` by 10" in err and "`--force` goes on even so" in err
    assert sorted(slow_clock.folder.iterdir()) == before


@pytest.mark.parametrize("command", ["fit", "diagnose", "compare"])
def test_rows_that_a_log_misses_under_a_changing_command_are_noted_beside_the_result(
    command: str, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(diagnosis, "diagnose", lambda rig, logs, **given: diagnosed())
    monkeypatch.setattr(comparison, "compare", lambda rig, logs, progress, solver: Compared())
    monkeypatch.setattr("rwjax.report.comparison.write_figure", lambda result, path: path)
    draws_one_figure(monkeypatch)
    rows = (DEMO / "multisine.csv").read_text().splitlines(keepends=True)
    for name, lost in (("whole.csv", 0), ("late.csv", 2)):
        (shell.folder / name).write_text("".join(rows[:500] + rows[500 + lost :]))
    status, _, err = shell(command, str(DEMO / "rig.toml"), "whole.csv", "late.csv", "-o", "out", "--quiet")
    first, *others = err.splitlines()
    said = (
        "note: late.csv: 2 rows are missing, the first after 4.97 s: the command changes at most samples, and counts as held there; "
        "write these rows with their command, readings empty"
    )
    assert (status, first) == (0, said) and (command == "fit" or not others) and "missing" not in "".join(others)


def test_many_rows_that_a_log_misses_are_noted_beside_a_fit(shell: Shell) -> None:
    rows = (DEMO / "square.csv").read_text().splitlines(keepends=True)
    (shell.folder / "late.csv").write_text("".join(rows[:500] + rows[550:]))
    status, _, err = shell("fit", str(DEMO / "rig.toml"), "late.csv", "-o", "out", "--quiet")
    told = [line for line in err.splitlines() if "gap in time" in line]
    assert (
        status == 0 and len(told) == 1 and told[0].startswith("note: late.csv: 1 gap in time, the longest 0.51 s at ")
    )


@pytest.mark.slow
def test_with_force_a_fit_goes_on_and_notes_the_question(shell: Shell) -> None:
    (shell.folder / "rig.toml").write_text(write_rig(RIG))
    log = LOGS[0].cut(0, 300)
    write_log("log.csv", {"time_s": log.time, "voltage_V": -log.command, "yaw_rad": log.outputs["yaw_rad"]})
    call = ("fit", "rig.toml", "log.csv", "-o", "fitted.toml", "--quiet")
    assert shell(*call)[0] == 2 and not Path("fitted.toml").exists()
    status, _, err = shell(*call, "--force")
    assert status == 0 and "is its sign, or that of the command, wrong?" in err and Path("fitted.toml").exists()


@pytest.mark.slow
def test_an_estimate_that_ran_away_is_written_with_force_alone(shell: Shell) -> None:
    """The readings are noise in which no motion shows."""
    (shell.folder / "rig.toml").write_text(write_rig(RIG))
    noise = 0.3 * np.random.default_rng(2).normal(size=len(TIME))
    write_log("log.csv", {"time_s": TIME, "voltage_V": LOGS[0].command, "yaw_rad": noise})
    call = ("fit", "rig.toml", "log.csv", "-o", "fitted.toml", "--quiet")
    status, out, err = shell(*call)
    assert (status, out, len(err.splitlines())) == (2, "", 1) and not Path("fitted.toml").exists()
    assert "axis.inertia ran away from 0.1 to" in err and "`--force` goes on even so" in err
    assert shell(*call, "--force")[0] == 0 and Path("fitted.toml").exists()
