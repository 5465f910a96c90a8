"""`rwjax diagnose`, as a user calls it."""

import errno
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from rwjax import read_rig
from rwjax.cli import interrupt
from rwjax.diagnosis.worst_windows import Window
from rwjax.planning.experiment import Experiment
from rwjax.planning.files import Plan, Run
from rwjax.report.plots import plot_ranking, plot_runs
from tests.cli.shell import DEMO, LOGS, ROOT, Shell, program
from tests.report.diagnosed import diagnosed


@pytest.mark.slow
def test_diagnose_names_what_the_demo_lacks_and_writes_everything(tmp_path: Path) -> None:
    done = program("diagnose", str(DEMO / "rig.toml"), *LOGS, "-o", "out", "--json", "--budget", "inf", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer == json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert (answer["schema"], answer["verdict"], answer["effects"]) == (
        "rwjax.diagnosis/2",
        "effect",
        ["axis.stribeck"],
    )
    assert (answer["where"]["subsystem"], answer["where"]["coordinate"]) == ("axis", "yaw_rate")
    assert answer["held_out"] == "marked"
    assert answer["gap"]["signal"] == "yaw_rad"
    # its own form of friction: nothing is left but what a right rig leaves on average, to a tenth for a few runs
    assert answer["gap"]["after"] < 1.1 * answer["gap"]["floor"]
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
    assert not re.findall(
        r"""(?:src|href)=["']?http|url\(["']?http|@import""", page
    )  # nothing is loaded from elsewhere
    assert page.index("The rig lacks Stribeck friction") < page.index("<svg")


PLAN = Plan("rig", {}, (Run("square", Experiment("square", 1.0, 0.0, 2.0, 4.0), "train", "", (), {}),))
ALWAYS = {"diagnosis.json", "corrected.toml", "report.html", "diagnosis.npz"}


@pytest.fixture
def quick(shell: Shell) -> Shell:
    """The command with a diagnosis made by hand."""
    shutil.copy(LOGS[0], shell.folder / "run.csv")
    shell.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", lambda rig, logs, **given: diagnosed(proposal=PLAN))
    shell.patch.setattr("rwjax.report.html.figures_of", lambda d: {"ranking": (plot_ranking, (3.0, 1.0))})
    return shell


def begins_no_search(shell: Shell) -> None:
    def search(*given: object, **named: object) -> None:
        raise AssertionError("begun")

    shell.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", search)


def files(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("command", ["fit", "predict"])
def test_what_is_not_claimed_is_said_and_goes_on_being_said(quick: Shell, command: str) -> None:
    tried = replace(read_rig(DEMO / "rig.toml"), effects={"axis.coulomb": {"M_c": 0.1}})
    unclaimed = diagnosed(verdict="unknown", corrected=tried)
    quick.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", lambda rig, logs, **given: unclaimed)
    code, out, _ = quick("diagnose", "rig.toml", "run.csv", "-o", "out")
    assert code == 0 and out.endswith(
        "  out/corrected.toml: with what leads, which is not claimed; go on from rig.toml\n"
    )
    said = "note: not claimed: Unknown:"
    more = ["-o", "fitted.toml"] if command == "fit" else []
    code, _, err = quick(command, "out/corrected.toml", "run.csv", *more)
    assert code == 0, err
    assert any(line.startswith(said) for line in err.splitlines())
    if command == "fit":
        assert (quick.folder / "fitted.toml").read_text().startswith("# caution: not claimed: Unknown:")


def test_a_diagnosis_replaces_the_earlier_one_and_nothing_else(quick: Shell) -> None:
    code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out")
    assert (code, err) == (0, "") and out.endswith(
        "  plan of the next experiment: out/next/plan.toml\n  report: out/report.html\n"
        "next: rwjax fit out/corrected.toml run.csv -o out/fitted.toml\n"
    )
    assert files(quick.folder / "out") == ALWAYS | {"ranking.png", "next/plan.toml", "next/square.csv"}
    for name in ("notes.txt", "next/notes.txt"):
        (quick.folder / "out" / name).write_text("mine")
    quick.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", lambda rig, logs, **given: diagnosed(verdict="none"))
    quick.patch.setattr("rwjax.report.html.figures_of", lambda d: {"runs": (plot_runs, (3.0, 1.0))})
    code, out, _ = quick("diagnose", "rig.toml", "run.csv", "-o", "out")
    assert code == 0 and "next: " not in out  # nothing is claimed
    assert files(quick.folder / "out") == ALWAYS | {"runs.png", "notes.txt", "next/notes.txt"}


def test_an_input_that_a_diagnosis_would_replace_is_spared_before_the_search(quick: Shell) -> None:
    assert quick("diagnose", "rig.toml", "run.csv", "-o", "out")[0] == 0
    shutil.copy("rig.toml", quick.folder / "out" / "corrected.toml")
    (quick.folder / "link.toml").symlink_to("out/corrected.toml")
    before = {name: (quick.folder / "out" / name).read_bytes() for name in files(quick.folder / "out")}
    begins_no_search(quick)
    for rig in ("out/corrected.toml", "link.toml"):
        code, out, err = quick("diagnose", rig, "run.csv", "-o", "out")
        said = f"rwjax: {rig}: is an input, and the results would replace it; give another folder with -o\n"
        assert (code, out, err) == (2, "", said)
    assert {name: (quick.folder / "out" / name).read_bytes() for name in files(quick.folder / "out")} == before


def test_a_log_in_the_place_of_a_proposed_run_is_read_and_stays(quick: Shell) -> None:
    assert quick("diagnose", "rig.toml", "run.csv", "-o", "out")[0] == 0
    log = quick.folder / "out" / "next" / "square.csv"
    shutil.copy("run.csv", log)
    assert quick("diagnose", "rig.toml", "out/next/square.csv", "-o", "out")[0] == 0
    assert log.read_bytes() == (quick.folder / "run.csv").read_bytes()
    assert {"next/square.csv", "next/square_2.csv"} <= files(quick.folder / "out")


def test_inputs_beside_the_results_are_read_and_stay(quick: Shell) -> None:
    (quick.folder / "run").mkdir()
    shutil.copy("rig.toml", "run/rig.toml")
    shutil.copy("run.csv", "run/run.csv")
    for _ in range(2):
        assert quick("diagnose", "run/rig.toml", "run/run.csv", "-o", "run")[0] == 0
    assert (quick.folder / "run" / "run.csv").read_bytes() == (quick.folder / "run.csv").read_bytes()
    assert files(quick.folder / "run") > ALWAYS | {"rig.toml", "run.csv", "next/square.csv"}


def test_a_full_disk_leaves_the_earlier_diagnosis(quick: Shell) -> None:
    assert quick("diagnose", "rig.toml", "run.csv", "-o", "out")[0] == 0
    before = {name: (quick.folder / "out" / name).read_bytes() for name in files(quick.folder / "out")}
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, limit[1]))  # room for the texts, not for the figures
    try:
        code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    said = "rwjax: out/diagnosis.npz: cannot be written: File too large; give a path in a writable folder\n"
    assert (code, out, err) == (2, "", said)
    assert {name: (quick.folder / "out" / name).read_bytes() for name in files(quick.folder / "out")} == before
    assert not [name for name in os.listdir(quick.folder) if name.startswith(".")]


