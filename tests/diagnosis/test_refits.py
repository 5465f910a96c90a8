"""Refits: numbers on some of the training logs, by a fit or by a step."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import NOTHING
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.refits import refitted
from rwjax.diagnosis.settings import Settings
from tests.diagnosis.simulated import TIME, true_log
from tests.systems import platform, record, run


def test_a_fit_to_a_fold_begins_from_the_estimates_on_all_logs() -> None:
    rig = platform()
    logs = [true_log(rig), true_log(rig)]
    fits = ModelFits.of(rig, logs, [0, 1])
    inertia = fits.problem.names.index("axis.inertia")
    on_one, on_both = refitted(fits, [(NOTHING, [0]), (NOTHING, [1, 0])])
    assert on_one[inertia] == pytest.approx(fits(NOTHING).numbers()["axis.inertia"], rel=1e-3)
    assert on_one[inertia] != on_both[inertia] and np.array_equal(on_both, fits(NOTHING).theta)


@pytest.mark.parametrize("by_start_rule", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_without_one_of_many_runs_the_numbers_move_as_in_a_fit_without_it(by_start_rule: bool) -> None:
    rig, rng = platform("viscous = 0.02", '"axis.inertia", "axis.friction.viscous"'), np.random.default_rng(3)
    logs, time = [], TIME[:201]
    for rate in np.linspace(1.0, 4.0, 8):
        log = record(time, 0.4 * np.sin(rate * time) * (time > 0.6))
        angle = run(rig, log, {})["yaw_rad"] + rng.normal(0.0, 2e-4, len(time))
        logs.append(replace(log, name=f"{rate:g}.csv", outputs={"yaw_rad": angle}))
    cases = [(NOTHING, [k for k in range(8) if k != left]) for left in range(8)]
    moved = []
    for light in (1.0, -1.0):  # by a step, and by a fit
        settings = replace(Settings(), fitting=replace(Settings().fitting, light_run=light, tolerance=1e-9))
        fits = ModelFits.of(rig, logs, range(8), settings)
        fits(NOTHING)
        if by_start_rule:
            fits.start_from_first_readings()
        moved.append(np.array(refitted(fits, cases)) - fits(NOTHING).theta)
    step, fit = moved
    free = [fits.problem.names.index(name) for name in rig.free]
    size = np.sqrt(np.mean(fit[:, free] ** 2, axis=0))
    assert np.all(size > 0.0) and np.all(np.sqrt(np.mean((step - fit)[:, free] ** 2, axis=0)) < 0.05 * size)


@pytest.mark.slow
def test_a_run_that_tells_much_is_left_out_by_a_fit_though_there_are_many() -> None:
    """A model that lacks dry friction, and one run that is longer than the others together."""
    rig, logs = platform("viscous = 0.02", '"axis.inertia", "axis.friction.viscous"'), []
    for k, samples in enumerate((*[201] * 14, 2001)):
        time = TIME[:samples]
        log = record(time, (0.3 + 0.03 * k) * np.sin((1.0 + 0.2 * k) * time))
        angle = run(rig, log, {}, effects={"axis.coulomb": {"M_c": 0.02}})["yaw_rad"]
        logs.append(replace(log, name=f"{k}.csv", outputs={"yaw_rad": angle}))
    without = [(NOTHING, range(14))]
    found = []
    for light in (
        Settings().fitting.light_run,
        -1.0,
        np.inf,
    ):  # with -1 every run is left out by a fit, with no limit by a step
        settings = replace(Settings(), fitting=replace(Settings().fitting, light_run=light))
        found.append(refitted(ModelFits.of(rig, logs, range(15), settings), without)[0])
    usual, fit, step = found
    assert np.array_equal(usual, fit) and not np.allclose(usual, step, rtol=1e-3)
