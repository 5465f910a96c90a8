"""Commands that minimise the time of a manoeuvre, found by optimisation through the plant.

A manoeuvre takes a time T in which the command runs straight between `PIECES` + 1 values; all of these are unknowns. The
derivatives of the plant's motion by every command and by T are exact.
"""

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

from rwjax.control.drive_limits import Limits
from rwjax.control.open_loop import Sliding, Trajectory, open_loop, trajectory
from rwjax.lowering.slopes import with_slopes
from rwjax.plant.structure import Structure
from rwjax.types import Scalar

PIECES = 30
"""Pieces in each of which the command runs straight."""
STEPS = 10
"""Time steps of the plant in one piece of the command."""
REACHED = 1e-4
"""Largest violation of a condition, in its own scale, at which a manoeuvre counts as possible."""
LONGER = (1.0, 1.4)
"""Durations from which the search begins, over the guessed one, until one ends well."""
TRIES = 4
"""Searches at most."""
GAIN = 2e-3
"""Share of the time that a search has to gain for another to go on from there."""
SEARCH = {"maxiter": 200, "ftol": 1e-6}
"""Iterations of a search at most, and the change of the duration, over the guessed one, at which it ends."""
SHORTEST, LONGEST = 1e-2, 1e2
"""Range of the duration, over the guessed one."""
BARELY = 1.0 + 1e-9
"""Share of a limit that counts as within it, so that a start at the limit does."""

Conditions = Callable[[Trajectory, Array], tuple[Array, Array]]
"""What has to be 0 and what must not be negative, of a trajectory and of some numbers, each in its own scale."""


class Task(NamedTuple):
    """Numbers of a search, all of which may be traced.

    Attributes:
        theta: Parameter vector of the plant [SI], `(p,)`.
        limits: What the drive gives.
        numbers: Numbers that the conditions take, `(m,)`.
        start: First state of the plant [SI], `(n,)`.
        duration: Guessed duration [s].
        way: Direction in which the axis slides [1], 1 or -1.
    """

    theta: Float[Array, " p"]
    limits: Limits
    numbers: Float[Array, " m"]
    start: Float[Array, " n"]
    duration: float
    way: float

    def scaled(self, z: Array) -> tuple[Array, Scalar]:
        """Commands and duration from the unknowns of the search.

        Args:
            z: Commands over their limit [1], and the duration over the guessed one [1], `(PIECES + 2,)`.

        Returns:
            Mean command of every time step [V], `(PIECES * STEPS,)`, and the duration [s].
        """
        return self.limits.volts * (jnp.asarray(_interpolation()) @ z[:-1]), self.duration * z[-1]


class Manoeuvre(NamedTuple):
    """What a search for the least time is asked; static, it decides the shape of the computation.

    Attributes:
        structure: Structure of the plant.
        conditions: What the trajectory has to meet.
        slides_from: Piece of the command from which on the search takes the axis to slide [1].
    """

    structure: Structure
    conditions: Conditions
    slides_from: int


class Guess(NamedTuple):
    """Where a search begins.

    Attributes:
        commands: Commands [V], `(PIECES + 1,)`.
        torque_voltage: Part of a command that makes the torque [V]; the scale in which commands are searched.
    """

    commands: Float[np.ndarray, " c"]
    torque_voltage: float


def minimum_time(
    manoeuvre: Manoeuvre, task: Task, guess: Guess, progress: Callable[[str], None] = lambda text: None
) -> tuple[Trajectory, float]:
    """The trajectory of least time within the limits that meets the conditions.

    The search takes the axis to slide from some piece of the command on. What it ends with is judged on the plant, which may stick.
    The best that was met on the way is kept, the guess included, and the search goes on from there.

    Args:
        manoeuvre: What is asked.
        task: Its numbers.
        guess: Where the search begins.
        progress: Hears of every step of the search, in words.

    Returns:
        The trajectory, and how far it violates the conditions [1]; 0 where it meets them.

    Source:
        Kraft, DFVLR-FB 88-28 (1988), sequential quadratic programming.
    """
    search = _Search.of(manoeuvre, task, guess)
    clipped = np.clip(guess.commands / task.limits.volts, -1.0, 1.0)
    first, *others = [np.append(clipped, longer) for longer in LONGER]
    best, start, searched = search.judged(first), first, False
    for k in range(TRIES):
        ended = search.run(start, lambda step, k=k: progress(_step_words(k, step)))
        new = min((search.judged(z) for z in (ended, *search.met[-1:])), key=lambda found: found[:2])
        gained = new.missed < best.missed or (new.missed == best.missed and new.time < (1.0 - GAIN) * best.time)
        best = min(best, new, key=lambda found: found[:2])
        searched = searched or (gained and best.missed <= REACHED)
        if gained and best.missed <= REACHED:
            start = best.z
        elif others and not searched:
            start = others.pop()
        else:
            break
    return best.trajectory, best.missed if best.missed > REACHED else 0.0


def _step_words(k: int, step: int) -> str:
    """How far a search is, in words; the searches before it are `k`. The end of its last step begins no other."""
    most = SEARCH["maxiter"]
    return f"looking for the least time: search {k + 1} of {TRIES} at most, step {min(step, most)} of {most} at most"


class _Found(NamedTuple):
    """A trajectory, how far it violates the conditions (`REACHED` where it counts as possible), its time [s] and unknowns."""

    missed: float
    time: float
    z: np.ndarray
    trajectory: Trajectory


