"""Gains tuned by gradient through the nonlinear closed loop, never closer to instability than asked."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.optimize import minimize

from rwjax.control.closed_loop import closed_loop, loop_setup
from rwjax.control.controller import DEFAULT_TIMING, Controller, LoopTiming
from rwjax.control.loop_polynomial import LoopPolynomial
from rwjax.control.margins import distance_from_minus_one, frequency_responses
from rwjax.control.sampled_loop import SampledLaw, sampled_loops
from rwjax.control.stability import is_stable
from rwjax.errors import InputError
from rwjax.lowering.slopes import with_slopes
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

EFFORT = 1e-3
"""Weight of the command, over its limit or 1 V, against the error, over the step."""
LEAST_MODULUS = 0.5
"""Modulus margin below which no tuned loop goes: the distance from -1 that bears a gain of 2 and a phase of 29°."""
SLACK = 1e-3
"""Modulus margin that is asked for above the least: the search ends a little on either side of what it is asked."""
OF_START = 0.98
"""Share of the start's margin that is kept where the start has less than the least one."""
MULTIPLES = (1.0, 3.0, 10.0, 30.0, 0.3)
"""Multiples of the given gains from the best of which the search begins: where the axis sticks the loss has no slope."""
SHRINKS, GROWS = 100.0, 1e4
"""Times by which a gain may shrink and grow: the most robust one may be hardly more than 0."""
SEARCH = {"maxiter": 60, "ftol": 1e-7}
"""Iterations of the search at most, and the change of the loss, over the start's, at which it ends."""


class Tuned(NamedTuple):
    """Outcome of a tuning.

    Attributes:
        controller: The controller found.
        loss: Loss before and after [s].
        modulus: Modulus margin of its linear loop [1].
        least: Modulus margin that was kept at least [1].
    """

    controller: Controller
    loss: tuple[float, float]
    modulus: float
    least: float


def loss(
    structure: Structure,
    theta: Float[Array, " p"],
    timing: LoopTiming,
    controller: Controller,
    reference: Float[Array, " s"],
    sign: Scalar | float,
) -> Array:
    r"""Time-weighted error and command of a step response from rest [s].

    $\frac1T\int t\,(e/A)^2 + \rho\,(u/u_m)^2\,dt$ for a step of the reference to A. Late errors weigh more, since friction makes
    errors that stay. The command has a price, so that noise is not fed through.

    Args:
        structure: Structure of the plant.
        theta: Parameter vector of that structure, `(p,)` [SI].
        timing: When the controller reads and acts, the rig's own delays included.
        controller: Gains and limits.
        reference: Angle that is wanted [rad] at the controller's samples, `(s,)`.
        sign: Sign of the plant [1], with which positive gains restore.

    Returns:
        The loss [s].
    """
    run = closed_loop(structure, theta, timing, controller, reference, jnp.zeros(len(structure.states)), sign)
    time = timing.period * jnp.arange(len(reference)).astype(float)
    error = (reference - run.angle) / reference[-1]
    most = jnp.where(jnp.isfinite(controller.voltage_limit), controller.voltage_limit, 1.0)
    return jnp.mean(time * error**2 + EFFORT * (run.command / most) ** 2)


def loss_and_gradient(
    structure: Structure,
    theta: Float[Any, " p"],
    timing: LoopTiming,
    controller: Controller,
    reference: Float[Any, " s"],
    sign: Scalar | float,
    logs: Float[Any, " g"],
    free: Float[Any, "g 3"],
) -> tuple[float, Float[np.ndarray, " g"]]:
    """Loss [s] and its gradient by the logarithms of the free gains, through stick, slip and limits.

    Args:
        structure: Structure of the plant.
        theta: Parameter vector of that structure, `(p,)` [SI].
        timing: When the controller reads and acts, the rig's own delays included.
        controller: Filter, feed-forward and limits; its gains are replaced.
        reference: Angle that is wanted [rad] at the controller's samples, `(s,)`.
        sign: Sign of the plant [1].
        logs: Logarithms of the free gains [1], `(g,)`.
        free: Which of kp, ki, kd each free gain is [1], rows of the unit matrix, `(g, 3)`.

    Returns:
        Loss [s], and its gradient [s], `(g,)`.
    """
    arrays = [np.asarray(a, float) for a in (theta, controller, reference, sign, free)]
    of = partial(_of_logs, structure, timing)
    found = with_slopes("tuned_loss", (structure, timing), of, np.asarray(logs), arrays, structure.from_library)
    if found is None:
        (value,), (slope,) = _with_slope(structure, timing, logs, *arrays)
    else:
        (value,), (slope,) = found
    return float(value), np.asarray(slope)


def _of_logs(
    structure: Structure,
    timing: LoopTiming,
    logs: Float[Array, " g"],
    theta: Float[Array, " p"],
    controller: Float[Array, " c"],
    reference: Float[Array, " s"],
    sign: Scalar,
    free: Float[Array, "g 3"],
) -> tuple[Array]:
    """Loss by the logarithms of the free gains, all that is known as arrays."""
    kp, ki, kd = jnp.exp(logs) @ free
    law = Controller(*controller)._replace(kp=kp, ki=ki, kd=kd)
    return (loss(structure, theta, timing, law, reference, sign),)


@partial(jax.jit, static_argnums=(0, 1))
def _with_slope(structure: Structure, timing: LoopTiming, logs: Array, *arrays: Array) -> tuple:
    """`_of_logs` and its derivative by a program of XLA."""
    of = partial(_of_logs, structure, timing)
    return of(logs, *arrays), jax.jacfwd(of)(logs, *arrays)


