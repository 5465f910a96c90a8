"""Every method on logs that it can handle: known numbers come back; and the comparison of them all."""

import json
from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import LogError, RigError
from rwjax.methods.comparison import METHODS, compare
from rwjax.methods.kalman import prediction_error
from rwjax.methods.output_error import finite_differences
from rwjax.methods.regression import equation_error, weak_form
from rwjax.report.comparison import table, write_figure
from tests.systems import platform, record, run, wheel

TIME = np.arange(1001) * 0.01
FREE = '"axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'
COMMAND = np.where(TIME > 0.6, 0.9 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME), 0.0)


def axis_log(rig, seed: int = 0, **more):
    y = run(rig, record(TIME, COMMAND), {})["yaw_rad"]
    return record(TIME, COMMAND, {"yaw_rad": y + np.random.default_rng(seed).normal(0.0, 3e-4, len(y))}, **more)


@pytest.mark.parametrize(
    ("method", "within"),
    # what each is known for: the weak form loses what lies near standstill, filtered accelerations are biased
    [(finite_differences, 0.005), (prediction_error, 0.01), (weak_form, 0.05), (equation_error, 0.25)],
)
def test_known_numbers_of_an_axis_come_back(method, within: float) -> None:
    truth = platform(free=FREE)
    believed = truth.with_values({name: 1.15 * truth.values[name] for name in truth.free})
    found = method(believed, [axis_log(truth)]).rig
    for name in truth.free:
        assert found.values[name] == pytest.approx(truth.values[name], rel=within), name
        assert found.standard_error[name] > 0.0


@pytest.mark.parametrize(
    ("method", "within"), [(finite_differences, 0.01), (prediction_error, 0.01), (weak_form, 0.05)]
)
def test_known_numbers_of_a_wheel_come_back(method, within: float) -> None:
    truth = wheel()
    believed = truth.with_values({"wheel.inertia": 1.5e-4})
    u = 6.0 * COMMAND
    y = run(truth, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    log = record(TIME, u, {"wheel_rad_s": y + np.random.default_rng(1).normal(0.0, 0.3, len(y))})
    found = method(believed, [log]).rig
    assert found.values["wheel.inertia"] == pytest.approx(1.24e-4, rel=within)


@pytest.mark.parametrize(("method", "within"), [(finite_differences, 0.05), (prediction_error, 0.05), (weak_form, 0.1)])
def test_an_effect_on_the_command_is_estimated_by_every_method(method, within: float) -> None:
    base = wheel(inductance=0.0)
    truth = replace(base, effects={"drive.deadzone": {"u_0": 0.8}}, free=(*base.free, "drive.deadzone.u_0"))
    u = 6.0 * COMMAND
    y = run(truth, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    log = record(TIME, u, {"wheel_rad_s": y + np.random.default_rng(1).normal(0.0, 0.3, len(y))})
    found = method(truth.with_values({"drive.deadzone.u_0": 0.6}), [log]).rig
    assert found.values["drive.deadzone.u_0"] == pytest.approx(0.8, rel=within)


def test_regression_refuses_a_command_whose_current_it_cannot_know() -> None:
    truth = replace(wheel(), effects={"drive.deadzone": {"u_0": 0.8}})
    log = record(TIME, 6.0 * COMMAND, {"wheel_rad_s": 300.0 * COMMAND})
    with pytest.raises(LogError, match="no `current_A`, which regression needs to estimate drive.deadzone"):
        weak_form(truth, [log])


@pytest.mark.parametrize("method", [prediction_error, weak_form, equation_error])
def test_a_method_that_knows_no_delay_says_so(method) -> None:
    late = replace(platform(free=FREE), effects={"drive.delay": {"tau": 0.05}})
    with pytest.raises(RigError, match="has drive.delay; .* takes commands to act at once"):
        method(late, [axis_log(late)])


def test_the_comparison_judges_all_methods_on_the_same_held_out_run(tmp_path) -> None:
    truth = platform(free=FREE)
    logs = [axis_log(truth), axis_log(truth, seed=1, validate=True)]
    found = compare(truth.with_values({"axis.inertia": 0.12}), logs)
    assert [row.method.name for row in found.rows] == [method.name for method in METHODS]
    assert found.held_out == "marked"
    rms = {row.method.name: row.rms.get("yaw_rad") for row in found.rows}
    assert rms["two-stage"] is None  # no coast-down in these logs, and the row says so
    assert "needs a coast-down" in " ".join(found.rows[-1].notes)
    assert rms["end-to-end"] == pytest.approx(3e-4, rel=0.1)  # the noise
    assert rms["end-to-end"] < rms["weak form"] < rms["equation error"]
    assert found.floor["yaw_rad"] == pytest.approx(3e-4, rel=0.1)
    assert json.loads(json.dumps(found.json(), allow_nan=False))["schema"] == "rwjax.comparison/1"
    assert "end-to-end" in table(found)
    assert write_figure(found, tmp_path / "c.png").stat().st_size > 10_000
