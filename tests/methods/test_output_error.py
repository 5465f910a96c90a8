"""Output error: known numbers come back."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.methods.output_error import finite_differences
from tests.methods.logs import COMMAND, FREE, TIME, axis_log
from tests.systems import platform, record, run, wheel


@pytest.mark.parametrize(("method", "within"), [(finite_differences, 0.005)])
def test_known_numbers_of_an_axis_come_back(method, within: float) -> None:
    truth = platform(free=FREE)
    believed = truth.with_values({name: 1.15 * truth.values[name] for name in truth.free})
    found = method(believed, [axis_log(truth)]).rig
    for name in truth.free:
        assert found.values[name] == pytest.approx(truth.values[name], rel=within), name
        assert found.standard_error[name] > 0.0


@pytest.mark.parametrize(("method", "within"), [(finite_differences, 0.01)])
def test_known_numbers_of_a_wheel_come_back(method, within: float) -> None:
    truth = wheel()
    believed = truth.with_values({"wheel.inertia": 1.5e-4})
    u = 6.0 * COMMAND
    y = run(truth, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    log = record(TIME, u, {"wheel_rad_s": y + np.random.default_rng(1).normal(0.0, 0.3, len(y))})
    found = method(believed, [log]).rig
    assert found.values["wheel.inertia"] == pytest.approx(1.24e-4, rel=within)


@pytest.mark.parametrize(("method", "within"), [(finite_differences, 0.05)])
def test_an_effect_on_the_command_is_estimated_by_every_method(method, within: float) -> None:
    base = wheel(inductance=0.0)
    truth = replace(base, effects={"drive.deadzone": {"u_0": 0.8}}, free=(*base.free, "drive.deadzone.u_0"))
    u = 6.0 * COMMAND
    y = run(truth, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    log = record(TIME, u, {"wheel_rad_s": y + np.random.default_rng(1).normal(0.0, 0.3, len(y))})
    found = method(truth.with_values({"drive.deadzone.u_0": 0.6}), [log]).rig
    assert found.values["drive.deadzone.u_0"] == pytest.approx(0.8, rel=within)
