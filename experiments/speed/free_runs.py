"""Free runs of a batch: what a search spends its time on, by the library's call itself."""

from collections.abc import Callable

import numpy as np

from experiments.speed import c_limit, scipy_numba
from experiments.speed.lowering import XLA, by_xla
from experiments.speed.problem import STRIBECK, Added, Arrays, arrays, log, posed, with_effects
from experiments.speed.table import ROUNDS, machine, race, seconds, show
from rwjax.fitting.batched_runs import BATCH
from rwjax.fitting.problem import Problem
from rwjax.simulation.free_run import free_runs

OURS = "rwjax, `free_runs`"
SCATTER = 0.05
"""Of the numbers of the runs, in the logarithm."""
FRICTIONS: dict[str, tuple[Added, ...]] = {"Coulomb friction": (), "Stribeck friction": (STRIBECK,)}


def lanes(length: float, added: tuple[Added, ...]) -> tuple[Problem, np.ndarray]:
    """The problem of a log and the numbers of a batch's runs `(BATCH, t)` [SI], the free ones scattered."""
    problem, moves, theta = posed(log(length), with_effects(*added)[0])
    thetas = np.tile(theta, (BATCH, 1))
    thetas[:, moves.index] *= np.exp(SCATTER * np.random.default_rng(0).normal(size=(BATCH, len(moves.index))))
    return problem, thetas


def batched(problem: Problem, theta: np.ndarray) -> Callable[[], np.ndarray]:
    """The call of `rwjax.fitting.batched_runs` for a full batch of runs of one log; it returns readings `(b, w, q, y)`."""
    one = np.zeros(BATCH, int)
    batch, start, windows = problem.batch.of(0), problem.start[one], int(problem.batch.windows_of[0])

    def call() -> np.ndarray:
        y = free_runs(problem.structure, theta, start, windows, batch, solver=problem.solver)
        return y

    return call


def rivals(a: Arrays, theta: np.ndarray) -> dict[str, Callable[[], object]]:
    """The same runs with Coulomb friction, one after the other, by numba and in C; `theta` (b, 3) by `problem.FREE`."""
    first = a.first
    found: dict[str, Callable[[], object]] = {
        "numba, same step": lambda: [scipy_numba.residual(a, numbers, first) for numbers in theta]
    }
    if c_limit.available():
        found["C, same step"] = lambda: [c_limit.residual(a, numbers, first) for numbers in theta]
    return found


def runs(length: float = 60.0, rounds: int = ROUNDS, repeats: int = 5) -> None:
    """Time of a batch by friction, against XLA's programs, numba and C."""
    for friction, added in FRICTIONS.items():
        problem, theta = lanes(length, added)
        call = batched(problem, theta)
        contenders: dict[str, Callable[[], object]] = {OURS: call, XLA: by_xla(call)}
        if not added:
            names = [problem.structure.names.index(name) for name in with_effects()[0].free]
            contenders |= rivals(arrays(log(length)), theta[:, names])
        raced = race(contenders, rounds, repeats=repeats)
        off = np.max(np.abs(raced.results[OURS] - raced.results[XLA]))
        steps = int(problem.batch.windows_of[0]) * len(problem.batch.step_index)
        rows = [
            [
                name,
                seconds(raced.median(name)),
                f"{1e9 * raced.median(name) / steps / BATCH:.3g} ns",
                f"{raced.ratio(name, OURS):.3g}",
                f"{off:.1e} rad" if name == XLA else "",
            ]
            for name in contenders
        ]
        title = f"{BATCH} free runs of {steps} steps, {friction}; {machine()}"
        show(title, ["contender", "median", "per run and step", "times rwjax", "off by"], rows)
