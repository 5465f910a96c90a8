"""The commands, as a user's shell sees them."""

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rwjax import __version__, read_rig
from tests.command import rwjax as within

ROOT = Path(__file__).resolve().parents[2]
DEMO = ROOT / "data" / "demo"
LOGS = [str(DEMO / f"{name}.csv") for name in ("square", "triangle", "multisine", "stair", "mixed")]


def rwjax(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "rwjax", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )


def test_diagnose_names_what_the_demo_lacks_and_writes_everything(tmp_path: Path) -> None:
    done = rwjax("diagnose", str(DEMO / "rig.toml"), *LOGS, "-o", "out", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer == json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert (answer["schema"], answer["verdict"], answer["effects"]) == (
        "rwjax.diagnosis/1",
        "effect",
        ["axis.stribeck"],
    )
    assert (answer["where"]["subsystem"], answer["where"]["coordinate"]) == ("axis", "yaw_rate")
    assert answer["held_out"] == "marked"
    assert answer["gap"]["signal"] == "yaw_rad"
    assert answer["gap"]["after"] < answer["gap"]["floor"]  # its own form of friction: nothing is left
    assert sum(r["probability"] for r in answer["ranking"]) == pytest.approx(1.0)
    rig = read_rig(tmp_path / "out" / "corrected.toml")
    corrected = rig.values
    assert corrected["axis.inertia"] == pytest.approx(0.228, rel=1e-3)  # what make_demo.py simulates
    true = {"M_c": 0.45, "M_e": 0.3, "v_s": 0.35, "n": 1.5}
    assert {name: corrected[f"axis.stribeck.{name}"] for name in true} == pytest.approx(true, rel=5e-3)
    assert {*rig.free} == {"axis.inertia", "axis.friction.viscous", *(f"axis.stribeck.{name}" for name in true)}
    told = answer["drift"][-1]["effect_numbers"]
    assert {name: one["value"] for name, one in told.items()} == {
        f"axis.stribeck.{n}": corrected[f"axis.stribeck.{n}"] for n in true
    }
    assert [one["unit"] for one in told.values()] == ["N m", "N m", "rad/s", ""]
    assert all(one["standard_error"] == rig.standard_error[name] for name, one in told.items())
    page = (tmp_path / "out" / "report.html").read_text()
    assert "http" not in page.replace("http://www.w3.org", "").replace("https://www.w3.org", "").replace(
        "http://purl.org", ""
    ).replace("http://creativecommons.org", "").replace("https://matplotlib.org", "")
    assert page.index("The rig lacks Stribeck friction") < page.index("<svg")


def test_the_corrected_file_predicts_what_the_diagnosis_claims(tmp_path: Path) -> None:
    rig = (DEMO / "rig.toml").read_text().replace("free = [", 'free = ["axis.stribeck.M_c", "axis.stribeck.M_e", ')
    rig += '\n[effects."axis.stribeck"]\nM_c = 0.4\nM_e = 0.2\nv_s = 0.4\n'
    (tmp_path / "rig.toml").write_text(rig)
    assert rwjax("fit", "rig.toml", *LOGS, "-o", "fitted.toml", cwd=tmp_path).returncode == 0
    done = rwjax("predict", "fitted.toml", LOGS[3], "-o", "pred.csv", cwd=tmp_path)
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


def test_what_it_is_and_how_to_go_on(tmp_path: Path) -> None:
    assert rwjax("--version", cwd=tmp_path).stdout == f"rwjax {__version__}\n"
    bare = rwjax(cwd=tmp_path)
    assert bare.returncode == 0 and "diagnose" in bare.stdout
    units = rwjax("size", "--help", cwd=tmp_path).stdout
    assert all(f"[{unit}]" in units for unit in ("°", "s", "mm", "V", "A", "1/min"))


def test_ctrl_c_ends_a_command_with_a_word_and_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*given: object) -> None:
        raise KeyboardInterrupt

    def leave(status: int) -> None:
        raise SystemExit(status)

    monkeypatch.setattr("rwjax.diagnosis.diagnosis.diagnose", interrupted)
    monkeypatch.setattr("os._exit", leave)
    assert within(monkeypatch, "diagnose", DEMO / "rig.toml", *LOGS, "-o", tmp_path / "out") == 130
    assert capsys.readouterr().err == "rwjax: interrupted\n"
    assert not (tmp_path / "out").exists()


