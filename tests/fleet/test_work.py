"""What a worker does: rows of every command, and a row also of what goes wrong."""

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rwjax.fleet.plan import Job, read_plan
from rwjax.fleet.work import END_TO_END, NO_METHOD, NOTHING, best_method, carried_out, report_folder
from rwjax.methods.comparison import METHODS
from rwjax.rig.model import Rig
from rwjax.rig.write import write_rig
from tests.fleet.small import write_small
from tests.systems import platform


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> Job:
    """The rig `b` of a small fleet, whose inertia is 0.11 kg m2."""
    return read_plan(write_small(tmp_path_factory.mktemp("fleet"))).jobs[1]


def test_a_fit_gives_numbers_with_their_covariance(job: Job) -> None:
    row = carried_out(job, "fit", {}, "")
    assert (row["rig"], row["when"], row["status"], row["line"]) == ("b", "", "done", None)
    inertia = row["numbers"][0]
    assert inertia["name"] == "axis.inertia" and abs(inertia["value"] - 0.11) < 4.0 * inertia["standard_error"] < 1e-3
    assert row["covariance"][0] == pytest.approx(inertia["standard_error"] ** 2) and len(row["covariance"]) == 4
    assert 0.8 < row["misfit"] < 1.2 and row["seconds"] > 0.0
    assert json.loads(row["answer"])["schema"] == "rwjax.fit/1"


def test_a_check_says_whether_the_logs_are_usable(job: Job) -> None:
    assert carried_out(job, "check", {}, "")["verdict"] == "usable"


@pytest.mark.slow
def test_a_diagnosis_gives_verdict_gap_and_report(job: Job, tmp_path: Path) -> None:
    row = carried_out(job, "diagnose", {"only": ["axis.coulomb"]}, str(tmp_path))
    assert (row["verdict"], row["effects"], row["signal"]) == ("none", [], "yaw_rad")
    assert 0.0 < row["before"] < 2.0 * row["floor"]
    assert (tmp_path / report_folder(job) / "report.html").exists()


@pytest.mark.slow
def test_a_comparison_holds_every_method_and_names_the_best(job: Job) -> None:
    row = carried_out(job, "compare", {}, "")
    methods = {one["method"]: one["rms"] for one in json.loads(row["answer"])["methods"]}
    assert len(methods) > 3 and row["signal"] == "yaw_rad"
    assert row["after"] == pytest.approx(methods[row["verdict"]]["yaw_rad"])
    assert row["floor"] == pytest.approx(1e-3, rel=0.2) and row["after"] < 1.2 * row["floor"]


def compared(**rms: dict[str, float | None]) -> dict[str, Any]:
    """A comparison with RMS errors by method and output, and floors of 0.1 rad and 1 rad/s."""
    methods = [{"method": name, "rms": errors, "notes": ["needs more"]} for name, errors in rms.items()]
    return {"floor": {"yaw_rad": 0.1, "wheel_rad_s": 1.0}, "methods": methods}


def test_the_best_method_is_that_with_the_least_errors_over_their_floors() -> None:
    found = compared(
        unstable={"yaw_rad": None, "wheel_rad_s": 1.0},
        unusable={},
        worse={"yaw_rad": 0.4, "wheel_rad_s": 1.0},
        best={"yaw_rad": 0.1, "wheel_rad_s": 2.0},
    )
    assert best_method(found) == {"verdict": "best", "signal": "wheel_rad_s", "after": 2.0, "floor": 1.0}


def test_of_methods_that_are_as_good_the_first_is_taken() -> None:
    found = compared(one={"yaw_rad": 0.1005}, other={"yaw_rad": 0.1}, third={"yaw_rad": 0.102})
    assert best_method(found)["verdict"] == "one"


def test_an_output_without_noise_has_a_best_method_too() -> None:
    rms = {"one": {"yaw_rad": 1e-4, "wheel_rad_s": 9.0}, "other": {"yaw_rad": 2e-4, "wheel_rad_s": 1.0}}
    found = compared(**rms) | {"floor": {"yaw_rad": 0.0, "wheel_rad_s": 1.0}}
    assert best_method(found) == {"verdict": "other", "signal": "yaw_rad", "after": 2e-4, "floor": 0.0}


@pytest.fixture(scope="module")
def still(job: Job, tmp_path_factory: pytest.TempPathFactory) -> Job:
    """The same rig with the log of a rest."""
    path = tmp_path_factory.mktemp("rest") / "rest.csv"
    path.write_text("\n".join(["time_s,voltage_V,yaw_rad", *(f"{0.01 * k:.2f},0,0" for k in range(200))]))
    return job._replace(logs=(str(path),))


@pytest.fixture(scope="module")
def tied(job: Job, tmp_path_factory: pytest.TempPathFactory) -> Job:
    """The same logs, which tell all free numbers but for a factor."""
    path = tmp_path_factory.mktemp("tied") / "rig.toml"
    path.write_text(write_rig(platform("viscous = 0.03", '"axis.inertia", "axis.friction.viscous", "drive.gain"')))
    return job._replace(rig_file=str(path))


