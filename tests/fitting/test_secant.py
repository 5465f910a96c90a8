"""Searches side by side, first states by the start rule, and secants, each against another way to the same numbers."""

import numpy as np
import pytest

from rwjax import Log
from rwjax.fitting.batched_runs import BATCH, Simulating, Wanted, together
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.initial_state import initial_states_by_sensitivities
from rwjax.fitting.initial_state_by_secants import initial_states_by_secants
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.secant import descend, residuals, search_point, slopes, with_residual
from rwjax.fitting.sensitivities import COLUMNS, residual_jacobian, sensitivities
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from rwjax.simulation.shooting import evaluate
from tests.systems import platform, reaction, record, run

TIME = np.arange(600) * 0.01
COMMAND = 0.4 * np.sin(3.0 * TIME) + 0.2
MOVING = {"psi": 0.3, "w": 1.2}


def moving(rig: Rig, start: dict[str, float] | None = None, until: int = 600, noise: float = 1e-3) -> Log:
    """A run that does not start at rest."""
    t, u = TIME[:until], COMMAND[:until]
    y = run(rig, record(t, u), start or MOVING)["yaw_rad"]
    return record(t, u, {"yaw_rad": y + np.random.default_rng(until).normal(0.0, noise, until)})


def several(rig: Rig) -> Problem:
    """Three runs, one of them shorter."""
    return pose(structure_of(rig), [moving(rig), moving(rig, {"w": -0.7}), moving(rig, until=330)])


def alone(problem: Problem, theta: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Residual by the other program, one parameter vector at a time."""
    y, _ = free_run(problem.structure, theta, start, problem.batch)
    return (np.asarray(y) - problem.batch.reading) * problem.batch.weight


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


def test_the_first_windows_are_those_of_the_whole_run() -> None:
    problem = several(platform())
    theta, every = theta_of(platform(), problem.structure)[None], np.arange(3)

    def search(windows: int) -> Simulating[np.ndarray]:
        return (yield Wanted(problem, theta, problem.start[None], every, windows))

    few, whole = together([search(2), search(problem.batch.windows)])
    assert few.shape[2] == 2
    assert np.array_equal(few, whole[:, :, :2])


@pytest.mark.parametrize("rig", [platform(), platform("viscous = 0.02"), reaction()], ids=["dry", "smooth", "reaction"])
def test_first_states_agree_with_those_by_exact_sensitivities(rig: Rig) -> None:
    problem = several(rig)
    theta = theta_of(rig, problem.structure)
    exact, found = (
        initial_states_by_sensitivities(problem, theta),
        together([initial_states_by_secants(problem, theta)])[0],
    )

    def early(start: np.ndarray) -> np.ndarray:
        y, _ = free_run(problem.structure, theta, start, problem.start_only.batch)
        square = ((np.asarray(y) - problem.start_only.batch.reading) * problem.start_only.batch.weight) ** 2
        return np.sum(square, axis=(1, 2, 3))

    assert np.all(early(found) <= early(exact) * (1.0 + 1e-5))
    seen = [problem.structure.states.index(name) for name in ("psi", "w")]
    assert np.max(np.abs(found - exact)[:, seen]) < 2e-3  # a few per cent of what noise does to a start


def test_slopes_are_the_sensitivities_of_a_smooth_plant() -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    problem = several(rig)
    theta = theta_of(rig, problem.structure)
    free = np.array([name in rig.free for name in problem.structure.names])
    c = coordinates(theta, free, bounds_of(rig, problem.structure), np.maximum(np.abs(theta), 1e-3))
    residual = alone(problem, theta, problem.start)
    e = together([slopes(problem, c, theta, problem.start, residual, 1e-5)])[0]
    _, nodes = free_run(problem.structure, theta, problem.start, problem.batch)
    exact = sensitivities(problem, theta, c.index, np.asarray(nodes))
    for log in range(3):
        through = residual_jacobian(exact, log)
        columns = [0, 1, through.shape[-1] - 2, through.shape[-1] - 1]  # numbers, then states; zeros between
        for k, column in enumerate(columns):
            scale = np.max(np.abs(through[..., column]))
            assert np.max(np.abs(e.local[k, log] - through[..., column])) < 1e-4 * scale


@pytest.mark.parametrize("beyond", [np.inf, np.nan, 1e160])
def test_a_number_whose_run_leaves_the_range_of_numbers_is_not_moved(beyond: float) -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    problem = several(rig)
    theta = theta_of(rig, problem.structure)
    free = np.array([name in rig.free for name in problem.structure.names])
    c = coordinates(theta, free, bounds_of(rig, problem.structure), np.maximum(np.abs(theta), 1e-3))
    search = slopes(problem, c, theta, problem.start, np.zeros_like(problem.batch.reading), 1e-2)
    wanted = next(search)
    y = np.stack([problem.batch.reading[wanted.logs, : wanted.windows] + 0.1] * len(wanted.theta))
    y[0] = beyond
    with pytest.raises(StopIteration) as end:
        search.send(y)
    e = end.value.value
    assert not e.local[0].any() and e.local[1].any()
    assert np.all(np.isfinite(e.H)) and not e.H[:, 0].any() and np.all(e.H[:, 1, 1] > 0.0)


def test_sensitivities_log_by_log_are_those_of_all_at_once_and_none_where_no_reading_counts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rwjax.fitting.sensitivities.LONG", 0)
    problem = several(platform("viscous = 0.02")).only((0, 2))
    theta = theta_of(platform("viscous = 0.02"), problem.structure)
    numbers = np.array([problem.structure.names.index(name) for name in ("axis.inertia", "axis.friction.viscous")])
    _, nodes = (np.asarray(a) for a in free_run(problem.structure, theta, problem.start, problem.batch))
    padded = np.append(numbers, [len(theta)] * (COLUMNS - len(numbers)))
    at_once = evaluate(problem.structure, theta, padded, nodes, problem.batch)
    found = sensitivities(problem, theta, numbers, nodes)
    for name, one, all_of_them in zip(found._fields, found, at_once, strict=True):
        one, whole = (np.moveaxis(np.asarray(a), 1 if name == "local" else 0, 0) for a in (one, all_of_them))
        assert not one[1].any()
        assert np.max(np.abs(one[[0, 2]] - whole[[0, 2]])) <= 1e-12 * np.max(np.abs(whole)), name


def test_a_descent_by_secants_finds_the_numbers_of_runs_without_noise() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05", free='"axis.inertia", "axis.friction.coulomb"')
    logs = [moving(rig, noise=0.0), moving(rig, {"w": -0.7}, noise=0.0)]
    problem = pose(structure_of(rig), logs, {"yaw_rad": 1e-3})
    truth = theta_of(rig, problem.structure)
    free = np.array([name in rig.free for name in problem.structure.names])
    c = coordinates(truth, free, bounds_of(rig, problem.structure), np.maximum(np.abs(truth), 1e-3))
    for p in (problem, problem.from_start):
        here = together([with_residual(search_point(p, c, np.where(free, 1.3 * truth, truth), p.start))])[0]
        found = together([descend(here, most_steps=25, tolerance=1e-9)])[0]
        assert found.theta[c.index] == pytest.approx(truth[c.index], rel=1e-4)
        assert found.cost < 1e-3 * here.cost
