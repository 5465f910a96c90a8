"""Motion smoothed from readings."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.methods.measured_motion import MeasuredMotion
from rwjax.methods.regression import weak_form
from rwjax.plant.from_rig import structure_of
from tests.methods.logs import COMMAND, TIME
from tests.systems import platform, reaction, record, run, wheel


def test_regression_refuses_a_command_whose_current_it_cannot_know() -> None:
    truth = replace(wheel(), effects={"drive.deadzone": {"u_0": 0.8}})
    log = record(TIME, 6.0 * COMMAND, {"wheel_rad_s": 300.0 * COMMAND})
    with pytest.raises(LogError, match="no `current_A`, which regression needs to estimate drive.deadzone"):
        weak_form(truth, [log])


def test_smoothed_motion_is_that_of_a_smooth_run() -> None:
    rig = platform()
    angle = 2.0 * np.sin(1.5 * TIME)
    m = MeasuredMotion(rig, structure_of(rig), record(TIME, 0.0 * TIME, {"yaw_rad": angle}))
    inner = slice(20, -20)  # the filter's ends are less exact
    assert m.h == pytest.approx(0.01)
    assert m.states["w"][inner] == pytest.approx(3.0 * np.cos(1.5 * TIME)[inner], abs=0.01)
    assert m.acceleration["w"][inner] == pytest.approx(-4.5 * np.sin(1.5 * TIME)[inner], abs=0.05)
    assert m.source["w"][0] == "angle"


def test_slow_samples_and_their_neighbours_are_left_out() -> None:
    rig = platform()
    rate = np.where(TIME < 5.0, 2.0, 0.0) + np.random.default_rng(0).normal(0.0, 0.01, len(TIME))
    m = MeasuredMotion(rig, structure_of(rig), record(TIME, 0.0 * TIME, {"yaw_rad_s": rate}))
    assert m.known[100:400].all() and not m.known[TIME > 5.2].any()


def test_a_wheel_that_is_not_read_turns_as_the_rig_would_turn_it() -> None:
    rig = reaction()
    truth = run(rig, record(TIME, 4.0 * COMMAND, dict.fromkeys(("yaw_rad", "wheel_rad_s"), 0.0 * TIME)), {})
    m = MeasuredMotion(rig, structure_of(rig), record(TIME, 4.0 * COMMAND, {"yaw_rad": truth["yaw_rad"]}))
    wheel_rate = truth["wheel_rad_s"]
    assert np.ptp(wheel_rate) > 1.0
    assert m.states["Omega"] == pytest.approx(wheel_rate, abs=0.02 * np.ptp(wheel_rate))