def compared_by_fit(rig: Rig) -> SimpleNamespace:
    """A comparison in which another method than the end-to-end one comes first and is the best."""
    errors: dict[str, dict[str, float | None]] = {
        "first": {"yaw_rad": 0.1, "wheel_rad_s": 1.0},
        END_TO_END: {"yaw_rad": 0.2, "wheel_rad_s": 1.0},
    }
    found = compared(**errors)
    first, fitted = found["methods"]
    first["numbers"] = None
    fitted["numbers"] = {name: {"value": rig.values[name], "standard_error": None} for name in rig.free}
    return SimpleNamespace(json=lambda: found)


def test_a_comparison_of_logs_that_tell_nothing_names_no_method_but_with_force(
    still: Job, job: Job, tied: Job, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rwjax.methods.comparison.compare", lambda rig, logs: compared_by_fit(rig))
    assert carried_out(still, "compare", {}, "")["verdict"] == NOTHING
    for told, options in ((still, {"force": True}), (job, {}), (tied, {})):
        assert carried_out(told, "compare", options, "")["verdict"] == "first"


def test_a_comparison_without_the_end_to_end_method_names_the_best(still: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    errors: dict[str, dict[str, float | None]] = {"first": {"yaw_rad": 0.1, "wheel_rad_s": 1.0}, END_TO_END: {}}
    found = compared(**errors)
    for one in found["methods"]:
        one["numbers"] = None
    monkeypatch.setattr("rwjax.methods.comparison.compare", lambda rig, logs: SimpleNamespace(json=lambda: found))
    assert carried_out(still, "compare", {}, "")["verdict"] == "first"


def test_the_end_to_end_method_is_one_of_a_comparison() -> None:
    assert END_TO_END in {method.name for method in METHODS}


def test_a_fit_of_logs_that_tell_nothing_counts_as_none_but_with_force(still: Job) -> None:
    row = carried_out(still, "fit", {}, "")
    assert (row["status"], row["verdict"]) == ("done", NOTHING) and "numbers" not in row and "misfit" not in row
    row = carried_out(still, "fit", {"force": True}, "")
    assert row["status"] == "done" and "verdict" not in row and "numbers" in row and "misfit" in row


def test_a_fit_of_logs_that_tell_only_a_combination_keeps_its_misfit(tied: Job) -> None:
    row = carried_out(tied, "fit", {}, "")
    assert row["status"] == "done" and "verdict" not in row and row["numbers"] == [] and 0.8 < row["misfit"] < 1.2
    assert "fix one" in row["answer"]


def test_a_comparison_without_a_stable_model_names_no_method() -> None:
    assert best_method(compared(one={"yaw_rad": None}, other={})) == {"verdict": NO_METHOD}


def test_a_comparison_where_no_method_can_be_used_fails(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    found = SimpleNamespace(json=lambda: compared(one={}, other={}))
    monkeypatch.setattr("rwjax.methods.comparison.compare", lambda rig, logs: found)
    row = carried_out(job, "compare", {}, "")
    assert (row["status"], row["line"]) == ("failed", "no method can be used on these logs; needs more")


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"rig_file": "no.toml"}, "no.toml: cannot be read"),
        ({"logs": ("no.csv",)}, "no.csv: cannot be read"),
    ],
)
def test_what_goes_wrong_is_a_row(changed: dict, said: str, job: Job) -> None:
    row = carried_out(job._replace(**changed), "fit", {}, "")
    assert row["status"] == "failed" and said in row["line"] and "\n" not in row["line"]


def test_an_error_of_this_program_is_a_row_too(job: Job) -> None:
    row = carried_out(job, "fit", {"segments": "no number"}, "")
    assert row["status"] == "failed" and re.match(r"\w+Error: ", row["line"])


def test_a_log_that_changes_while_it_is_fitted_is_fitted_again(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    before = job.inputs()
    monkeypatch.setattr("rwjax.fleet.work.COMMANDS", {"fit": lambda *given: Path(job.logs[0]).touch() or {}})
    assert carried_out(job, "fit", {}, "")["inputs"] == before != job.inputs()


@pytest.mark.parametrize(("rig", "when", "folder"), [("a", "", "a"), ("ü.1", "2026-01", "ü.1/2026-01")])
def test_a_plain_name_is_the_folder_of_its_report(rig: str, when: str, folder: str) -> None:
    assert report_folder(Job(rig, when, "", ())) == folder


def test_reports_stay_below_their_folder_and_apart() -> None:
    names = ("a/b", "a_b", "..", ".", "a.", "a", "b & c", "b___c", "/", "a\\b")
    folders = {report_folder(Job(name, "", "", ())) for name in names}
    assert len(folders) == len(names)
    assert not any("/" in folder or folder.startswith(".") for folder in folders)
