"""Next experiment: among commands that the rig can run, the one on which the rivals differ most beside their error."""

from collections.abc import Sequence

import numpy as np

from rwjax.diagnose.explanation import Explanation
from rwjax.diagnose.refit import Refits
from rwjax.fit.problem import Problem, pose
from rwjax.log import Log
from rwjax.predict import by_sample
from rwjax.simulate import free_run

LENGTH_S, TICK_S = 20.0, 0.01


def commands(top: float) -> dict[str, np.ndarray]:
    """Commands [V] within `top` volts, 20 s at 100 Hz, each starting at 0, by a sentence that tells how to run it."""
    t = np.arange(0.0, LENGTH_S, TICK_S)
    on = t > 0.5
    period = np.mod(t - 0.5, 8.0) / 8.0
    triangle = 1.0 - 4.0 * np.abs(np.mod(period + 0.25, 1.0) - 0.5)
    stairs = np.linspace(0.0, 1.0, 9)[np.minimum((np.mod(t, 10.0) / 10.0 * 9).astype(int), 8)]
    sweep = np.sin(2.0 * np.pi * (0.1 * t + 0.5 * (4.0 - 0.1) / LENGTH_S * t**2))
    levels = {
        f"a slow triangle between -{top:.3g} and {top:.3g} V with a period of 8 s": top * triangle,
        f"a slow triangle between -{top / 3:.3g} and {top / 3:.3g} V with a period of 8 s": top / 3 * triangle,
        f"a staircase of 1.1 s steps from 0 to {top:.3g} V and, after 10 s, to -{top:.3g} V": top
        * stairs
        * np.where(t < 10.0, 1.0, -1.0),
        f"{top:.3g} V for 8 s, then 0 V until standstill (coast-down)": np.where(t < 8.5, top, 0.0),
        f"{top / 2:.3g} V for 8 s, then 0 V until standstill (coast-down)": np.where(t < 8.5, top / 2, 0.0),
        f"a square wave between -{top:.3g} and {top:.3g} V with a period of 4 s": top * np.sign(np.sin(np.pi / 2 * t)),
        f"a square wave between 0 and {top:.3g} V with a period of 2 s": np.where(np.mod(t, 2.0) < 1.0, top, 0.0),
        f"a sine sweep of {0.6 * top:.3g} V from 0.1 to 4 Hz": 0.6 * top * sweep,
    }
    return {name: np.where(on, u, 0.0) for name, u in levels.items()}


def plans_for(problem: Problem, train: Sequence[int]) -> dict[str, np.ndarray]:
    """Commands within what the logs hold; of a two-axis rig on one motor alone, and on one while the other sweeps."""
    top = np.max([np.max(np.abs(problem.logs[k].command), axis=0) for k in train], axis=0)
    if top.ndim == 0:
        return commands(float(top))
    found: dict[str, np.ndarray] = {}
    for one, other in ((0, 1), (1, 0)):
        sweep, u = list(commands(float(top[other])).items())[-1]
        for name, v in commands(float(top[one])).items():
            alone, both = np.zeros((len(v), 2)), np.zeros((len(v), 2))
            alone[:, one] = both[:, one] = v
            both[:, other] = u
            found[f"motor {one + 1} with {name}"] = alone
            found[f"motor {one + 1} with {name} and motor {other + 1} with {sweep}"] = both
    return found


def propose(refits: Refits, rivals: list[Explanation], left: dict[str, float]) -> str:
    """Sentence that names the most telling command, and by how much the first two rivals differ on it.

    `left`: RMS error [SI] by output that the rivals leave on the logs they were judged on; a difference below it tells
    nothing.
    """
    problem = refits.problem
    outputs = sorted({name for k in refits.train for name in problem.logs[k].outputs})
    plans = plans_for(problem, refits.train)
    t = np.arange(0.0, LENGTH_S, TICK_S)
    logs = [
        Log(
            name=name,
            time=t,
            command=u,
            outputs={y: np.zeros_like(t) for y in outputs},
            resolution={y: 0.0 for y in outputs},
            notes={},
            validate=False,
            supply=None,
            origin=0.0,
        )
        for name, u in plans.items()
    ]
    error = {name: max(noise, left.get(name, 0.0)) for name, noise in problem.noise.items()}
    runs = []
    for rival in rivals[:2]:
        structure = refits.problem_of(rival).structure
        plan = pose(structure, logs, error)
        y, _ = free_run(structure, refits(rival).theta, np.zeros_like(plan.start), plan.batch)
        weighed = np.asarray(y) * plan.batch.weight
        runs.append(np.stack([by_sample(plan.batch, k, weighed[k], len(t)) for k in range(len(logs))]))
    telling = np.sqrt(np.mean((runs[0] - runs[1]) ** 2, axis=(1, 2)) * len(outputs))
    best = int(np.argmax(telling))
    names = " and ".join(" + ".join(r.names) for r in rivals[:2])
    if telling[best] < 1.0:
        top = max(float(np.max(np.abs(u))) for u in plans.values())
        return f"no command within {top:.3g} V separates {names}: there they are the same thing for this rig"
    return f"run {logs[best].name}: there {names} differ by {telling[best]:.1f} times the error that is left"