def tune_from(
    rig: Rig,
    start: Controller,
    reference: Float[np.ndarray, " s"],
    timing: LoopTiming = DEFAULT_TIMING,
    least_modulus: float = LEAST_MODULUS,
    progress: Callable[[str], None] = lambda text: None,
) -> Tuned:
    """Gains with the least `loss` along a step, from those of a controller or the best of `MULTIPLES` of them.

    Sequential quadratic programming in the logarithms of the gains, under the condition that the linear loop as it runs
    keeps a modulus margin. Gains that are 0 stay 0. The encoder reads the angle itself while tuning: a count has no slope.

    Args:
        rig: The rig.
        start: Gains from which the search begins, with filter, feed-forward and limits.
        reference: Step that is wanted [rad] at the controller's samples, `(s,)`.
        timing: When the controller reads and acts.
        least_modulus: Modulus margin that is kept [1], or `OF_START` of the start's where that is less.
        progress: Hears of every step of the search, in words.

    Returns:
        The controller found, its loss and its margin.

    Raises:
        InputError: As `loop_setup` does, for gains that are negative or all 0, and for a start that is not stable.

    Source:
        Kraft, DFVLR-FB 88-28 (1988), the optimiser.
    """
    structure, theta, delayed, sign = loop_setup(rig, timing, start)
    gains = np.array([start.kp, start.ki, start.kd], float)
    if np.any(gains < 0.0) or not np.any(gains > 0.0):
        raise InputError(
            "the gains from which the tuning starts have to be positive, one of them at least; ask for more"
        )
    margin = _margin_of(rig, timing, start)
    if margin.modulus(gains) < 0.0:
        raise InputError("the loop is not stable with the gains from which the tuning starts; take some of its region")
    least = min(least_modulus, OF_START * margin.modulus(gains))
    free = np.eye(3)[gains > 0.0]
    values = Controller(*(jnp.asarray(float(v)) for v in start))
    smooth = delayed._replace(counts=0)
    of_logs = partial(loss_and_gradient, structure, theta, smooth, values, jnp.asarray(reference), sign)
    progress("tuning through the closed loop")
    before = float(of_logs(jnp.log(gains[gains > 0.0]), jnp.asarray(free))[0])
    if not np.isfinite(before):
        raise InputError(
            "the loop leaves the range of numbers with the gains from which the tuning starts; ask for less"
        )
    starts = [np.log(m * gains[gains > 0.0]) for m in MULTIPLES if margin.modulus(m * gains) >= least]
    objective = _Objective(of_logs, jnp.asarray(free), before)
    share, best = _search(objective, lambda logs: margin.modulus(np.exp(logs) @ free) - least, starts, progress)
    kp, ki, kd = (float(v) for v in np.exp(best) @ free)
    tuned = start._replace(kp=kp, ki=ki, kd=kd)
    return Tuned(tuned, (before, before * share), margin.modulus(np.array([kp, ki, kd])), least)


class _Margin(NamedTuple):
    """A linear loop as it runs, its open loop's frequency response by each gain, and which of kp, ki, kd it has."""

    loop: LoopPolynomial
    responses: np.ndarray
    used: list[int]

    def modulus(self, gains: np.ndarray) -> float:
        """Modulus margin [1] at gains kp, ki, kd; -1 where the loop is not stable."""
        own = gains[self.used]
        return distance_from_minus_one(self.responses, *own) if is_stable(self.loop, *own) else -1.0


def _margin_of(rig: Rig, timing: LoopTiming, controller: Controller) -> _Margin:
    """The linear loop of a rig under a controller's law, its gains left open."""
    integral = bool(controller.ki > 0.0)
    (loop,) = sampled_loops(rig, SampledLaw(timing, float(controller.filter_time), integral))
    return _Margin(loop, frequency_responses(loop), [0, 1, 2] if integral else [0, 2])


@dataclass(frozen=True)
class _Objective:
    """Loss over the start's by the logarithms of the free gains; keeps what was tried."""

    of_logs: Callable
    free: Array
    before: float
    tried: list[tuple[float, np.ndarray]] = field(default_factory=list)

    def __call__(self, logs: np.ndarray) -> tuple[float, np.ndarray]:
        value, slope = self.of_logs(jnp.asarray(logs), self.free)
        self.tried.append((float(value) / self.before, logs.copy()))
        return float(value) / self.before, np.asarray(slope) / self.before


def _search(
    objective: _Objective,
    spare: Callable[[np.ndarray], float],
    starts: list[np.ndarray],
    progress: Callable[[str], None],
) -> tuple[float, np.ndarray]:
    """The least objective that was tried with `spare` margin, and where, from the best of some starts."""
    logs = min(starts, key=lambda logs: objective(logs)[0])
    steps, most = itertools.count(1), SEARCH["maxiter"]

    def told(*_: object) -> None:  # the end of the last step begins no other
        progress(f"tuning through the closed loop: step {min(next(steps), most)} of {most} at most")

    told()
    minimize(
        objective,
        logs,
        jac=True,
        method="SLSQP",
        bounds=[(x - np.log(SHRINKS), x + np.log(GROWS)) for x in logs],
        constraints=[{"type": "ineq", "fun": lambda logs: spare(logs) - SLACK}],
        options=SEARCH,
        callback=told,
    )
    kept = sorted((one for one in objective.tried if np.isfinite(one[0])), key=lambda one: one[0])
    return next((x, logs) for x, logs in kept if spare(logs) >= 0.0)
