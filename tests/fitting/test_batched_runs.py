"""Searches whose free runs share batches."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from threading import Barrier

import numpy as np
import pytest

from rwjax.fitting import batched_runs
from rwjax.fitting.batched_runs import BATCH, Simulating, Wanted, together
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.secant import residuals
from rwjax.plant.from_rig import theta_of
from rwjax.plant.structure import Structure
from rwjax.simulation.batch import Batch
from rwjax.simulation.free_run import free_run, free_runs
from tests.fitting.moving_runs import alone, several
from tests.systems import platform, reaction


@pytest.mark.slow
def test_every_search_gets_its_own_runs_however_many_share_a_call() -> None:
    one, other = several(platform()), several(reaction())
    rng = np.random.default_rng(0)

    def search(problem: Problem, rounds: int) -> Simulating[list[float]]:
        theta, found = theta_of(platform() if problem is one else reaction(), problem.structure), []
        for _ in range(rounds):
            thetas = [theta * rng.uniform(0.8, 1.2, len(theta)) for _ in range(1 + BATCH // 5)]
            starts = [problem.start + 0.1 * rng.normal(size=problem.start.shape) for _ in thetas]
            r = yield from residuals(problem, thetas, starts)
            found += [
                float(np.max(np.abs(r[k] - alone(problem, thetas[k], starts[k])))) / float(np.max(np.abs(r[k])))
                for k in (0, len(thetas) - 1)
            ]
        return found

    rounds = (3, 1, 2, 0)
    found = together([search(one, 3), search(other, 1), search(one, 2), search(other, 0)])
    assert [len(f) for f in found] == [2 * n for n in rounds]
    assert max(worst for f in found for worst in f) < 1e-9


def test_what_goes_wrong_in_one_search_ends_all() -> None:
    problem = several(platform())
    theta = theta_of(platform(), problem.structure)[None]
    rounds = []

    def search(fails: bool) -> Simulating[None]:
        for _ in range(10_000):
            yield Wanted(problem, theta, problem.start[None], np.arange(3), 2)
            rounds.append(fails)
            if fails and rounds.count(True) == 3:
                raise ZeroDivisionError("here")

    with pytest.raises(ZeroDivisionError, match="here"):
        together([search(False), search(True), search(False)])
    assert len(rounds) < 1000


def test_two_threads_make_two_programs_at_the_same_time(monkeypatch: pytest.MonkeyPatch) -> None:
    called, both = [], Barrier(2)

    def simulated(
        structure: Structure, theta: np.ndarray, start: np.ndarray, windows: int, batch: Batch, **_
    ) -> np.ndarray:
        called.append(structure.kind)
        if len(called) <= 2:
            both.wait(30.0)
        return np.zeros((len(theta), windows, batch.slot_step.shape[2], len(structure.outputs)))

    def search(problem: Problem) -> Simulating[int]:
        theta = np.zeros((1, len(problem.structure.names)))
        return len((yield Wanted(problem, theta, problem.start[None], np.arange(3), 2)))

    for (
        thread
    ) in threading.enumerate():  # one that an earlier test left behind would tell of its program as called here
        if thread is not threading.current_thread() and thread.name.startswith(ThreadPoolExecutor.__name__):
            thread.join()
    monkeypatch.setattr(batched_runs, "called", set())  # as in a new process
    monkeypatch.setattr(batched_runs, "free_runs", simulated)
    monkeypatch.setattr(batched_runs, "THREADS", 2)
    assert together([search(several(platform())), search(several(reaction()))]) == [1, 1]
    assert sorted(called[:2]) == ["platform", "reaction"] and len(called) == 6


def test_the_first_windows_are_those_of_the_whole_run() -> None:
    problem = several(platform())
    theta, every = theta_of(platform(), problem.structure)[None], np.arange(3)

    def search(windows: int) -> Simulating[np.ndarray]:
        return (yield Wanted(problem, theta, problem.start[None], every, windows))

    few, whole = together([search(2), search(problem.batch.windows)])
    assert few.shape[2] == 2
    assert np.array_equal(few, whole[:, :, :2])


def test_plants_that_differ_by_light_effects_share_a_call(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, calls = several(platform()), []
    structures = [problem.structure.with_effects(*names) for names in ((), ("drive.bias",), ("axis.spring",))]

    def counted(structure: Structure, theta: np.ndarray, *given, **more) -> np.ndarray:
        calls.append(len(theta))
        return free_runs(structure, theta, *given, **more)

    def posed(structure: Structure) -> Problem:
        own = pose(structure, problem.logs, problem.noise).batch
        batch = problem.batch._replace(theta_index=own.theta_index, theta_offset=own.theta_offset)
        return replace(problem, structure=structure, batch=batch, shares_programs=True)

    def search(other: Problem, theta: np.ndarray) -> Simulating[np.ndarray]:
        return (yield Wanted(other, theta[None], other.start[None], np.array([1]), other.batch.windows))

    problems = [posed(structure) for structure in structures]
    thetas = [theta_of(platform(), structure) for structure in structures]
    for theta in thetas[1:]:
        theta[len(problem.structure.names)] = 0.3
    monkeypatch.setattr(batched_runs, "free_runs", counted)
    found = together([search(*each) for each in zip(problems, thetas, strict=True)], threads=1)
    assert calls == [3]
    for other, theta, y in zip(problems, thetas, found, strict=True):
        alone, _ = free_run(other.structure, theta, other.start, other.batch)
        assert np.max(np.abs(y[0, 0] - alone[1])) <= 1e-9 * np.max(np.abs(alone[1]))
    assert np.max(np.abs(found[1] - found[0])) > 0.01 < np.max(np.abs(found[2] - found[0]))
