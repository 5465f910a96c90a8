"""A sweep is many closed loops: each run against the loop run by itself."""

import numpy as np
import pytest

from rwjax.control import sweep as module
from rwjax.control.closed_loop import ClosedLoopRun, run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.response import Response, StepReference, step_response
from rwjax.control.sweep import GainSweep, step_responses, sweep
from rwjax.plant.from_rig import structure_of, theta_of
from tests.joints import as_platform, joint
from tests.systems import platform

TIMING = LoopTiming(period=0.02, steps=2, delay_steps=1, counts=2048)
CONTROLLERS = [Controller(kp, 0.5, kd, 0.02, voltage_limit=3.0) for kp in (2.0, 6.0, 12.0) for kd in (0.5, 3.0)]


@pytest.mark.parametrize("runs", [5, 400])  # several blocks, the last one padded; and one
def test_every_run_is_the_loop_run_by_itself(runs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "BATCH", runs)
    rig = platform()
    structure = structure_of(rig)
    light = rig.with_values({"axis.inertia": 0.07})
    thetas = np.stack([theta_of(rig, structure), theta_of(light, structure)])
    references = np.array([[0.2] * 150, [0.5] * 30 + [-0.1] * 120])
    found = step_responses(rig, CONTROLLERS, references, TIMING, thetas, since=30)
    assert found.overshoot.shape == (6, 2, 2)
    for g, controller in enumerate(CONTROLLERS):
        for r, reference in enumerate(references):
            for k, plant in enumerate((rig, light)):
                run = run_rig(plant, controller, reference, TIMING)
                late = ClosedLoopRun(*(x[30:] for x in run))
                alone = step_response(late, reference[-1], TIMING.period, controller.voltage_limit)
                for whole, one in zip(found, alone, strict=True):
                    assert float(whole[g, r, k]) == pytest.approx(float(one), rel=1e-9, abs=1e-12)


def test_machine_code_and_xla_give_the_same_figures_on_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    laws = [law._replace(kp=law.kp * share) for law in CONTROLLERS for share in np.linspace(0.8, 1.2, 7)]
    references = np.array([[0.2] * 150, [-0.1] * 150])
    found = {}
    for threads in (1, 2):
        monkeypatch.setattr(module, "THREADS", threads)
        found[threads] = step_responses(platform(), laws, references, TIMING)
    monkeypatch.setenv("RWJAX_THROUGH_XLA", "1")
    by_xla = step_responses(platform(), laws, references, TIMING)
    for one, two, other in zip(found[1], found[2], by_xla, strict=True):
        assert np.array_equal(one, two)
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


def test_a_reference_that_goes_on_changing_is_refused() -> None:
    with pytest.raises(ValueError, match="from sample 10 on"):
        step_responses(platform(), CONTROLLERS, np.linspace(0.0, 1.0, 50)[None], TIMING, since=10)


def test_a_sweep_over_gains_is_every_loop_by_itself_and_prints_itself() -> None:
    rig, kp, kd = platform(), np.array([4.0, 9.0]), np.array([1.0, 2.0, 3.0])
    step, law = StepReference(0.3, 3.0), Controller(0.0, filter_time=0.02, voltage_limit=5.0)
    found = sweep(rig, kp, kd, controller=law, step=step, timing=TIMING)
    for i, j in np.ndindex(2, 3):
        run = run_rig(rig, law._replace(kp=kp[i], kd=kd[j]), step.samples(TIMING.period), TIMING)
        alone = step_response(run, 0.3, TIMING.period, 5.0)
        for whole, one in zip(found.response, alone, strict=True):
            assert float(whole[i, j]) == pytest.approx(float(one), rel=1e-9, abs=1e-12)
    lines = str(found).splitlines()
    assert lines[0] == "step of 17.1887° over 3 s at 6 pairs of PD gains:"
    assert lines[1] == f"  {found.settled} settle within 2 % of the step"
    assert (found.fastest is None) == (found.settled == 0) and len(lines) == 2 + (found.fastest is not None)


def test_the_fastest_pair_is_the_one_that_settles_first() -> None:
    settling = np.array([[np.inf, 2.0], [0.5, np.inf]])
    other = np.zeros((2, 2))
    found = GainSweep(
        np.array([1.0, 2.0]), np.array([3.0, 4.0]), StepReference(), Response(other, settling, *[other] * 4)
    )
    assert found.settled == 2 and found.fastest == (1, 0)
    assert str(found).splitlines()[-1] == "  fastest: kp 2 V/rad, kd 3 V s/rad after 0.5 s, overshoot 0 %"


@pytest.mark.slow
def test_the_loops_of_a_joint_are_those_of_the_equal_platform() -> None:
    rig = joint(axis__friction__coulomb=0.05, axis__gravity__torque=0.3)
    reference = np.full((1, 100), 0.4)
    found, same = (step_responses(r, CONTROLLERS, reference, TIMING) for r in (rig, as_platform(rig)))
    for a, b in zip(found, same, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12)
    assert np.ptp(np.asarray(found.error)) > 0.01  # the gains differ in what they leave
