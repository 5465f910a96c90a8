"""Gains tuned by gradient through the nonlinear closed loop, from a start in the region, never closer to instability than asked."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.optimize import minimize

from rwjax.control.closed_loop import Controller, LoopTiming, closed_loop, posed
from rwjax.control.margins import nearest, on_circle, sampled_modulus
from rwjax.control.region import Loop
from rwjax.control.sampled_loop import running_loops
from rwjax.errors import InputError
from rwjax.plant.one_axis import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

EFFORT = 1e-3
"""Weight of the command, over its limit or 1 V, against the error, over the step."""
LEAST = 0.5
"""Modulus margin below which no tuned loop goes: the distance from -1 that bears a gain of 2 and a phase of 29°."""
SLACK = 1e-3
"""Modulus margin that is asked for above the least: the search ends a little on either side of what it is asked."""
MULTIPLES = (1.0, 3.0, 10.0, 30.0, 0.3)
FAR = (100.0, 1e4)
"""Times by which a gain may shrink and grow: the most robust one may be hardly more than 0."""


class Tuned(NamedTuple):
    """The `controller` found, `loss` before and after, the `modulus` margin of its linear loop and the `least` that was kept."""

    controller: Controller
    loss: tuple[float, float]
    modulus: float
    least: float


def loss(
    structure: Structure,
    theta: Float[Array, " p"],
    clockwork: LoopTiming,
    controller: Controller,
    reference: Float[Array, " s"],
    sign: Scalar | float,
) -> Array:
    r"""$\frac1T\int t\,(e/A)^2 + \rho\,(u/u_m)^2\,dt$ over a step of the reference to A from rest: late errors weigh more, since it
    is what stays that friction makes; with the command for a price, so that noise is not fed through."""
    run = closed_loop(structure, theta, clockwork, controller, reference, jnp.zeros(len(structure.states)), sign)
    time = clockwork.period * jnp.arange(len(reference)).astype(float)
    error = (reference - run.angle) / reference[-1]
    most = jnp.where(jnp.isfinite(controller.limit), controller.limit, 1.0)
    return jnp.mean(time * error**2 + EFFORT * (run.command / most) ** 2)


def is_stable(loop: Loop, *gains: float) -> bool:
    """Whether all poles of a sampled loop lie within the unit circle."""
    return bool(np.all(np.abs(1.0 + loop.poles(*gains)) < 1.0))


class Judged(NamedTuple):
    """A controller on many plants: `stable`, the share of them whose loop is, and their worst `modulus` margin, 0 where one is not."""

    stable: float
    modulus: float


def judged(rig: Rig, thetas: Float[np.ndarray, "k p"], clockwork: LoopTiming, controller: Controller) -> Judged:
    """What plants, one for each row of `thetas`, make of a controller in their linear loop as it runs, its integral included."""
    kp, ki, kd = (float(gain) for gain in (controller.kp, controller.ki, controller.kd))
    gains = (kp, ki, kd) if ki > 0.0 else (kp, kd)
    loops = running_loops(rig, clockwork, float(controller.smooth), thetas, integral=ki > 0.0)
    margins = [sampled_modulus(loop, *gains) if is_stable(loop, *gains) else 0.0 for loop in loops]
    return Judged(float(np.mean(np.array(margins) > 0.0)), min(margins))


@partial(jax.jit, static_argnums=(0, 2))
def _slopes(
    structure, theta, clockwork, controller, reference, sign, logs: Float[Array, " g"], free: Float[Array, "g 3"]
):
    """Loss and its gradient by the logarithms of the free gains."""

    def of(logs: Array) -> Array:
        kp, ki, kd = jnp.exp(logs) @ free
        return loss(structure, theta, clockwork, controller._replace(kp=kp, ki=ki, kd=kd), reference, sign)

    return of(logs), jax.jacfwd(of)(logs)


def tune(
    rig: Rig,
    start: Controller,
    reference: Float[np.ndarray, " s"],
    clockwork: LoopTiming = LoopTiming(),  # noqa: B008 (a tuple, which nothing changes)
    least: float = LEAST,
) -> Tuned:
    """Gains with the least `loss` along a step `reference` [rad], from those of a controller or the best of `MULTIPLES` of them,
    since where the axis sticks the loss has no slope; gains that are 0 stay 0.

    Sequential quadratic programming (Kraft 1988) in the logarithms of the gains, the gradient through stick, slip and limits,
    under the condition that the linear loop as it runs keeps a modulus margin of `least`, or of 0.98 of the start's where that has
    less. The encoder reads the angle itself while tuning: a count has no slope. Raises `InputError` as `posed` does, for gains
    that are negative or all 0, and for a start that is not stable.
    """
    structure, theta, delayed, sign = posed(rig, clockwork, start)
    smooth = delayed._replace(counts=0)
    gains = np.array([start.kp, start.ki, start.kd], float)
    if np.any(gains < 0.0) or not np.any(gains > 0.0):
        raise InputError(
            "the gains from which the tuning starts have to be positive, one of them at least; ask for more"
        )
    (loop,) = running_loops(rig, clockwork, float(start.smooth), integral=bool(gains[1] > 0.0))
    used = [0, 1, 2] if gains[1] > 0.0 else [0, 2]
    seen = on_circle(loop)

    def margin(gains: np.ndarray) -> float:
        return nearest(seen, *gains[used]) if is_stable(loop, *gains[used]) else -1.0

    if margin(gains) < 0.0:
        raise InputError("the loop is not stable with the gains from which the tuning starts; take some of its region")
    least = min(least, 0.98 * margin(gains))
    free = np.eye(3)[gains > 0.0]
    values = Controller(*(jnp.asarray(float(v)) for v in start))
    given = partial(_slopes, structure, theta, smooth, values, jnp.asarray(reference), sign)
    before = float(given(jnp.log(gains[gains > 0.0]), jnp.asarray(free))[0])

    if not np.isfinite(before):
        raise InputError(
            "the loop leaves the range of numbers with the gains from which the tuning starts; ask for less"
        )
    tried: list[tuple[float, np.ndarray]] = []

    def at(logs: np.ndarray) -> tuple[float, np.ndarray]:
        value, slope = given(jnp.asarray(logs), jnp.asarray(free))
        tried.append((float(value) / before, logs.copy()))
        return float(value) / before, np.asarray(slope) / before

    def spare(logs: np.ndarray) -> float:
        return margin(np.exp(logs) @ free) - least

    starts = [np.log(factor * gains[gains > 0.0]) for factor in MULTIPLES if margin(factor * gains) >= least]
    logs = min(starts, key=lambda logs: at(logs)[0])
    minimize(
        at,
        logs,
        jac=True,
        method="SLSQP",
        bounds=[(x - np.log(FAR[0]), x + np.log(FAR[1])) for x in logs],
        constraints=[{"type": "ineq", "fun": lambda logs: spare(logs) - SLACK}],
        options={"maxiter": 60, "ftol": 1e-7},
    )
    kept = sorted((one for one in tried if np.isfinite(one[0])), key=lambda one: one[0])
    share, best = next((x, logs) for x, logs in kept if spare(logs) >= 0.0)
    kp, ki, kd = (float(v) for v in np.exp(best) @ free)
    tuned = start._replace(kp=kp, ki=ki, kd=kd)
    return Tuned(tuned, (before, before * share), margin(np.array([kp, ki, kd])), least)
