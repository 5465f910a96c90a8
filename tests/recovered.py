"""Numbers of an effect fitted to logs of the separate simulator, for tests."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.blind.cases import make_case, write_case
from rwjax import read_logs, read_rig
from rwjax.diagnosis.hypothesis import Hypothesis, free_names, logged_outputs
from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.fitting.batched_runs import together
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.initial_state_from_start import fit_from_start
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import scales, sizes_of
from rwjax.fitting.secant import descend, search_point, with_residual
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of


@dataclass(frozen=True)
class Recovered:
    """`value`: fitted numbers by name; `truth`: every number of the simulator; `misfit`: mean square of the residual in units
    of noise, with the effect and, `without`, with the rig's own numbers alone."""

    value: dict[str, float]
    truth: dict[str, float]
    changed: dict[str, float]
    misfit: float
    without: float


def _misfit(found: Fit) -> float:
    return 2.0 * found.cost / found.problem.batch.readings


def recover(kind: str, cause: str, seed: int, amplitude: float = 1.0, effect: str | None = None) -> Recovered:
    """Fit of a rig's free numbers and of `effect` (`cause` unless it is given) to the training logs of a blind case."""
    effect = effect or cause
    case = make_case(kind, cause, seed, amplitude)
    with tempfile.TemporaryDirectory() as folder:
        write_case(case, Path(folder))
        rig = read_rig(Path(folder) / "rig.toml")
        logs = [log for log in read_logs(sorted(Path(folder).glob("*.csv")), rig) if not log.validate]
    structure = structure_of(rig).with_effects(effect)
    names, theta = structure.names, theta_of(rig, structure)
    problem, typical, size = pose(structure, logs), scales(rig, logs), sizes_of(rig, structure, theta, logs)

    def moves(free: tuple[str, ...]):
        return coordinates(theta, np.array([name in free for name in names]), bounds_of(rig, structure), size)

    base = least_squares(problem, moves(rig.free), theta)
    own = {
        name: parameters(BY_NAME[effect])[name.rpartition(".")[2]] for name in names if name.startswith(f"{effect}.")
    }
    free = free_names(rig, Hypothesis((effect,)), logged_outputs(logs))
    found = []
    count = max(len(p.starts) for p in own.values())
    for begin, j in ((begin, j) for begin in (base.theta, theta) for j in range(count)):
        start = begin.copy()
        for name, p in own.items():
            if name in free:
                start[names.index(name)] = p.begin(typical)[j % len(p.starts)]
        found.append(search_point(problem.from_start, moves(free), start, base.start))
    found = together([descend(f, most_steps=4, tolerance=1e-4) for f in together([with_residual(f) for f in found])])
    found = sorted(found, key=lambda f: f.cost)[:3]
    found = together([descend(f, most_steps=25, tolerance=1e-6) for f in found])
    best = min(found, key=lambda f: f.cost)
    best = fit_from_start(least_squares(problem, moves(free), best.theta, start=best.start, most_steps=0))
    changed = case.truth["changed"][cause]
    return Recovered(best.numbers(), case.truth["parameters"], changed, _misfit(best), _misfit(base))
