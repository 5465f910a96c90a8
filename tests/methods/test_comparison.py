"""All methods on the same logs."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from rwjax.methods.comparison import METHODS, Comparison, Row, compare
from rwjax.report.comparison import write_figure
from tests.joints import COUNT, joint, logged, servo
from tests.methods.logs import FREE, axis_log
from tests.systems import platform


@pytest.mark.slow
def test_the_comparison_judges_all_methods_on_the_same_held_out_run(tmp_path) -> None:
    truth = platform(free=FREE)
    logs = [axis_log(truth), axis_log(truth, seed=1, validate=True)]
    told: list[str] = []
    found = compare(truth.with_values({"axis.inertia": 0.12}), logs, told.append)
    assert told[0] == f"method 1 of 7, {METHODS[0].name}"
    assert told[-1] == f"method 7 of 7, {METHODS[-1].name}"  # which cannot be used on these logs
    assert len(told) == 7  # of one held-out part nothing more is to be said
    assert [row.method.name for row in found.rows] == [method.name for method in METHODS]
    assert len(METHODS) == 7
    assert found.held_out == "marked"
    rms = {row.method.name: row.rms.get("yaw_rad") for row in found.rows}
    assert rms["two-stage"] is None  # no coast-down in these logs, and the row says so
    assert "needs a coast-down" in " ".join(found.rows[-1].notes)
    assert rms["end-to-end"] == pytest.approx(3e-4, rel=0.1)  # the noise
    assert rms["smooth"] == pytest.approx(rms["end-to-end"], rel=0.1)  # by its own friction
    assert rms["end-to-end"] < rms["weak form"] < rms["equation error"]
    assert found.floor["yaw_rad"] == pytest.approx(3e-4, rel=0.1)
    assert json.loads(json.dumps(found.json(), allow_nan=False))["schema"] == "rwjax.comparison/1"
    assert all(f" {method.name} " in str(found) for method in METHODS)
    assert write_figure(found, tmp_path / "c.png").stat().st_size > 10_000


def test_the_table_has_a_row_for_each_method_and_one_for_the_floor() -> None:
    rig = platform()
    rows = (
        Row(METHODS[0], replace(rig, standard_error={"axis.inertia": 0.00123}), {"yaw_rad": 0.0125}, 1.26, ("a note",)),
        Row(METHODS[1], rig, {"yaw_rad": math.inf}, 0.04, ()),
        Row(METHODS[2], None, {}, 0.0, ("cannot be used",)),
    )
    head, *lines = str(Comparison(rig, rows, {"yaw_rad": 0.01}, "marked")).splitlines()
    assert (
        head
        == "free-run RMS on held-out data (marked); numbers from all logs that may be fitted, ± one standard error as each method has it"
    )
    names, *rows = [" ".join(line.split()) for line in lines if line.strip(" ─")]
    assert names == "method yaw_rad [rad] axis.inertia time [s] needs"
    assert rows[:4] == [
        "end-to-end 0.0125 0.1 ± 0.0012 1.3 any logs",
        "smooth – 0.1 0.0 friction whose sign may be smooth; time",
        "finite differences – – 0.0 a start near the optimum",
        "(floor) 0.01",
    ]
    assert rows[4:] == ["end-to-end: a note", "finite differences: cannot be used"]


@pytest.mark.slow
def test_methods_that_simulate_no_loop_take_what_the_servo_gave() -> None:
    """All of them find the link's inertia, and the free run that judges them follows the goal."""
    rig = servo(joint(axis__friction__coulomb=0.05, axis__gravity__torque=0.3), kp=4.0, period=0.01)
    rig = replace(rig, free=("axis.inertia", "drive.servo.kp"))
    t = np.arange(601) * 0.01
    on = (t < 4.5).astype(float)
    logs = [
        replace(
            logged(rig, t, goal_rad=np.where(t > 0.6, 0.6 * np.sin(w * t) + 0.3 * np.sin(7.0 * t), 0.0), enabled=on),
            validate=w == 3.0,
        )
        for w in (2.0, 3.0)
    ]
    found = {row.method.name: row for row in compare(rig.with_values({"axis.inertia": 0.012}), logs).rows}
    for name in ("end-to-end", "finite differences", "prediction error", "weak form"):
        assert found[name].rig.values["axis.inertia"] == pytest.approx(0.01, rel=0.05), name
        assert found[name].rms["yaw_rad"] < COUNT, name
    assert "drive.servo.kp" in found["end-to-end"].rig.standard_error
    assert "drive.servo.kp is not estimated by the prediction-error method" in found["prediction error"].notes
    assert found["smooth"].rig is None and "the loop of [drive.servo]" in found["smooth"].notes[0]
