"""Gains designed for a rig: the steps one by one, what is asked of them, and how the result reads."""

import numpy as np
import pytest

from rwjax.control.breakaway import breakaway
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import DEFAULT_CONTROLLER, loop_timing
from rwjax.control.gain_design import GainRequirement, tune
from rwjax.control.response import StepReference, step_response
from rwjax.control.robust_gains import robust_gains
from rwjax.control.robustness import robustness
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform

STEP = StepReference(np.radians(10.0), 2.0)


@pytest.mark.slow
def test_a_design_is_the_most_robust_gains_and_then_tuned_ones() -> None:
    rig = platform("viscous = 0.02")
    timing = loop_timing(rig)
    found = tune(rig, friction_share=0.5, step=STEP)
    thetas = theta_of(rig, structure_of(rig))[None]
    gains = robust_gains(rig, thetas, np.array([0.0, 100.0]), np.array([0.0, 100.0]), 0.5, timing, 0.02)
    start = DEFAULT_CONTROLLER._replace(kp=gains.kp, kd=gains.kd, feedforward=0.5 * breakaway(rig))
    assert found.robust.controller == start and found.plants == 1
    for one in (found.robust, found.tuned):
        assert one.robustness == robustness(rig, thetas, timing, one.controller)
        seen = step_response(run_rig(rig, one.controller, STEP.samples(0.01), timing), STEP.angle, 0.01, 10.0)
        assert [float(x) for x in one.response] == [float(x) for x in seen]
    assert found.tuned.robustness.modulus > 0.999 * found.least_modulus
    lines = str(found).splitlines()
    assert lines[0] == "gains for 1 plant:" and len(lines) == 3
    assert lines[1].startswith(
        f"  robust: kp {gains.kp:.4g} V/rad, ki 0 V/(rad s), kd {gains.kd:.4g} V s/rad; modulus margin "
    )


@pytest.mark.slow
def test_robust_gains_move_an_axis_with_dry_friction() -> None:
    told: list[str] = []
    found = tune(platform(), friction_share=0.5, step=STEP, progress=told.append)
    assert told[0] == "looking for the most robust gains for 1 plant" and told[-1].startswith("looking at the margins")
    assert np.isfinite(found.robust.response.settling) and found.robust.why == "" and "settles in" in str(found)
    assert found.robust.robustness.modulus >= found.tuned.robustness.modulus - 0.01


@pytest.mark.slow
def test_robust_gains_move_an_axis_though_the_least_gain_asked_for_already_breaks_it_loose() -> None:
    found = tune(platform(), GainRequirement(kp=(8.0, 100.0), kd=(0.0, 30.0)), step=STEP)
    assert not found.robust.why and np.isfinite(found.robust.response.settling)


@pytest.mark.slow
def test_gains_that_leave_the_axis_where_it_is_are_named_with_the_reason() -> None:
    found = tune(platform(), GainRequirement(kp=(0.0, 0.5), kd=(0.0, 5.0)), step=STEP)
    assert "friction holds the axis until the command is 0.125 V" in found.robust.why  # 0.05 N m / 0.4 N m/V
    assert found.robust.why in str(found)
    assert found.robust.controller.kp < 0.5  # stronger gains of less margin move it no more


def test_an_integral_that_no_robust_gains_bear_is_said() -> None:
    law = DEFAULT_CONTROLLER._replace(ki=1e5)
    with pytest.raises(
        InputError, match=r"with it the loop is not stable at the most robust gains, kp .*; lower --ki$"
    ):
        tune(platform(), controller=law, step=STEP)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"kp": (5.0, 1.0)}, "kp 5 to 1: has to run from 0 or more to a larger number"),
        ({"kd": (-1.0, 1.0)}, "kd -1 to 1: has to run from 0 or more"),
        ({"sigma": -1.0}, "sigma -1: must not be negative"),
        ({"least_modulus": 1.0}, "least_modulus 1: has to lie between 0 and 1"),
    ],
)
def test_a_requirement_that_cannot_be_met_is_refused(wrong: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        GainRequirement(**wrong)


def test_more_friction_than_there_is_is_not_fed_forward() -> None:
    with pytest.raises(InputError, match=r"friction_share 1\.2: has to lie between 0 and 1"):
        tune(platform(), friction_share=1.2)
