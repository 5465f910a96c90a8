"""What a free run costs in the program that plants share, beside a rig's own: with all light effects, and with each of them."""

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from experiments.speed.diagnosis import CASES, write
from experiments.speed.table import ROUNDS, machine, race, show
from rwjax.fitting.batched_runs import BATCH
from rwjax.fitting.problem import Problem, pose
from rwjax.logs.driven import driven
from rwjax.logs.read import read_logs
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.rig.read import read_rig
from rwjax.simulation.free_run import free_runs
from rwjax.simulation.shared_program import with_light_effects

OWN, SHARED = "its own", "shared"
RIGS = ("platform, nothing", "reaction, nothing", "wheel, Coulomb friction", "servo, its load")
"""Cases of `experiments.speed.diagnosis`, one of each kind with one axis."""


def posed(case: str) -> tuple[Rig, Problem]:
    """A case's rig, and the problem of its first log."""
    with tempfile.TemporaryDirectory() as folder:
        first, *_ = write(CASES[case], Path(folder))
        rig = read_rig(Path(folder) / "rig.toml")
        rig, logs = driven(rig, read_logs([Path(folder) / first], rig))
    return rig, pose(structure_of(rig), logs)


def runs_of(rig: Rig, problem: Problem, structure: Structure) -> np.ndarray:
    """Readings of a full batch of runs by a structure with further effects, which are at their nulls `(b, w, q, y)`."""
    theta = np.tile(theta_of(rig, structure), (BATCH, 1))
    batch, start = problem.batch.of(0).with_own_numbers(theta.shape[1]), np.tile(problem.start[0], (BATCH, 1))
    return free_runs(structure, theta, start, int(problem.batch.windows_of[0]), batch, solver=problem.solver)


def calls(case: str) -> tuple[Problem, dict[str, Callable[[], np.ndarray]]]:
    """The problem of a case, and its runs by its own program, by the shared one, and with each light effect alone."""
    rig, problem = posed(case)
    own = problem.structure
    every = with_light_effects(own)
    alone = {name: own.with_effects(name) for name in every.effects if name not in own.effects}
    structures = {OWN: own, SHARED: every} | alone
    return problem, {name: partial(runs_of, rig, problem, structure) for name, structure in structures.items()}


def shared(cases: tuple[str, ...] = RIGS, rounds: int = ROUNDS, repeats: int = 5) -> None:
    """Time of a run and step by kind of rig."""
    rows = []
    for case in cases:
        problem, contenders = calls(case)
        raced = race(contenders, rounds, repeats=repeats)
        steps = int(problem.batch.windows_of[0]) * len(problem.batch.step_index) * BATCH
        costliest = max(contenders.keys() - {OWN, SHARED}, key=lambda name: raced.ratio(name, OWN))
        of_step = [f"{1e9 * raced.median(name) / steps:.3g} ns" for name in (OWN, SHARED)]
        ratios = [f"{raced.ratio(name, OWN):.2f}" for name in (SHARED, costliest)]
        off = np.max(np.abs(raced.results[SHARED] - raced.results[OWN]))
        rows.append([case, *of_step, *ratios, costliest, f"{off:.1e}"])
    head = ["rig", "per run and step, own", "shared", "ratio", "of one light effect at most", "which", "off by"]
    show(f"{BATCH} free runs by a program that plants share; {machine()}", head, rows)