@dataclass(frozen=True)
class _Search:
    """A search for the least time, its unknowns `y` = z / scale; `met`: unknowns that met the conditions, each quicker than before."""

    manoeuvre: Manoeuvre
    task: Task
    scale: np.ndarray
    known: dict[bytes, Any] = field(default_factory=dict)
    met: list[np.ndarray] = field(default_factory=list)

    @classmethod
    def of(cls, manoeuvre: Manoeuvre, task: Task, guess: Guess) -> "_Search":
        """A search whose commands are scaled by what makes the torque."""
        return cls(
            manoeuvre,
            task,
            np.append(np.full(PIECES + 1, min(guess.torque_voltage / task.limits.volts, 1.0)), 1.0),
        )

    def at(self, y: np.ndarray) -> tuple:
        """Conditions and their derivatives by z; those of the last unknowns are kept."""
        key = y.tobytes()
        if key not in self.known:
            self.known.clear()
            z = self.scale * y
            found = _with_slopes(self.manoeuvre, self.task, z)
            if _missed(*found[0]) <= REACHED and (not self.met or z[-1] < self.met[-1][-1]):
                self.met.append(z)
            self.known[key] = found
        return self.known[key]

    def judged(self, z: np.ndarray) -> _Found:
        """What the plant, which may stick, makes of unknowns."""
        z = np.append(np.clip(z[:-1], -1.0, 1.0), z[-1])
        found = open_loop(self.manoeuvre.structure, self.task.theta, *self.task.scaled(jnp.asarray(z)), self.task.start)
        missed = _missed(*_judged(self.manoeuvre.conditions, self.task, found))
        return _Found(max(missed, REACHED), float(found.time[-1]), z, found)

    def run(self, start: np.ndarray, told: Callable[[int], None]) -> np.ndarray:
        """Unknowns z with which the optimiser ends, from a start; it tells the number of every step that begins, from 1."""
        count, scale, steps = PIECES + 1, self.scale, itertools.count(2)
        told(1)
        last = np.eye(count + 1)[count]
        constraints = [
            {"type": "eq", "fun": lambda y: self.at(y)[0][0], "jac": lambda y: self.at(y)[1][0] * scale},
            {"type": "ineq", "fun": lambda y: self.at(y)[0][1], "jac": lambda y: self.at(y)[1][1] * scale},
        ]
        ended = minimize(
            lambda y: (y[count], last),
            start / scale,
            jac=True,
            method="SLSQP",
            bounds=[(-1.0 / s, 1.0 / s) for s in scale[:count]] + [(SHORTEST, LONGEST)],
            constraints=constraints,
            options=SEARCH,
            callback=lambda y: told(next(steps)),
        ).x
        return scale * ended


def _judged(conditions: Conditions, task: Task, found: Trajectory) -> tuple[Array, Array]:
    """The conditions, the limits of wheel rate and current among them."""
    zero, positive = conditions(found, task.numbers)
    held = ((found.wheel, task.limits.top), (found.current, task.limits.amps))
    within = [least_in_pieces(BARELY - (x / most) ** 2) for x, most in held]
    return zero, jnp.concatenate([positive, *within])


def _outcome(
    structure: Structure, conditions: Conditions, slides_from: int, task: Task, z: Array
) -> tuple[Array, Array]:
    """The conditions of the trajectory that belongs to unknowns."""
    commands, duration = task.scaled(z)
    sliding = Sliding(slides_from * STEPS, jnp.asarray(task.way))
    found = trajectory(structure, task.theta, commands, duration, task.start, sliding)
    return _judged(conditions, task, found)


def _with_slopes(manoeuvre: Manoeuvre, task: Task, z: np.ndarray) -> tuple:
    """The conditions and their derivatives by the unknowns."""
    leaves, tree = jax.tree.flatten(task)
    arrays = [np.asarray(leaf, float) for leaf in leaves]

    def of(z: Array, *arrays: Array) -> tuple[Array, Array]:
        return _outcome(*manoeuvre, jax.tree.unflatten(tree, arrays), z)

    structure, conditions, slides_from = manoeuvre
    key = (structure, conditions.__module__, conditions.__qualname__, slides_from)
    found = with_slopes("manoeuvre", key, of, z, arrays, structure.from_library)
    return jax.tree.map(np.asarray, _by_xla(*manoeuvre, task, z)) if found is None else found


@partial(jax.jit, static_argnums=(0, 1, 2))
def _by_xla(structure: Structure, conditions: Conditions, slides_from: int, task: Task, z: Array) -> tuple:
    """The same by a program of XLA."""
    one = partial(_outcome, structure, conditions, slides_from, task)
    return one(z), jax.jacfwd(one)(z)


def _missed(zero: Array | np.ndarray, positive: Array | np.ndarray) -> float:
    """How far conditions are violated, infinitely where one is no number."""
    most = np.max(np.concatenate([np.abs(zero), -np.asarray(positive), np.zeros(1)]))
    return float(np.where(np.isnan(most), np.inf, most))


def _interpolation() -> Float[np.ndarray, "s c"]:
    """Mean commands of the time steps by the values between which the command runs straight."""
    at = (np.arange(PIECES * STEPS) + 0.5) / STEPS
    return np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(PIECES + 1)))


def least_in_pieces(values: Float[Array, " t"]) -> Float[Array, " c"]:
    """The least value in each piece of the command, both its ends included.

    Args:
        values: Values at the times of a trajectory [1], `(PIECES * STEPS + 1,)`.

    Returns:
        The least of each piece [1], `(PIECES,)`.
    """
    inside = values[:-1].reshape(PIECES, STEPS).min(axis=1)
    return jnp.minimum(inside, values[STEPS::STEPS])
