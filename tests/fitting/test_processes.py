"""Searches that another process shares."""

import os
import pickle
import time
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from rwjax.fitting.batched_runs import Simulating
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import Problem
from rwjax.fitting.processes import ALONE, Task, Team
from rwjax.fitting.secant import descend, search_point, with_residual
from rwjax.plant.from_rig import bounds_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.exact import Exact
from tests.fitting.moving_runs import several
from tests.systems import platform, reaction

RIGS = (platform(), reaction(), platform("viscous = 0.02"))


def who(problem: Problem, seconds: float = 0.0) -> Simulating[int]:
    """The process in which it runs, and some time of it."""
    time.sleep(seconds)
    yield from ()
    return os.getpid()


def dies_elsewhere(problem: Problem, at_home: int) -> Simulating[int]:
    """Ends any process but one."""
    if os.getpid() != at_home:
        os._exit(3)
    return (yield from who(problem, 0.2))


def fails_elsewhere(problem: Problem, at_home: int) -> Simulating[int]:
    """Fails in any process but one."""
    if os.getpid() != at_home:
        raise ZeroDivisionError("there")
    return (yield from who(problem, 1.0))


def descended(begun: Fit) -> Simulating[Fit]:
    """Two steps of a fit."""
    here = yield from with_residual(begun)
    return (yield from descend(here, most_steps=2, tolerance=1e-9))


def begun(rig: Rig, problem: Problem) -> Fit:
    theta = 1.3 * theta_of(rig, problem.structure)
    free = np.array([name in rig.free for name in problem.structure.names])
    moves = coordinates(theta, free, bounds_of(rig, problem.structure), theta, prior=False)
    return search_point(problem, moves, theta, problem.start)


def test_a_search_gives_the_same_bytes_in_every_process_and_its_own_problem_back() -> None:
    fits = [begun(rig, several(rig)) for rig in RIGS]
    searches = [Task(f.problem, partial(descended, f)) for f in fits] * 2
    here = ALONE.together(searches)
    with Team(1) as team:
        shared = team.together(searches)
    for one, other, search in zip(here, shared, searches, strict=True):
        assert other.problem is search.problem
        assert one.theta.tobytes() == other.theta.tobytes() and one.cost == other.cost < np.inf
        assert one.evaluation.residual.tobytes() == other.evaluation.residual.tobytes()


@pytest.mark.slow
def test_searches_of_one_structure_stay_in_one_process_and_each_is_told_of_once() -> None:
    problems, told = [several(rig) for rig in RIGS], []
    searches = [Task(p, partial(who, p, 0.5)) for p in problems for _ in range(3)]
    with Team(1) as team:
        team.together([Task(p, partial(who, p)) for p in problems])  # so that the helper is there
        found = team.together(searches, done=lambda number, by: told.append((number, by)))
    assert sorted(told) == [*enumerate(found)]
    assert [len({*found[k : k + 3]}) for k in (0, 3, 6)] == [1, 1, 1]
    assert len({*found}) == 2 and os.getpid() in found


class Own(Exact):
    """Not the library's, though another process could find it by its name."""


@pytest.mark.slow
def test_a_solver_of_ones_own_stays_in_this_process() -> None:
    problems = [replace(several(rig), solver=Own()) for rig in RIGS]
    with Team(1) as team:
        for _ in range(5):  # a helper, if there were one, would have begun by then
            assert team.together([Task(p, partial(who, p, 0.3)) for p in problems]) == [os.getpid()] * 3


def test_what_a_helper_leaves_when_it_ends_is_done_here() -> None:
    problems = [several(rig) for rig in RIGS]
    with Team(1) as team:
        for _ in range(2):  # the second time there is no helper any more
            found = team.together([Task(p, partial(dies_elsewhere, p, os.getpid())) for p in problems])
            assert found == [os.getpid()] * 3


@pytest.mark.slow
def test_what_goes_wrong_in_a_helper_is_raised_here() -> None:
    problems = [several(rig) for rig in RIGS]
    with Team(1) as team, pytest.raises(ZeroDivisionError, match="there") as raised:
        for _ in range(10):  # until the helper is there and has a part
            team.together([Task(p, partial(fails_elsewhere, p, os.getpid())) for p in problems])
    assert "fails_elsewhere" in raised.value.__notes__[0]  # the place where it was raised


def test_what_goes_wrong_when_a_result_is_told_of_is_raised_here() -> None:
    def done(number: int, by: int) -> None:
        if by != os.getpid():
            raise ZeroDivisionError("told")

    problems = [several(rig) for rig in RIGS]
    with Team(1) as team, pytest.raises(ZeroDivisionError, match="told"):
        for _ in range(10):
            team.together([Task(p, partial(who, p, 0.5)) for p in problems], done=done)


def test_many_searches_of_one_structure_go_to_several_processes() -> None:
    problem = several(platform())
    with Team(1) as team:
        for _ in range(10):
            found = {*team.together([Task(problem, partial(who, problem, 0.05)) for _ in range(36)])}
            if len(found) == 2:
                break
    assert len(found) == 2


def test_what_follows_from_a_problem_is_not_sent() -> None:
    problem = several(platform())
    before = len(pickle.dumps(problem))
    assert problem.from_start.start_only.batch.windows and problem.windows_with_readings
    assert len(pickle.dumps(problem)) == before


def test_without_an_interpreter_everything_is_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", "")
    problems = [several(rig) for rig in RIGS]
    with Team(1) as team:
        assert team.together([Task(p, partial(who, p)) for p in problems]) == [os.getpid()] * 3


def waits_elsewhere(problem: Problem, at_home: int) -> Simulating[int]:
    """Takes a minute in any process but one."""
    return (yield from who(problem, 0.1 if os.getpid() == at_home else 60.0))


@pytest.mark.slow
def test_no_helper_is_waited_for_where_the_searches_have_to_end() -> None:
    class Over(Exception):
        """The time is."""

    def check() -> None:
        if time.monotonic() > until:
            raise Over

    problems = [several(rig) for rig in RIGS]
    with Team(1) as team:
        team.together([Task(p, partial(who, p)) for p in problems])  # so that the helper is there
        until = time.monotonic() + 1.0
        with pytest.raises(Over):
            team.together([Task(p, partial(waits_elsewhere, p, os.getpid())) for p in problems], check)
        assert time.monotonic() - until < 5.0
        assert len(team.together([Task(p, partial(who, p)) for p in problems])) == 3  # with helpers that begin anew
