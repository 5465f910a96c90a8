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
    assert np.allclose(measured, found.logs[0].outputs["yaw_rad"], rtol=1e-4)
    assert np.allclose(np.subtract(measured, before), BEFORE) and np.allclose(np.subtract(measured, after), AFTER)
    assert first["time"][0] == 0.0 and len(first["time"]) == len(measured)
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


def test_long_runs_are_thinned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rwjax.report.motions.MOST_SAMPLES", 30)
    for run in motions(diagnosed()):
        assert len(run["time"]) == 13 and all(len(curve["values"]) == 13 for curve in run["curves"])
