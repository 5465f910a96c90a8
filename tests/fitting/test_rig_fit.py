"""What a fit prints and writes."""

import json
from dataclasses import replace
from functools import cache

import numpy as np

from rwjax.fitting.fit import fit
from rwjax.fitting.rig_fit import RigFit
from tests.fitting.logs import FREE, TIME, log_of
from tests.systems import platform


@cache
def fitted() -> RigFit:
    truth = platform(free=FREE)
    return fit(truth, [log_of(truth, noise=1e-3)])


def test_a_fit_prints_numbers_with_standard_errors_and_units_rms_errors_and_notes() -> None:
    found = fitted()
    text = str(found)
    for name in found.rig.free:
        (line,) = (line for line in text.splitlines() if line.split()[:1] == [name])
        assert f"{found.rig.values[name]:.6g}" in line
        assert f"± {found.uncertainty.standard_error[name]:.2g}" in line
    assert "kg m2" in text and "N m s/rad" in text
    assert f"RMS error of yaw_rad: {found.rms['yaw_rad']:.4g} rad" in text
    assert text.count("note: ") == len(found.notes)


def test_a_fit_writes_itself_as_json() -> None:
    found = fitted()
    written = json.loads(json.dumps(found.json(), allow_nan=False))
    assert written["schema"] == "rwjax.fit/1" and written["converged"] is True
    assert {*written["numbers"]} == {*found.rig.free} == {*written["interval95"]}
    errors = [written["numbers"][name]["standard_error"] for name in written["covariance_of"]]
    assert np.allclose(np.sqrt(np.diag(written["covariance"])), errors)
    assert found.of_runs() == []


def test_a_fit_gives_its_numbers_as_a_table() -> None:
    found = fitted()
    sheet = found.to_frame()
    assert sheet["number"].to_list() == [*found.rig.free]
    first = sheet.row(0, named=True)
    assert first["value"] == found.rig.values[found.rig.free[0]]
    assert first["from_95"] < first["value"] < first["to_95"] and first["standard_error"] > 0.0
    assert sheet.filter(sheet["number"] == "axis.inertia")["unit"].item() == "kg m2"


def test_logs_that_tell_only_a_combination_tell_something() -> None:
    rig = platform("viscous = 0.0", free='"axis.inertia", "drive.gain"')
    found = fit(rig, [log_of(rig, noise=1e-3)])
    assert found.tells_something and not any(np.all(np.isfinite(ends)) for ends in found.interval.values())


def test_a_number_on_its_bound_is_told_where_its_profile_has_two_ends() -> None:
    springs = {"axis.presliding": {"s": 0.0}}
    rig = replace(platform("viscous = 0.02\ncoulomb = 0.05"), effects=springs, free=("axis.presliding.s",))
    found = fit(rig, [log_of(rig, noise=1e-3)])
    assert not found.uncertainty.tells_something and found.tells_something
    still = platform("viscous = 0.0", free='"axis.friction.viscous"')
    assert not fit(still, [log_of(still, 0.0 * TIME, noise=1e-3)]).tells_something


def test_a_number_that_nothing_but_its_limits_holds_is_not_told_and_shown_as_open() -> None:
    name = "axis.friction.viscous"
    still = replace(platform("viscous = 0.15", free=f'"{name}"'), bounds={name: (0.1, 0.2)})
    found = fit(still, [log_of(still, 0.0 * TIME, noise=1e-3)])
    assert found.allowed == {name: (0.1, 0.2)} and not found.tells_something
    assert found.interval_words(name) == "95 %: any value of those allowed, 0.1 to 0.2"
    assert found.interval_words(name) in str(found) and found.interval_words("axis.inertia") == ""
