"""The motion that the page's script draws."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.report.motions import motions
from tests.report.diagnosed import AFTER, BEFORE, diagnosed, held_out


def test_every_curve_is_the_measurement_less_its_error() -> None:
    found = diagnosed()
    (first, second) = motions(found)
    measured, before, after = (curve["values"] for curve in first["curves"])
    assert [curve["label"] for curve in first["curves"]] == ["measured", "rig as it is", "with the effects"]
    assert np.allclose(measured, found.logs[0].outputs["yaw_rad"], atol=0.02)
    assert np.allclose(np.subtract(measured, before), BEFORE) and np.allclose(np.subtract(measured, after), AFTER)
    assert np.allclose(first["time"], found.logs[0].time) and len(first["time"]) == len(measured)
    assert {first["name"], second["name"]} == {log.name for log in found.logs}


def test_the_worst_run_comes_first_and_a_gap_in_the_readings_stays_one() -> None:
    errors = held_out(BEFORE).error
    errors[1]["yaw_rad"] = 2.0 * errors[1]["yaw_rad"]
    errors[1]["yaw_rad"][3] = np.nan
    found = diagnosed(before=replace(held_out(BEFORE), error=errors))
    first = motions(found)[0]
    assert first["name"] == found.logs[1].name and first["curves"][1]["values"][3] is None


def test_without_a_named_effect_there_is_no_curve_of_one() -> None:
    (first, _) = motions(diagnosed(effects=()))
    assert [curve["label"] for curve in first["curves"]] == ["measured", "rig as it is"]


def test_a_long_run_is_thinned_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rwjax.report.motions.MOST_SAMPLES", 20)
    for run in motions(diagnosed()):
        assert run["every"] == 3 and len(run["time"]) == 17 and all(len(one["values"]) == 17 for one in run["curves"])


def test_what_a_reader_zooms_in_for_is_not_rounded_away() -> None:
    """A fast log, far from its first time and from angle 0."""
    plain = diagnosed()
    time, angle = 200.0 + 1e-3 * np.arange(50), 2000.0 + 1e-3 * np.arange(50)
    logs = [replace(log, time=time, outputs={"yaw_rad": angle}) for log in plain.logs]
    gaps = {"yaw_rad": replace(plain.gaps["yaw_rad"], floor=1e-3)}
    (first, _) = motions(diagnosed(logs=tuple(logs), gaps=gaps))
    assert np.allclose(first["time"], time, rtol=0.0, atol=1e-5)
    assert np.allclose(first["curves"][0]["values"], angle, rtol=0.0, atol=1e-4)


def test_segments_of_a_run_are_told_apart_by_their_times() -> None:
    first, second = diagnosed().logs
    logs = (replace(first, name="a.csv"), replace(second, name="a.csv", time=second.time + 5.0))
    assert {run["name"] for run in motions(diagnosed(logs=logs))} == {"a.csv from 0 s", "a.csv from 5 s"}