def test_a_folder_that_cannot_be_replaced_is_refused_before_the_search(quick: Shell) -> None:
    begins_no_search(quick)
    for output in ("", ".", "rig.toml", "rig.toml/out", "n" * 300, "/proc"):
        code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", output)
        assert (code, out, err.count("\n")) == (2, "", 1) and err.startswith(f"rwjax: {output or '.'}: "), err
    assert files(quick.folder) == {"rig.toml", "fit.json", "run.csv"}


def test_a_logs_name_that_is_no_text_ends_no_command(quick: Shell) -> None:
    name = os.fsdecode(b"run\xff\x1b[31m.csv")
    shutil.copy("run.csv", name)
    logs = tuple(replace(log, name=name) for log in diagnosed().logs)
    found = diagnosed(logs=logs, windows=(Window(name, 0.0, 1.0, 0.5),), remarks=(name,))
    quick.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", lambda rig, logs, **given: found)
    code, out, err = quick("diagnose", "rig.toml", name, "-o", "out")
    assert (code, err) == (0, "") and r"note: run\udcff\x1b[31m.csv" in out and out.count("\x1b") == 0
    answer = json.loads((quick.folder / "out" / "diagnosis.json").read_bytes().decode("utf-8"))
    assert answer["remarks"][0].encode("utf-8") and answer["remarks"][0].startswith(r"run\udcff")


