"""`rwjax fit`, as a user calls it."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from rwjax import read_rig, simulate, write_log, write_rig
from rwjax.fitting import fit as fitting
from tests.cli.shell import DEMO, LOGS, Shell, program
from tests.fitting.logs import log_of
from tests.systems import platform

MOTOR = """kind = "wheel"
[motor]
torque_constant = 0.0182
resistance = 0.83
friction = 4e-6
[wheel]
inertia = 1.24e-4
[fit]
free = ["motor.friction"]
"""


def test_logs_that_tell_nothing_of_any_free_number_give_no_rig_file(tmp_path: Path, shell: Shell) -> None:
    (tmp_path / "rig.toml").write_text(MOTOR)
    rows = [f"{0.01 * k:.2f},0,0" for k in range(50)]
    (tmp_path / "still.csv").write_text("\n".join(["time_s,voltage_V,wheel_rad_s", *rows]))
    output = tmp_path / "fitted.toml"
    code, _, err = shell("fit", "rig.toml", "still.csv", "-o", "fitted.toml")
    assert code != 0 and not output.exists()
    assert "tell nothing of motor.friction: use runs in which the command changes and the rig moves; `--force`" in err
    assert shell("fit", "rig.toml", "still.csv", "-o", "fitted.toml", "--force")[0] == 0


def test_a_fit_says_what_it_is_at(shell: Shell) -> None:
    shell.patch.setattr("rwjax.cli.progress.EVERY_S", 0.01)
    code, _, err = shell("fit", str(DEMO / "rig.toml"), LOGS[0], "-o", "fitted.toml")
    assert (
        code == 0 and "fitting, start " in err and " at most\n" in err
    )  # what is over within a hundredth of a second may go untold


def test_a_fit_whose_logs_tell_only_a_combination_says_so_and_writes_the_rig_file(tmp_path: Path, shell: Shell) -> None:
    rig = platform("viscous = 0.0", free='"axis.inertia", "drive.gain"')
    log = log_of(rig, noise=1e-3)
    (tmp_path / "rig.toml").write_text(write_rig(rig))
    write_log(tmp_path / "run.csv", {"time_s": log.time, "voltage_V": log.command, "yaw_rad": log.outputs["yaw_rad"]})
    _, out, _ = shell("check", "rig.toml", "run.csv")
    assert "determined by these logs: fix one" in out and out.splitlines()[-1].startswith("next: rwjax fit ")
    code, _, err = shell("fit", "rig.toml", "run.csv", "-o", "fitted.toml")
    assert code == 0 and (tmp_path / "fitted.toml").exists() and "tell nothing" not in err
    assert "only a combination of drive.gain and axis.inertia is determined by these logs: fix one" in err


@pytest.mark.slow
def test_the_corrected_file_predicts_what_the_diagnosis_claims(tmp_path: Path) -> None:
    rig = (DEMO / "rig.toml").read_text().replace("free = [", 'free = ["axis.stribeck.M_c", "axis.stribeck.M_e", ')
    rig += '\n[effects."axis.stribeck"]\nM_c = 0.4\nM_e = 0.2\nv_s = 0.4\n'
    (tmp_path / "rig.toml").write_text(rig)
    assert program("fit", "rig.toml", *LOGS, "-o", "fitted.toml", cwd=tmp_path).returncode == 0
    done = program("predict", "fitted.toml", LOGS[3], "-o", "pred.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    names = (tmp_path / "pred.csv").read_text().splitlines()[0]
    assert names == "time_s,yaw_rad"
    predicted = np.loadtxt(tmp_path / "pred.csv", delimiter=",", skiprows=1)
    measured = np.loadtxt(LOGS[3], delimiter=",", skiprows=3)
    assert np.array_equal(predicted[:, 0], measured[:, 0])
    error = predicted[:, 1] - measured[:, 2] * 2 * np.pi / 2048
    assert f"yaw_rad: RMS error {np.sqrt(np.mean(error**2)):.4g} rad of a signal of RMS" in done.stdout
    assert done.stderr == ""
    assert np.sqrt(np.mean(error**2)) < 0.2 < np.std(measured[:, 2] * 2 * np.pi / 2048)


@pytest.mark.slow
def test_readings_of_the_wrong_sign_or_unit_are_asked_about(tmp_path: Path) -> None:
    lines = [line.split(",") for line in Path(LOGS[0]).read_text().splitlines() if line[:1].isdigit()]
    for factor, asked in ((-1.0, "is its sign, or that of the command, wrong?"), (180.0 / np.pi, "in degrees?")):
        rows = [f"{t},{u},{factor * float(n) * 2.0 * np.pi / 2048:.6f}" for t, u, n in lines]
        (tmp_path / "log.csv").write_text("\n".join(["time_s,voltage_V,yaw_rad", *rows, ""]))
        stopped = program("fit", str(DEMO / "rig.toml"), "log.csv", "-o", "fitted.toml", cwd=tmp_path)
        (line,) = stopped.stderr.splitlines()
        assert stopped.returncode == 2 and line.startswith("rwjax: yaw_rad ") and asked in line
        assert line.endswith("; `--force` goes on even so") and not (tmp_path / "fitted.toml").exists()
        done = program("fit", str(DEMO / "rig.toml"), "log.csv", "-o", "fitted.toml", "--force", cwd=tmp_path)
        first, *others = [line for line in done.stderr.splitlines() if line.startswith(("note: ", "rwjax: "))]
        assert first.startswith("note: yaw_rad ") and asked in first
        assert others[-1].startswith("note: fitted.toml is written even so") and (tmp_path / "fitted.toml").exists()
        assert not any("Warning" in line for line in others)
        predicted = program("predict", str(DEMO / "rig.toml"), "log.csv", cwd=tmp_path)
        error, doubt = predicted.stderr.splitlines()
        assert predicted.returncode == 0 and error.startswith("note: yaw_rad: RMS error ") and doubt == first
        (tmp_path / "fitted.toml").unlink()
    rows = [
        f"{t},{u},{-float(n) * 2.0 * np.pi / 2048:.6f}" if k % 2 else f"{t},{u}," for k, (t, u, n) in enumerate(lines)
    ]
    (tmp_path / "log.csv").write_text("\n".join(["time_s,voltage_V,yaw_rad", *rows, ""]))  # every other reading missing
    done = program("fit", str(DEMO / "rig.toml"), "log.csv", "-o", "fitted.toml", "--force", cwd=tmp_path)
    assert "is its sign, or that of the command, wrong?" in done.stderr
    assert re.search(r"times their noise, most yaw_rad of log\.csv, by [\d.]+ rad RMS: the model lacks", done.stderr)
    done = program("fit", str(DEMO / "rig.toml"), LOGS[0], "-o", "fitted.toml", cwd=tmp_path)
    assert "rig file's numbers give" not in done.stderr and "written even so" not in done.stderr


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("question", [False, True], ids=["rows alone", "a question"])
def test_only_a_question_that_is_left_open_makes_a_written_file_doubtful(
    question: bool, force: bool, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits = fitting.fit
    monkeypatch.setattr(fitting, "fit", lambda *given, **more: replace(fits(*given, **more), notes=()))
    monkeypatch.setattr("rwjax.fitting.questions.ask.questions", lambda rig, logs: question * ["is it so?"])
    rows = (DEMO / "multisine.csv").read_text().splitlines(keepends=True)
    (shell.folder / "late.csv").write_text("".join(rows[:500] + rows[502:]))
    code, _, err = shell(
        "fit", str(DEMO / "rig.toml"), "late.csv", "-o", "fitted.toml", "--quiet", *force * ["--force"]
    )
    if question and not force:
        assert (code, err) == (2, "rwjax: is it so?; `--force` goes on even so\n")
        return
    missing = (
        "note: late.csv: 2 rows are missing, the first after 4.97 s: the command changes at most samples, and counts as held there; "
        "write these rows with their command, readings empty\n"
    )
    even_so = "note: fitted.toml is written even so; its numbers are those of the logs as they are\n"
    assert (code, err) == (0, question * "note: is it so?\n" + missing + question * even_so)


@pytest.mark.parametrize("which", [0, 1], ids=["the rig file", "a log"])
def test_a_fit_spares_its_inputs(which: int, shell: Shell) -> None:
    given = [shell.folder / "rig.toml", shell.folder / "log.csv"]
    given[0].write_bytes((DEMO / "rig.toml").read_bytes())
    given[1].write_bytes(Path(LOGS[0]).read_bytes())
    before = given[which].read_bytes()
    code, _, err = shell("fit", "rig.toml", "log.csv", "-o", given[which].name)
    assert code == 2 and "is the input; give another path with -o" in err
    assert given[which].read_bytes() == before


def test_a_bootstrap_is_refused_by_methods_with_errors_of_their_own(shell: Shell) -> None:
    for method in ("two-stage", "limit-speeds"):
        code, out, err = shell("fit", "rig.toml", "log.csv", "--method", method, "--bootstrap", "40")
        assert code == 2 and out == "" and err.startswith("rwjax: --bootstrap: the ") and err.count("\n") == 1


@pytest.mark.slow
def test_limit_speeds_write_a_fitted_rig_file(shell: Shell) -> None:
    (shell.folder / "motor.toml").write_text(MOTOR)
    wanted = np.repeat([0.0, 2.0, 4.0, 6.0, 8.0], 400)
    keep = np.exp(-0.01 * 54.39 * 0.0182 / 0.31)  # the rig's own pace, so that nothing is asked
    speed = np.asarray(lfilter([0.0, 1.0 - keep], [1.0, -keep], 54.39 * wanted))
    noisy = speed + 0.1 * np.random.default_rng(0).normal(size=len(speed))
    rows = [f"{0.01 * k:.2f},{u},{w:.4f}" for k, (u, w) in enumerate(zip(wanted, noisy, strict=True))]
    (shell.folder / "stairs.csv").write_text("\n".join(["time_s,voltage_V,wheel_rad_s", *rows, ""]))
    options = ("--method", "limit-speeds", "-o", "fitted.toml")
    code, out, err = shell("fit", "motor.toml", "stairs.csv", *options)
    assert code == 0 and out.startswith("motor.friction = 4.0") and "rests on motor.torque_constant" in err, err
    assert out.endswith("next: rwjax predict fitted.toml stairs.csv -o predicted.csv\n")
    fitted = read_rig(shell.folder / "fitted.toml")
    b, error = fitted.values["motor.friction"], fitted.standard_error["motor.friction"]
    assert abs(b - (0.0182 / 54.39 - 0.0182**2) / 0.83) < 4.0 * error < 1e-7
    (shell.folder / "motor.toml").write_text(MOTOR.replace("free = [", 'free = ["motor.torque_constant", '))
    code, _, err = shell("fit", "motor.toml", "stairs.csv", *options)
    assert (
        code == 2 and err.startswith("rwjax: motor.toml: ") and "tells R b/K + K alone" in err and err.count("\n") == 1
    )


def test_a_fit_that_misses_its_logs_leads_to_the_diagnosis(shell: Shell) -> None:
    code, out, err = shell("fit", str(DEMO / "rig.toml"), LOGS[0], "-o", "fitted.toml", "--force")
    assert code == 0 and "the model lacks something" in err, err
    assert out.splitlines()[-1] == f"next: rwjax diagnose fitted.toml {LOGS[0]} --force"


@pytest.mark.slow
def test_a_fit_by_the_smooth_solver_leads_to_a_prediction_by_it(shell: Shell) -> None:
    t = 0.01 * np.arange(300)
    volts = 2.0 * np.sign(np.sin(4.0 * t)) * (t > 0.6)
    rig = replace(platform("viscous = 0.02\ncoulomb = 0.3"), free=("axis.inertia",))
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    write_log(
        shell.folder / "run.csv",
        {"time_s": t, "voltage_V": volts, "yaw_rad": np.asarray(simulate(rig, t, volts)["yaw_rad"]) + noise},
        {},
    )
    (shell.folder / "rig.toml").write_text(write_rig(rig))
    code, out, err = shell("fit", "rig.toml", "run.csv", "--solver", "diffrax", "-o", "smooth.toml", "--quiet")
    (width,) = re.findall(r"takes --smooth ([\d.e-]+),", err)
    wanted = f"next: rwjax predict smooth.toml run.csv -o predicted.csv --solver diffrax --smooth {width}"
    assert code == 0 and out.splitlines()[-1] == wanted
