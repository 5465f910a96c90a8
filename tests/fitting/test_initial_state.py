"""Initial states from the first 0.5 s: against a second implementation, closed form, and along kinks."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from rwjax.fitting.batched_runs import by_itself, together
from rwjax.fitting.initial_state import initial_states
from rwjax.fitting.problem import Problem, pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from tests.fitting.moving_runs import several
from tests.systems import platform, reaction, record, run

TIME = np.arange(601) * 0.01


PUSH = 0.8 * np.sign(np.sin(2.0 * TIME + 0.1))


def moving(seed: int, speed: float = 1.0, noise: float = 1e-3):
    rig = platform()
    y = run(rig, record(TIME, PUSH), {"w": speed})["yaw_rad"]
    return record(TIME, PUSH, {"yaw_rad": y + np.random.default_rng(seed).normal(0.0, noise, len(y))})


def early(problem: Problem, theta: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Residuals of the first 0.5 s of every log `(l, m)` [1]."""
    batch = problem.start_only.batch
    y, _ = free_run(problem.structure, theta, start, batch)
    return ((np.asarray(y) - batch.reading) * batch.weight).reshape(len(start), -1)


def by_scipy(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """Initial states by scipy's trust region with its own differences, log by log."""
    found = problem.start.copy()
    for log in range(len(found)):
        free = np.flatnonzero(problem.start_free[log])

        def residual(x: np.ndarray, log: int = log, free: np.ndarray = free) -> np.ndarray:
            start = found.copy()
            start[log, free] = x
            return early(problem, theta, start)[log]

        found[log, free] = least_squares(residual, found[log, free], diff_step=1e-5, xtol=1e-10, ftol=1e-12).x
    return found


@pytest.mark.parametrize("rig", [platform(), platform("viscous = 0.02"), reaction()], ids=["dry", "smooth", "reaction"])
def test_first_states_are_those_of_another_least_squares(rig: Rig) -> None:
    problem = several(rig)
    theta = theta_of(rig, problem.structure)
    other, found = by_scipy(problem, theta), together([initial_states(problem, theta)])[0]
    square = [np.sum(early(problem, theta, start) ** 2, axis=1) for start in (found, other)]
    assert np.all(square[0] <= square[1] * (1.0 + 1e-5))
    seen = [problem.structure.states.index(name) for name in ("psi", "w")]
    assert np.max(np.abs(found - other)[:, seen]) < 2e-3  # a few per cent of what noise does to a start


def test_what_a_log_knows_of_its_start_stays() -> None:
    rig = platform()
    problem, theta = several(rig), theta_of(rig, structure_of(rig))
    free = problem.start_free & (np.arange(problem.start.shape[1]) != np.arange(len(problem.start))[:, None])
    known = replace(problem, start_free=free)
    found = by_itself(initial_states(known, theta))
    assert np.array_equal(found[~free], problem.start[~free])
    assert np.all(
        np.sum(early(known, theta, found) ** 2, axis=1) <= np.sum(early(known, theta, problem.start) ** 2, axis=1)
    )
    nothing = replace(problem, start_free=np.zeros_like(free))
    assert np.array_equal(by_itself(initial_states(nothing, theta)), problem.start)
    one = by_itself(initial_states(problem, theta, logs=np.array([1])))
    assert np.array_equal(np.delete(one, 1, axis=0), np.delete(problem.start, 1, axis=0))
    assert not np.array_equal(one[1], problem.start[1])


def answered(problem: Problem, reading_of: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """First states where another model answers: residuals of the slots in turn, by psi and w beyond the problem's own start."""
    theta = theta_of(platform(), problem.structure)
    search, early_part = initial_states(problem, theta), problem.start_only.batch
    states = [problem.structure.states.index(name) for name in ("psi", "w")]
    wanted = next(search)
    while True:
        by_psi, by_w = reading_of(wanted.start[:, wanted.logs][..., states] - problem.start[wanted.logs][:, states]).T
        y = np.tile(early_part.reading[wanted.logs, : wanted.windows], (len(wanted.theta), 1, 1, 1, 1))
        y[:, :, :, ::2] += by_psi.T[..., None, None, None]
        y[:, :, :, 1::2] += by_w.T[..., None, None, None]
        try:
            wanted = search.send(y)
        except StopIteration as end:
            return end.value[:, states] - problem.start[:, states]


def test_a_step_that_goes_too_far_is_damped() -> None:
    found = answered(several(platform()), lambda beyond: np.arctan(8.0 * (beyond - 1.0)))
    assert found == pytest.approx(1.0, abs=1e-3)  # a whole step from there lands some hundred times as far away


def test_a_state_of_which_no_run_tells_stays_and_others_are_found() -> None:
    def reading(beyond: np.ndarray) -> np.ndarray:
        return np.where(beyond[..., :1] == 0.0, beyond - [0.0, 0.3], np.inf)  # every run with another psi fails

    found = answered(several(platform()), reading)
    assert np.all(found[:, 0] == 0.0) and found[:, 1] == pytest.approx(0.3, abs=1e-6)


def test_numbers_far_off_leave_no_start_worse_than_it_was() -> None:
    rig = platform()
    problem = several(rig)
    for factor in (0.02, 0.3, 4.0, 50.0):
        theta = factor * theta_of(rig, problem.structure)
        found = by_itself(initial_states(problem, theta))
        before, after = (np.sum(early(problem, theta, start) ** 2, axis=1) for start in (problem.start, found))
        moves = problem.start_free.any(axis=1)
        assert np.all(after <= before) and np.all(after[moves] < before[moves])


@pytest.mark.slow
def test_the_start_of_one_log_does_not_depend_on_the_others() -> None:
    rig = platform()
    logs = [moving(seed, speed) for seed, speed in enumerate((1.0, -2.0, 0.2, 5.0))]
    structure = structure_of(rig)
    of_all = by_itself(initial_states(pose(structure, logs), theta_of(rig, structure)))
    for k, log in enumerate(logs):
        alone = by_itself(initial_states(pose(structure, (log,)), theta_of(rig, structure)))
        assert of_all[k] == pytest.approx(alone[0], abs=1e-6)


def test_the_start_is_found_within_its_uncertainty() -> None:
    rig = platform()
    structure = structure_of(rig)
    speeds = [
        by_itself(initial_states(pose(structure, (moving(seed),)), theta_of(rig, structure)))[0, 1]
        for seed in range(30)
    ]
    assert abs(np.mean(speeds) - 1.0) < 4.0 * np.std(speeds) / np.sqrt(30)
    # slope of a line through 51 readings of noise 1e-3 over 0.5 s
    assert np.std(speeds) == pytest.approx(1e-3 / (np.std(TIME[:51]) * np.sqrt(51)), rel=0.5)