def test_budget_and_candidates_reach_the_diagnosis(quick: Shell) -> None:
    seen: list[dict] = []

    def heard(rig: object, logs: object, **given: object) -> object:
        seen.append(given)
        return diagnosed()

    quick.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", heard)
    names = ("--only", "drive.lag", "axis.coulomb", "--without", "drive.lag")
    for more in ((), ("--budget", "inf", *names), ("--budget", "2.5")):
        assert quick("diagnose", *more, "rig.toml", "run.csv", "-o", "out")[0] == 0
    assert [given["budget"].seconds for given in seen] == [120.0, float("inf"), 2.5]
    assert [tuple(given["only"]) for given in seen] == [(), ("drive.lag", "axis.coulomb"), ()]
    assert [tuple(given["without"]) for given in seen] == [(), ("drive.lag",), ()]
    for wrong in ("0", "-1", "nan"):
        code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out", "--budget", wrong)
        assert (code, out) == (2, "") and err.startswith("rwjax: --budget ") and err.count("\n") == 1


def test_a_name_that_is_none_is_one_line(quick: Shell) -> None:
    quick.patch.undo()
    quick.patch.chdir(quick.folder)
    shutil.copy(DEMO / "rig.toml", "demo.toml")
    code, out, err = quick("diagnose", "demo.toml", "run.csv", "-o", "out", "--without", "axis.colomb", "--quiet")
    assert (code, out) == (2, "") and not (quick.folder / "out").exists()
    assert err == "rwjax: `axis.colomb` is no effect and no fixed number of this rig; nearest `axis.coulomb`\n"


def test_a_page_of_the_users_own_is_refused_before_the_search(quick: Shell) -> None:
    begins_no_search(quick)
    (quick.folder / "out").mkdir()
    (quick.folder / "out" / "report.html").write_text("mine")
    code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out")
    assert (code, out) == (2, "") and files(quick.folder / "out") == {"report.html"}
    assert (
        err.startswith("rwjax: out/report.html: is no page that rwjax wrote, and would be replaced; ")
        and err.count("\n") == 1
    )


@pytest.mark.parametrize("verdict", ["effect", "partial"])
def test_under_partial_the_errors_are_said_to_be_too_tight(quick: Shell, verdict: str) -> None:
    quick.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", lambda rig, logs, **given: diagnosed(verdict=verdict))
    code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out")
    assert code == 0, err
    assert (
        "  note: the ± of its numbers are too tight: under `partial` the model is known to lack something more\n" in out
    ) == (verdict == "partial")


@pytest.mark.parametrize("number", interrupt.SIGNALS)
def test_after_ctrl_c_the_answer_is_whole_and_the_status_says_so(quick: Shell, number: signal.Signals) -> None:
    """The signal comes while the diagnosis works."""

    def stopped(rig: object, logs: object, **given: Any) -> object:
        with given["budget"].searching():
            signal.raise_signal(number)
        return diagnosed(verdict="unknown", complete=False, untried=("drive.lag",))

    quick.patch.setattr("os._exit", left)
    quick.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", stopped)
    before = signal.signal(number, interrupt.heard)
    try:
        code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out", "--json")
        assert signal.getsignal(number) is interrupt.heard
    finally:
        signal.signal(number, before)
    answer = json.loads(out)
    assert code == 128 + number and err == f"rwjax: {interrupt.SAYS[number]}\n"
    assert answer == json.loads((quick.folder / "out" / "diagnosis.json").read_text())
    assert (answer["complete"], answer["untried"]) == (False, ["drive.lag"])
    assert "Unfinished: so far" in (quick.folder / "out" / "report.html").read_text()
    assert (
        (quick.folder / "out" / "corrected.toml").read_text().startswith("# caution: not claimed: Unfinished: so far")
    )


@pytest.mark.parametrize("command", ["fit", "diagnose"])
@pytest.mark.parametrize("number", interrupt.SIGNALS)
def test_who_ends_the_command_while_logs_are_read_is_told_that_there_is_no_answer(
    quick: Shell, number: signal.Signals, command: str
) -> None:
    def reads(paths: object, rig: object) -> object:
        signal.raise_signal(number)
        raise AssertionError("goes on")

    quick.patch.setattr("os._exit", left)
    quick.patch.setattr("rwjax.logs.read.read_logs", reads)
    there, before = {*quick.folder.iterdir()}, signal.signal(number, interrupt.heard)
    try:
        code, out, err = quick(command, "rig.toml", "run.csv", "-o", "out", "--json")
    finally:
        signal.signal(number, before)
    assert (code, out) == (128 + number, "") and {*quick.folder.iterdir()} == there
    assert err == f"rwjax: {interrupt.SAYS[number]}{interrupt.NO_ANSWER}\n"
    with interrupt.unanswered():
        pass  # what is said of this command is not said of the next one


