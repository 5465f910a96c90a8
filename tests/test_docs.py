"""The documentation names everything that a user may write, and only commands, modules and files that exist."""

import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import rwjax
from rwjax import parse_rig
from rwjax.cli.main import app
from rwjax.effects.library import EFFECTS
from rwjax.effects.parameter import parameters
from rwjax.kinds import COEFFICIENTS, KEYS, SERVO_CHOICES
from rwjax.rig.columns import COLUMNS, INPUTS
from tests.command import rwjax as command

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "data").glob("*/README.md"))]
MOST_LINES, WIDEST_CELL = 120, 200  # of the README; characters of a table's cell


def test_every_key_column_and_effect_is_documented() -> None:
    text = (ROOT / "docs" / "files.md").read_text()
    for key in {key.replace("drive.pwm.", "") for key in KEYS} - {"neutral_us", "volts_per_us"}:
        assert f"`{key}`" in text, key
    for column in (*COLUMNS, *INPUTS):
        assert f"`{column}`" in text, column
    rows = {line.split("|")[1].strip(" `"): line for line in text.splitlines() if line.startswith("| `")}
    for effect in EFFECTS:
        assert effect.name in rows, effect.name
        for parameter in parameters(effect):
            assert f"`{parameter}`" in rows[effect.name], (effect.name, parameter)
    assert COEFFICIENTS[0] in text


def test_rig_files_in_the_documentation_can_be_read() -> None:
    found = [
        block
        for page in (ROOT / "README.md", ROOT / "docs" / "files.md")
        for block in re.findall(r"^```toml\n(kind.*?)^```", page.read_text(), re.M | re.S)
    ]
    assert {parse_rig(block).kind for block in found} >= {"wheel", "platform"}


LOOKS = (ROOT / "docs" / "file_looks_like_this.md").read_text()


@pytest.mark.parametrize("heading", re.findall(r"^## (.*)$", LOOKS, re.M))
def test_a_file_that_looks_like_that_is_read_by_the_lines_beside_it(heading: str, tmp_path: Path) -> None:
    """The page's rows, carried on in time, through the page's rig file; its Python, with the arrays that it names."""
    part = LOOKS.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    for rig, table in zip(_blocks("toml", part), _blocks("csv", part), strict=False):
        header, *rows = table.splitlines()
        sign = ";" if ";" in header else ","
        first = rows[-1].partition(sign)
        step = float(first[0].replace(",", ".")) - float(rows[-2].partition(sign)[0].replace(",", "."))
        later = (float(first[0].replace(",", ".")) + k * step for k in range(1, 12))
        point = "," if sign == ";" and "," in table else "."
        rows += [f"{t:g}".replace(".", point) + sign + first[2] for t in later]
        (tmp_path / "run.csv").write_text("\n".join([header, *rows]))
        read = rwjax.read_log(tmp_path / "run.csv", parse_rig(rig))
        assert len(read.time) == len(rows) and all(np.isfinite(y).all() for y in read.outputs.values())
        assert read.time[-1] - read.time[0] == pytest.approx((len(rows) - 1) * (read.time[1] - read.time[0]))
    if "frame" in heading:
        (tmp_path / "rig.toml").write_text(_blocks("toml", LOOKS)[1])
        t = np.arange(40) / 100.0
        names = {"t": t, "volts": t, "u": t, "degrees": 90.0 * t, "angle": t, "rpm": t}
        for code in _blocks("python", part):
            exec(code.replace('"rig.toml"', repr(str(tmp_path / "rig.toml"))), names)
        assert names["log"].outputs["yaw_rad"][-1] == t[-1]


SERVO = (ROOT / "docs" / "my_rig_is_a_servo.md").read_text()


def test_the_page_of_servos_has_a_rig_file_that_can_be_read() -> None:
    rig = parse_rig(_blocks("toml", SERVO)[0])
    assert rig.kind == "joint" and rig.servo is not None and rig.servo.acts_on == "voltage"
    assert all(f'"{choice}"' in SERVO for choice in SERVO_CHOICES["acts_on"])


@pytest.mark.slow
def test_the_first_fit_of_the_page_of_servos_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = _blocks("toml", SERVO)[0]
    truth = parse_rig(text)
    Path("rig.toml").write_text(text)
    exec(_blocks("python", SERVO)[0], {})
    off = truth.with_values({"axis.inertia": 0.014, "axis.friction.coulomb": 0.06})
    Path("rig.toml").write_text(rwjax.write_rig(off))
    for line in re.findall(r"^\$ rwjax +(.*)$", _blocks("console", SERVO)[0], re.M):
        assert command(monkeypatch, *line.split()) == 0
    fitted = rwjax.read_rig("fitted.toml")
    for name in truth.free:
        assert fitted.values[name] == pytest.approx(truth.values[name], rel=0.05), name
    assert list(Path("next_runs").glob("coast*.csv"))


