"""Tuning: the slope through stick and slip, and a minimum that a search over a grid does not undercut."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.control.closed_loop import loop_setup
from rwjax.control.controller import Controller
from rwjax.control.margins import sampled_modulus
from rwjax.control.sampled_loop import SampledLaw, sampled_loops
from rwjax.control.tuning import LEAST_MODULUS, SEARCH, loss, loss_and_gradient, tune_from
from rwjax.errors import InputError
from tests.control.tuned_platform import REFERENCE, RIG, TIMING
from tests.joints import as_platform, joint
from tests.systems import reaction


def of(kp: float, kd: float, ki: float = 0.0) -> float:
    structure, theta, _, sign = loop_setup(RIG, TIMING)
    return float(
        loss(
            structure,
            theta,
            TIMING,
            _arrays(Controller(kp, ki, kd, 0.02, voltage_limit=5.0)),
            jnp.asarray(REFERENCE),
            sign,
        )
    )


def _arrays(controller: Controller) -> Controller:
    return Controller(*(jnp.asarray(float(v)) for v in controller))


@pytest.mark.slow
def test_the_slope_is_that_of_the_loss() -> None:
    structure, theta, _, sign = loop_setup(RIG, TIMING)
    gains = np.array([6.0, 0.7, 2.5])
    start = _arrays(Controller(*gains[[0, 1]], kd=2.5, filter_time=0.02, voltage_limit=5.0))
    value, slope = loss_and_gradient(
        structure, theta, TIMING, start, jnp.asarray(REFERENCE), sign, jnp.log(gains), jnp.eye(3)
    )
    assert float(value) == pytest.approx(of(6.0, 2.5, 0.7))
    for k in range(3):
        step = np.exp(1e-5 * np.eye(3)[k])
        ends = [of(kp, kd, ki) for kp, ki, kd in (gains * step, gains / step)]
        assert float(slope[k]) == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-3)


@pytest.mark.slow
def test_machine_code_and_xla_give_the_same_slope(monkeypatch: pytest.MonkeyPatch) -> None:
    structure, theta, _, sign = loop_setup(RIG, TIMING)
    law = Controller(6.0, 0.7, 2.5, 0.02, voltage_limit=5.0)
    logs, free = jnp.log(jnp.array([6.0, 0.7, 2.5])), jnp.eye(3)
    given = (structure, theta, TIMING, law, jnp.asarray(REFERENCE), sign, logs, free)
    value, slope = loss_and_gradient(*given)
    monkeypatch.setenv("RWJAX_THROUGH_XLA", "1")
    other = loss_and_gradient(*given)
    assert value == pytest.approx(other[0], rel=1e-9) and slope == pytest.approx(other[1], rel=1e-9)


@pytest.mark.slow
def test_no_gains_of_a_grid_with_the_same_margin_do_better() -> None:
    start = Controller(2.0, kd=0.5, filter_time=0.02, voltage_limit=5.0)
    found = tune_from(RIG, start, REFERENCE, TIMING)
    assert found.loss[1] < 0.2 * found.loss[0]
    (loop,) = sampled_loops(RIG, SampledLaw(TIMING, start.filter_time))
    grid = [(kp, kd) for kp in np.geomspace(1.0, 60.0, 14) for kd in np.geomspace(0.3, 20.0, 14)]
    best = min(of(*pair) for pair in grid if sampled_modulus(loop, *pair) >= LEAST_MODULUS)
    assert found.loss[1] <= best * 1.001
    assert found.modulus >= LEAST_MODULUS * 0.999 and found.least == LEAST_MODULUS
    assert of(found.controller.kp, found.controller.kd) == pytest.approx(found.loss[1])


def test_gains_that_do_not_move_the_axis_are_left_behind() -> None:
    stuck = Controller(0.2, kd=0.05, filter_time=0.02, voltage_limit=5.0)  # 0.06 V; friction holds up to 0.125 V
    told: list[str] = []
    found = tune_from(RIG, stuck, REFERENCE, TIMING, progress=told.append)
    steps = [f"tuning through the closed loop: step {k} of 60 at most" for k in range(1, len(told))]
    assert told == ["tuning through the closed loop", *steps] and len(steps) > 1
    assert found.loss[1] < 0.1 * found.loss[0] and found.controller.ki == 0.0


def test_no_step_of_the_search_is_said_beyond_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SEARCH, "maxiter", 2)
    told: list[str] = []
    start = Controller(0.2, kd=0.05, filter_time=0.02, voltage_limit=5.0)
    tune_from(RIG, start, REFERENCE, TIMING, progress=told.append)
    assert told[1:] == [f"tuning through the closed loop: step {k} of 2 at most" for k in (1, 2, 2)]


@pytest.mark.parametrize("exponent", [1.9968, 2.0, 2.0032])
@pytest.mark.slow
def test_where_friction_makes_the_loss_nonsmooth_no_small_move_within_the_margin_does_much_better(
    exponent: float,
) -> None:
    rig = replace(reaction(), effects={"axis.stribeck": {"M_c": 0.01, "M_e": 0.006, "v_s": 0.2, "n": exponent}})
    law = Controller(6.3, ki=1.9, kd=1.33, filter_time=0.02, feedforward=0.58, deadband=0.0035, voltage_limit=10.0)
    reference = np.full(600, np.radians(15.0))
    found = tune_from(rig, law, reference, TIMING)
    structure, theta, _, sign = loop_setup(rig, TIMING)
    (loop,) = sampled_loops(rig, SampledLaw(TIMING, law.filter_time, integral=True))
    best = np.array([found.controller.kp, found.controller.ki, found.controller.kd])
    for k in range(3):
        for factor in (0.9, 1.1):
            kp, ki, kd = gains = best * np.where(np.arange(3) == k, factor, 1.0)
            if sampled_modulus(loop, *gains) >= found.least:
                other = _arrays(found.controller._replace(kp=kp, ki=ki, kd=kd))
                value = float(loss(structure, theta, TIMING, other, jnp.asarray(reference), sign))
                assert value > 0.95 * found.loss[1], (k, factor)


def test_an_unstable_start_is_refused() -> None:
    with pytest.raises(InputError, match="not stable"):
        tune_from(reaction(), Controller(50.0, ki=1e4, kd=1.0), REFERENCE, TIMING)
    with pytest.raises(InputError, match="not stable"):  # in continuous time it is
        tune_from(RIG, Controller(100.0, kd=100.0), REFERENCE, TIMING)


@pytest.mark.parametrize("gains", [(0.0, 0.0), (5.0, -1.0)])
def test_gains_that_cannot_be_tuned_are_refused(gains: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="have to be positive"):
        tune_from(RIG, Controller(gains[0], kd=gains[1]), REFERENCE, TIMING)


@pytest.mark.slow
def test_a_joint_is_tuned_as_the_equal_platform() -> None:
    rig = joint(axis__friction__coulomb=0.02)
    start = Controller(4.0, kd=0.2, filter_time=0.02, voltage_limit=6.0)
    step = np.full(60, 0.4)
    found, same = (tune_from(r, start, step, TIMING).controller for r in (rig, as_platform(rig)))
    assert (found.kp, found.kd) == pytest.approx((same.kp, same.kd), rel=1e-6) and found.kp != start.kp