@pytest.mark.parametrize("number", interrupt.SIGNALS)
def test_who_ends_the_command_while_the_page_is_drawn_has_the_answer(quick: Shell, number: signal.Signals) -> None:
    def drawn(d: object) -> dict:
        signal.raise_signal(number)
        raise AssertionError("goes on")

    quick.patch.setattr("os._exit", left)
    quick.patch.setattr("rwjax.report.html.figures_of", drawn)
    before = signal.signal(number, interrupt.heard)
    try:
        code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out")
    finally:
        signal.signal(number, before)
    assert (code, out) == (128 + number, "") and files(quick.folder / "out") == ALWAYS - {"report.html"}
    assert err.splitlines()[0] == "note: out holds the answer, and no page of it yet; next: rwjax report out"
    assert err.splitlines()[-1] == f"rwjax: {interrupt.SAYS[number]}"  # and nothing of an answer that is still to come
    assert json.loads((quick.folder / "out" / "diagnosis.json").read_text())["verdict"] == "effect"


def test_where_the_page_finds_a_full_disk_the_answer_is_there_and_said(quick: Shell) -> None:
    def drawn(d: object) -> dict:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    quick.patch.setattr("rwjax.report.html.figures_of", drawn)
    code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out")
    assert (code, out) == (2, "") and files(quick.folder / "out") == ALWAYS - {"report.html"}
    said = "note: out holds the answer, and no page of it yet; next: rwjax report out"
    assert err.splitlines()[0] == said and "No space left on device" in err.splitlines()[1]


@pytest.mark.parametrize(
    ("given", "more"),
    [
        ((), "--budget 480"),
        (("--budget", "2.5", "--segments", "3"), "--budget 10 --segments 3"),
        (
            ("--budget", "5", "--only", "drive.lag", "axis.coulomb", "--without", "drive.lag"),
            "--budget 20 --only drive.lag --only axis.coulomb --without drive.lag",
        ),
    ],
)
def test_after_a_search_that_was_ended_the_next_command_gives_it_more_time(
    quick: Shell, given: tuple[str, ...], more: str
) -> None:
    ended = diagnosed(verdict="unknown", complete=False, untried=("drive.lag",))
    quick.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", lambda rig, logs, **named: ended)
    code, out, err = quick("diagnose", "rig.toml", "run.csv", "-o", "out", *given)
    assert code == 0, err
    assert out.splitlines()[-1] == f"next: rwjax diagnose rig.toml run.csv -o out {more}"


@pytest.mark.parametrize("given", [("--budget", "inf"), ()], ids=["no budget", "Ctrl-C"])
def test_more_time_is_advised_only_where_the_budget_has_ended_the_search(quick: Shell, given: tuple[str, ...]) -> None:
    def ended(rig: object, logs: object, **named: Any) -> object:
        if not given:
            named["budget"].stop()
        return diagnosed(verdict="unknown", complete=False, untried=("drive.lag",))

    quick.patch.setattr("os._exit", left)
    quick.patch.setattr("rwjax.diagnosis.diagnosis.diagnose", ended)
    code, out, _ = quick("diagnose", "rig.toml", "run.csv", "-o", "out", *given)
    assert code == (0 if given else 130) and "Unfinished" in out and "next: " not in out


def left(status: int) -> None:
    raise SystemExit(status)


@pytest.mark.slow
@pytest.mark.usefixtures("hears_ctrl_c")
def test_ctrl_c_in_a_search_gives_the_answer_so_far(tmp_path: Path) -> None:
    begun = subprocess.Popen(
        [sys.executable, "-m", "rwjax", "diagnose", str(DEMO / "rig.toml"), *LOGS, "-o", "out", "--budget", "inf"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert begun.stderr is not None
    while "candidates" not in (line := begun.stderr.readline()):
        assert line, "ended before it searched"
    begun.send_signal(signal.SIGINT)
    asked = time.monotonic()
    out, err = begun.communicate(timeout=300)
    assert begun.returncode == 130 and out.startswith("Unfinished: ") and interrupt.ASKED in err
    assert err.endswith("rwjax: interrupted\n") and time.monotonic() - asked < 120.0  # cold programs end first
    answer = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert answer["complete"] is False and answer["verdict"] == "unknown"
    assert {path.name for path in (tmp_path / "out").iterdir()} > ALWAYS
    read_rig(tmp_path / "out" / "corrected.toml")