def _blocks(language: str, page: str) -> list[str]:
    """The parts of a page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page, re.M | re.S)


def test_the_readme_names_only_commands_that_exist() -> None:
    text = (ROOT / "README.md").read_text()
    commands = {command.callback.__name__ for command in app.registered_commands if command.callback}
    named = {*re.findall(r"^\$ rwjax +(\w+)", text, re.M)}
    assert named and named <= commands


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_modules_and_files_that_a_page_names_exist(page: Path) -> None:
    text = page.read_text()
    for module in re.findall(r"python -m ([\w.]+)", text):
        path = ROOT / module.replace(".", "/")
        assert path.with_suffix(".py").exists() or (path / "__main__.py").exists(), module
    for path in re.findall(r"`((?:rwjax|tests|experiments|firmware|data|docs)/[\w./]+)`", text):
        assert (ROOT / path).exists(), path
    for target in re.findall(r"\]\(([^)#\s]+)", text):
        assert target.startswith("http") or (page.parent / target).is_file(), target  # a folder has no page to lead to


def test_the_way_of_one_log_names_every_file_once() -> None:
    files = re.findall(r"`([a-z_]+/[\w/]+\.py)`", (ROOT / "docs" / "layout.md").read_text().partition("## The way")[2])
    files = [name for name in files if not name.startswith("rwjax/")]
    assert len(files) > 40
    assert len({*files}) == len(files)
    for name in files:
        assert (ROOT / "rwjax" / name).exists(), name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_into_a_page_lead_to_a_heading(page: Path) -> None:
    for target, anchor in re.findall(r"\]\(([^)#\s]*)#([\w-]+)\)", page.read_text()):
        there = (page.parent / target if target else page).read_text()
        headings = [re.sub(r"[^\w -]", "", h).lower().replace(" ", "-") for h in re.findall(r"^#+ (.+)$", there, re.M)]
        assert anchor in headings, (target, anchor)


def test_the_readme_is_short_and_no_table_is_too_wide_to_read() -> None:
    assert len((ROOT / "README.md").read_text().splitlines()) <= MOST_LINES
    for page in PAGES:
        for row in re.findall(r"^\|.*\|$", page.read_text(), re.M):
            for cell in row.split("|"):
                assert len(cell.strip()) <= WIDEST_CELL, (page.name, cell)


def test_the_readmes_python_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    (example,) = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.M | re.S)
    names: dict = {}
    exec(example, names)
    assert len(names["angle"]) == len(names["logs"][0].time)
    assert names["found"].rig.values["axis.inertia"] > 0.0
    assert "axis.inertia" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "notebooks").glob("*.md")), ids=lambda page: page.stem)
def test_the_cells_of_a_notebook_run(page: Path) -> None:
    """`make docs` executes the notebooks, `make pages` and so CI does not."""
    cells = re.findall(r"^```\{code-cell\} ipython3\n(.*?)^```", page.read_text(), re.M | re.S)
    assert len(cells) > 2
    lines = "\n".join(cells).splitlines()
    code = "\n".join(line for line in lines if not line.startswith("%"))  # what only a notebook understands
    environment = os.environ | {"MPLBACKEND": "Agg"}
    subprocess.run(
        [sys.executable, "-W", "error::DeprecationWarning:__main__", "-c", code],
        cwd=page.parent,
        env=environment,
        check=True,
    )


@pytest.mark.slow
@pytest.mark.parametrize(("page", "least"), [("README.md", 12), ("docs/quickstart.md", 5)])
def test_the_commands_of_a_page_run_as_printed(page: str, least: int, tmp_path: Path) -> None:
    (tmp_path / "data").symlink_to(ROOT / "data")
    text = (ROOT / page).read_text()
    set_up = re.findall(r"`(mkdir logs && [^`]+)`", text)
    commands = re.findall(r"^\$ (rwjax .*)$", text, re.M)
    assert len(commands) >= least
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    script = "\n".join(("set -e", *set_up, *commands))
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=tmp_path,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        timeout=280,
    )
    assert done.returncode == 0, done.stderr
    for name in re.findall(r"-o ([\w.]+)", "\n".join(commands)):
        written = tmp_path / name
        assert any(written.iterdir()) if written.is_dir() else written.stat().st_size > 0, name


@pytest.mark.slow
def test_the_sweeps_on_the_page_of_control_run_and_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    (example,) = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs" / "control.md").read_text(), re.M | re.S)
    names: dict = {}
    exec(example, names)
    slowest, kp, kd = np.asarray(names["slowest"]), names["kp"], names["kd"]
    assert np.array_equal(slowest < -0.5, rwjax.region(names["rig"], kp, kd, 0.5).stable)
    assert names["with_integral"][:, 0] == pytest.approx(
        np.maximum(slowest, 0.0), abs=1e-9
    )  # ki = 0: the integral stays
    assert np.array_equal(names["of_all"], np.max(names["of_each"], axis=-1)) and names["of_each"].shape == (21, 21, 3)
    assert np.min(names["damping"]) > 0.0
    assert names["by_gain"] == pytest.approx(np.array([0.0, -0.5 * 0.428 / 0.228]))  # it rings: half of what damps it


def test_what_the_package_says_to_call_is_there() -> None:
    for path in re.findall(r"`(rwjax\.[\w.]+\.\w+)`", rwjax.__doc__ or ""):
        module, _, name = path.rpartition(".")
        assert callable(getattr(import_module(module), name)), path
