"""What a step response shows, read off responses with known figures."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.control.closed_loop import ClosedLoopRun, run_rig
from rwjax.control.controller import Controller
from rwjax.control.response import StepReference, step_response
from rwjax.errors import InputError
from tests.systems import reaction


def test_a_response_is_read_off_as_it_is() -> None:
    t = 0.01 * np.arange(1000)
    angle = 1.0 - np.exp(-t) * np.cos(3.0 * t)
    run = ClosedLoopRun(angle, 0.0 * t, np.where(t < 2.0, 5.0, 1.0), 0.0 * t)
    found = step_response(run, 1.0, 0.01, voltage_limit=5.0)
    peak = np.max(angle) - 1.0
    assert found.overshoot == pytest.approx(peak) and found.saturated == pytest.approx(0.2)
    outside = t[np.abs(angle - 1.0) > 0.02][-1]
    assert found.settling == pytest.approx(outside + 0.01) and found.cycle < 1e-3
    assert step_response(ClosedLoopRun(0.5 * t, t, t, t), 1.0, 0.01).settling == np.inf


def test_a_diverged_run_never_settles() -> None:
    angle = np.append(np.linspace(0.0, 1.0, 90), np.full(10, np.nan))
    assert step_response(ClosedLoopRun(angle, angle, angle, angle), 1.0, 0.01).settling == np.inf


def test_the_wheel_s_fastest_rate_is_seen() -> None:
    run = run_rig(reaction(), Controller(40.0, kd=10.0, voltage_limit=10.0), np.full(300, 0.3))
    assert float(step_response(run, 0.3, 0.01).fastest) == pytest.approx(float(jnp.max(jnp.abs(run.wheel))))


def test_a_step_holds_its_angle_at_every_sample() -> None:
    assert np.array_equal(StepReference(0.3, 2.0).samples(0.01), np.full(200, 0.3))
    with pytest.raises(InputError, match="has to hold 10 to 1000000 samples of 0.5 s"):
        StepReference(0.3, 2.0).samples(0.5)
    with pytest.raises(InputError, match="has to be a number other than 0"):
        StepReference(0.0)
