"""A list of friction models, each fitted whole, the best by its error on the held-out runs: BAM's way.

BAM (Duclusaud et al., "Extended friction models for the physics simulation of servo actuators", 2024) fits each of a fixed list of friction
models to training logs by free run, and takes the one with the smallest error on validation logs. Its list has Coulomb and viscous friction,
Stribeck, load-dependent and quadratic terms. It fits by CMA-ES; here the library's own fit takes its place.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax import fit, predict
from rwjax.diagnosis.hypothesis import Hypothesis, candidates, free_names, logged_outputs, space, structure_for
from rwjax.errors import InputError
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.rig.model import Rig

ON_AXIS = (
    ("axis.coulomb",),
    ("axis.coulomb", "axis.viscous"),
    ("axis.stribeck",),
    ("axis.load_friction",),
    ("axis.quadratic_drag",),
)
ON_WHEEL = (("wheel.coulomb",), ("wheel.drag",), ("wheel.coulomb", "wheel.drag"))
FORMS = (".n", ".p")
"""Ends of the names of exponents, which BAM's models hold fixed at 2."""


def squared_error(rig: Rig, logs: Sequence[Log], noise: dict[str, float]) -> float:
    """Squared free-run error of logs in units of the noise, summed [1]; infinite for a run that goes beyond any rig."""
    try:
        runs = [predict(rig, log) for log in logs]
    except InputError:
        return np.inf
    return sum(
        float(np.nansum(((y - run[name]) / noise[name]) ** 2))
        for log, run in zip(logs, runs, strict=True)
        for name, y in log.outputs.items()
    )


def with_friction(rig: Rig, names: tuple[str, ...], train: Sequence[Log]) -> Rig:
    """A rig with a friction model at its starting values, its numbers free."""
    hypothesis = Hypothesis(names)
    structure = structure_for(rig, hypothesis)
    start = dict(zip(structure.names, space(rig, hypothesis, train, 2.0)[1][0], strict=True))
    free = [n for n in free_names(rig, hypothesis, logged_outputs(train)) if not n.endswith(FORMS)]
    effects = {
        e: {n.rpartition(".")[2]: float(v) for n, v in start.items() if n.rpartition(".")[0] == e} for e in names
    }
    return replace(rig, effects=rig.effects | effects, free=tuple(free))


def friction_list(rig: Rig, train: Sequence[Log], held_out: Sequence[Log]) -> tuple[list[str], float]:
    """The friction model with the smallest error on the held-out runs.

    Args:
        rig: The fitted rig as it is.
        train: Logs to fit.
        held_out: Logs that choose.

    Returns:
        Its names, none where the rig as it is does best, and the share of the rig's squared error that it removes [1].
    """
    noise = pooled_noise(tuple(train))
    before, able = squared_error(rig, held_out, noise), {*candidates(rig)}
    best: tuple[list[str], float] = ([], 0.0)
    for model in ON_WHEEL if rig.kind == "wheel" else ON_AXIS:
        names = tuple(n for n in model if n in able)
        if len(names) < len(model) and (not names or names in ON_AXIS):
            continue
        try:
            fitted = fit(with_friction(rig, names, train), train).rig
        except InputError:
            continue
        removed = 1.0 - squared_error(fitted, held_out, noise) / before
        if removed > best[1]:
            best = list(names), removed
    return best