@pytest.fixture
def hears_ctrl_c() -> Iterator[None]:
    """Lets what a test begins hear Ctrl-C, which it inherits to ignore where the tests run in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("hears_ctrl_c")
@pytest.mark.parametrize("program", [("-m", "rwjax"), (str(Path(sys.executable).with_name("rwjax")),)])
@pytest.mark.parametrize(
    ("library", "arguments"), [("typer", ["--version"]), ("jax", ["region", DEMO / "rig.toml"])], ids=["typer", "jax"]
)
def test_ctrl_c_while_the_program_starts_is_one_line(
    tmp_path: Path, program: tuple[str, ...], library: str, arguments: list[str | Path]
) -> None:
    """A library that interrupts its own import, as Ctrl-C does that comes then."""
    (tmp_path / f"{library}.py").write_text(
        "import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(9)\n"
    )
    paths = {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"}
    done = subprocess.run(
        [sys.executable, *program, *map(str, arguments)],
        capture_output=True,
        text=True,
        env=os.environ | paths,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "rwjax: interrupted\n")


@pytest.mark.usefixtures("hears_ctrl_c")
def test_a_program_that_imports_the_library_keeps_its_ctrl_c() -> None:
    ask = "import signal, rwjax; print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    done = subprocess.run(
        [sys.executable, "-c", ask],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    assert done.stdout == "True\n"


@pytest.mark.usefixtures("hears_ctrl_c")
def test_a_process_that_the_command_begins_keeps_its_ctrl_c(tmp_path: Path) -> None:
    (tmp_path / "rwjax").write_text(
        "import multiprocessing, signal, rwjax.cli\n"
        "def ask(): print(signal.getsignal(signal.SIGINT) is signal.default_int_handler, flush=True)\n"
        "if __name__ == '__main__':\n"
        "    ask()\n"
        "    child = multiprocessing.get_context('spawn').Process(target=ask)\n"
        "    child.start(), child.join()\n"
    )
    done = subprocess.run(
        [sys.executable, str(tmp_path / "rwjax")],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    assert done.stdout == "False\nTrue\n"


@pytest.mark.slow
def test_readings_of_the_wrong_sign_or_unit_are_asked_about(tmp_path: Path) -> None:
    lines = [line.split(",") for line in Path(LOGS[0]).read_text().splitlines() if line[:1].isdigit()]
    for factor, asked in ((-1.0, "is its sign, or that of the command, wrong?"), (180.0 / np.pi, "in degrees?")):
        rows = [f"{t},{u},{factor * float(n) * 2.0 * np.pi / 2048:.6f}" for t, u, n in lines]
        (tmp_path / "log.csv").write_text("\n".join(["time_s,voltage_V,yaw_rad", *rows, ""]))
        done = rwjax("fit", str(DEMO / "rig.toml"), "log.csv", "-o", "fitted.toml", cwd=tmp_path)
        first, *others = done.stderr.splitlines()
        assert first.startswith("note: yaw_rad ") and asked in first
        assert others[-1].startswith("note: fitted.toml is written even so") and (tmp_path / "fitted.toml").exists()
        assert not any("Warning" in line for line in others)
        predicted = rwjax("predict", str(DEMO / "rig.toml"), "log.csv", cwd=tmp_path)
        assert predicted.returncode == 0 and predicted.stderr.splitlines() == [first]
    rows = [
        f"{t},{u},{-float(n) * 2.0 * np.pi / 2048:.6f}" if k % 2 else f"{t},{u}," for k, (t, u, n) in enumerate(lines)
    ]
    (tmp_path / "log.csv").write_text("\n".join(["time_s,voltage_V,yaw_rad", *rows, ""]))  # every other reading missing
    done = rwjax("fit", str(DEMO / "rig.toml"), "log.csv", "-o", "fitted.toml", cwd=tmp_path)
    assert "is its sign, or that of the command, wrong?" in done.stderr
    assert re.search(r"times their noise, most yaw_rad of log\.csv, by [\d.]+ rad RMS: the model lacks", done.stderr)
    done = rwjax("fit", str(DEMO / "rig.toml"), LOGS[0], "-o", "fitted.toml", cwd=tmp_path)
    assert "rig file's numbers give" not in done.stderr and "written even so" not in done.stderr


@pytest.mark.parametrize("which", [0, 1], ids=["the rig file", "a log"])
def test_a_fit_spares_its_inputs(which: int, tmp_path: Path) -> None:
    given = [tmp_path / "rig.toml", tmp_path / "log.csv"]
    given[0].write_bytes((DEMO / "rig.toml").read_bytes())
    given[1].write_bytes(Path(LOGS[0]).read_bytes())
    before = given[which].read_bytes()
    done = rwjax("fit", "rig.toml", "log.csv", "-o", given[which].name, cwd=tmp_path)
    assert done.returncode == 2 and "is the input; give another path with -o" in done.stderr
    assert given[which].read_bytes() == before


def test_predict_without_outputs_starts_at_rest_at_zero(tmp_path: Path) -> None:
    rows = "\n".join(f"{0.01 * k:.2f},{0.5 if k > 20 else 0}" for k in range(100))
    (tmp_path / "u.csv").write_text(f"time_s,voltage_V\n{rows}\n")
    done = rwjax("predict", str(DEMO / "rig.toml"), "u.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "time_s,yaw_rad,yaw_rad_s"
    assert [float(v) for v in lines[21].split(",")] == [0.2, 0.0, 0.0]
    assert float(lines[-1].split(",")[1]) > 0.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fit", "absent.toml", "log.csv"], "absent.toml"),
        (["fit", "rig.toml", "absent.csv"], "absent.csv"),
        (["diagnose", "rig.toml", "log.csv"], "log.csv"),
        (["predict", "rig.toml", "log.csv"], "log.csv"),
    ],
)
def test_unusable_input_ends_with_one_line_and_status_2(tmp_path: Path, arguments: list[str], words: str) -> None:
    (tmp_path / "rig.toml").write_text((DEMO / "rig.toml").read_text())
    (tmp_path / "log.csv").write_text("time_s,voltage_V,yaw_count\n0,0,0\n")
    done = rwjax(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert words in done.stderr


def test_region_writes_gains_and_a_figure_and_says_what_it_leaves_out(tmp_path: Path) -> None:
    rig = 'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02\n'
    (tmp_path / "rig.toml").write_text(rig + '[effects."drive.delay"]\ntau = 0.02\n')
    grid = ("--kp", "0:10:3", "--kd", "0:2:2")
    done = rwjax("region", "rig.toml", *grid, "-o", "region.csv", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)  # s^2 + (0.2 + 4 kd) s + 4 kp
    assert answer["schema"] == "rwjax.region/1" and answer["stable"] == [[0, 0], [0, 1], [0, 1]]
    assert "drive.delay" in done.stderr
    lines = (tmp_path / "region.csv").read_text().splitlines()
    assert lines[0] == "kp,kd,stable" and lines[4] == "5,2,1" and len(lines) == 7
    assert (tmp_path / "region.png").read_bytes().startswith(b"\x89PNG")
    plain = rwjax("region", "rig.toml", *grid, "--quiet", cwd=tmp_path)
    assert plain.stdout.splitlines() == lines and plain.stderr == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--kp", "0:100"), "--kp 0:100: has to be FROM:TO:COUNT"),
        (("--kd", "0:inf:3"), "--kd 0:inf:3: has to be FROM:TO:COUNT"),
        (("--sigma", "nan"), "--sigma nan: has to be a finite number"),
        ((), "rig.toml: kind `wheel`: there is no axis"),
    ],
)
def test_region_refuses_in_one_line(tmp_path: Path, arguments: tuple[str, ...], message: str) -> None:
    motor = "[motor]\ntorque_constant = 0.0182\nresistance = 0.83\n[wheel]\ninertia = 1.24e-4\n"
    (tmp_path / "rig.toml").write_text('kind = "wheel"\n' + motor)
    done = rwjax("region", "rig.toml", *arguments, "-o", "region.csv", cwd=tmp_path)
    assert done.returncode == 2 and done.stdout == "" and not (tmp_path / "region.csv").exists()
    assert done.stderr.startswith(f"rwjax: {message}") and done.stderr.count("\n") == 1
