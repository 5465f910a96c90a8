r"""One time step: the linear part exactly, the rest to second order, dry friction with exact stick.

With $A$ the Jacobian of the plant's smooth field at rest and $N(x) = f(x) - A x$,

$a = e^{hA} x + h\varphi_1(hA) N(x), \qquad x^+ = a + h\varphi_2(hA)\,[N(a) - N(x)]$

(exponential Runge-Kutta of second order; Cox and Matthews, J. Comput. Phys. 176 (2002), eq. 22), so that a linear plant,
a short electrical time constant included, is solved exactly under a held input. Dry friction adds to $f$: a sliding body
feels its level against the direction in which it slid at the start of the step; a resting body feels exactly the
friction that keeps it at rest, up to its breakaway level. A body whose speed changes sign within the step stops at the
zero crossing and goes on from there for the rest of the step, or stays. There is no smoothed sign and no width.
"""

from dataclasses import dataclass
from functools import cache
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from rwjax.lowering import program_files
from rwjax.lowering.by_numpy import worked_out
from rwjax.lowering.emitter import Unsupported
from rwjax.plant.assemble import plant_of
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.plant import Command, Plant, SmoothStep
from rwjax.plant.structure import State, Structure
from rwjax.simulation.stepper import SlidingStepper
from rwjax.types import Scalar, entries

TAYLOR_TERMS = 10
"""Terms of the series of the exponential functions, after scaling."""
SQUARINGS = 10
"""Doublings of the scaled step: h |A| up to 2**10 / 4, as of an electrical time constant of 20 us in steps of 5 ms."""

Matrix = tuple[tuple[Scalar, ...], ...]
"""Rows of entries, each an array of its own: of many plants side by side a step reads an entry's values in one piece."""


class Propagator(NamedTuple):
    r"""The linear part of a plant and its exponential functions for one step length.

    Attributes:
        A: Jacobian of the smooth field at rest `(n, n)`.
        E: $e^{hA}$ `(n, n)`.
        phi1: $h\varphi_1(hA)$ `(n, n)`.
        phi2: $h\varphi_2(hA)$ `(n, n)`.
    """

    A: Matrix
    E: Matrix
    phi1: Matrix
    phi2: Matrix


def _propagator(plant: Plant, h: Scalar) -> Propagator:
    r"""$e^{hA}$, $h\varphi_1(hA)$ and $h\varphi_2(hA)$ by scaling and doubling."""
    # an entry that `_couplings` does not see, of an effect with a threshold, stays with the part that is not linear
    direct, reached = _couplings(plant.structure)
    A = jnp.where(direct, linear_part(plant), 0.0)
    return Propagator(_rows(A, direct), *(_rows(M, reached) for M in _exponentials(A, h)))


def _rows(M: Float[Array, "n n"], used: np.ndarray) -> Matrix:
    """Entries of a matrix, those that are not used as 0."""
    every = iter(jax.lax.split(M.ravel(), (1,) * M.size))
    rows = (zip(row, every, strict=False) for row in used)
    return tuple(tuple(jax.lax.squeeze(entry, (0,)) if use else jnp.zeros(()) for use, entry in row) for row in rows)


@jax.jit  # traced once for all plants of as many states
def _exponentials(A: Float[Array, "n n"], h: Scalar) -> tuple[Array, Array, Array]:
    r"""$e^{hA}$, $h\varphi_1(hA)$ and $h\varphi_2(hA)$."""
    z = A * (h / 2.0**SQUARINGS)
    eye = jnp.eye(len(A))

    # phi2(z) = sum z^k / (k+2)!, then phi1 = I + z phi2 ... by their recurrence
    def add(k: Int[Array, ""], phi2: Array) -> Array:
        return eye + (z @ phi2) / (TAYLOR_TERMS + 2.0 - k)

    phi2 = jax.lax.fori_loop(0, TAYLOR_TERMS, add, eye)
    phi2 = phi2 / 2.0
    phi1 = eye + z @ phi2
    E = eye + z @ phi1

    def double(_: Int[Array, ""], p: tuple) -> tuple:
        E, phi1, phi2 = p
        return E @ E, (E @ phi1 + phi1) / 2.0, (E @ phi2 + phi1 + phi2) / 4.0

    E, phi1, phi2 = jax.lax.fori_loop(0, SQUARINGS, double, (E, phi1, phi2))
    return E, h * phi1, h * phi2


@jax.jit  # traced once for a plant's coupling entries and all its programs
def linear_part(plant: Plant) -> Float[Array, "n n"]:
    """Jacobian of the plant's field without dry friction, at rest under no command.

    Args:
        plant: Any plant with `n` states.

    Returns:
        The Jacobian `(n, n)` [SI].
    """
    n = len(plant.structure.states)
    zero, no_command = jnp.zeros(()), plant.no_command()

    def smooth(x: Float[Array, " n"]) -> Float[Array, " n"]:
        return jnp.stack(plant.field(zero, entries(x), no_command))

    return jax.jacfwd(smooth)(jnp.zeros(n))


@cache
def _couplings(structure: Structure) -> tuple[np.ndarray, np.ndarray]:
    """Which entries of the linear part, and of its exponential, count as different from zero: the others are not computed.

    They are those that differ from zero at some generic numbers. They are kept on disk, since a program that is there is not traced.
    """
    path = program_files.file_of("kept", "couplings", structure) if structure.from_library else None
    kept = program_files.read(path)
    if kept is None:
        kept = bytearray((_linear_part_somewhere(structure) != 0.0).tobytes())
        program_files.write(path, kept)
    n = len(structure.states)
    A = np.frombuffer(kept, bool).reshape(n, n)
    return A, np.linalg.matrix_power(np.eye(n, dtype=int) + A, n) > 0


def _linear_part_somewhere(structure: Structure) -> np.ndarray:
    """The linear part at some generic numbers."""
    generic = 0.7 + 0.1 * np.arange(len(structure.names))

    def function(theta: Float[Array, " p"]) -> Array:
        return linear_part(plant_of(structure, theta))

    try:
        return worked_out(jax.make_jaxpr(function)(generic), [generic])[0]
    # reason: an effect of the user's own; compiled ahead, since this is called while another program is traced
    except Unsupported:
        return np.asarray(jax.jit(function).lower(generic).compile()(generic))


def _times(M: Matrix, x: State, used: np.ndarray) -> State:
    terms = [[M[r][c] * x[c] for c in np.flatnonzero(used[r])] for r in range(len(x))]
    return tuple(sum(row[1:], start=row[0]) if row else jnp.zeros_like(x[r]) for r, row in enumerate(terms))


def _add(x: State, y: State) -> State:
    return tuple(a + b for a, b in zip(x, y, strict=True))


def _minus(x: State, y: State) -> State:
    return tuple(a - b for a, b in zip(x, y, strict=True))


class _Begin(NamedTuple):
    """The beginning of a step.

    `start` is the state whose rates give the directions of sliding. The body whose rate stands at the index `sliding`
    slides whatever its speed.
    """

    t: Scalar
    x: State
    u: Command
    h: Scalar
    start: State
    sliding: int | None = None


def _over(plant: Plant, p: Propagator, begin: _Begin) -> State:
    """State at the end of a step."""
    t, x, u, h, start, sliding = begin
    direct, reached = _couplings(plant.structure)
    rates0, torques0 = plant.with_friction(t, x, u, start)
    n0 = _minus(rates0, _times(p.A, x, direct))
    a = plant.deflected(x, _add(_times(p.E, x, reached), _times(p.phi1, n0, reached)), h)
    rates1, torques1 = plant.with_friction(t + h, a, u, start, x)
    n1 = _minus(rates1, _times(p.A, a, direct))
    x1 = _add(a, _times(p.phi2, _minus(n1, n0), reached))
    torques = list(zip(torques0, torques1, strict=True))
    x1 = plant.settle(SmoothStep(t, x, x1, u, h, rates0, torques, sliding))
    return plant.within_limits(plant.deflected(x, x1, h))


def _parts(plant: Plant, t: Scalar, h: Scalar) -> list[tuple[Scalar, Scalar]]:
    """Begin and length [s] of the equal parts into which the plant's effects divide a step."""
    parts = plant.structure.parts_of_step
    return [(t + k * (h / parts), h / parts) for k in range(parts)]


@dataclass(frozen=True)
class ExponentialStep(SlidingStepper):
    """The exponential Runge-Kutta step of second order with exact stick; it has no settings."""

    from_library: ClassVar[bool] = True

    def prepare(self, plant: Plant, h: Scalar) -> Propagator:
        """The linear part of the plant and its exponential functions for a part of the step."""
        return _propagator(plant, h / plant.structure.parts_of_step)

    def step(self, plant: Plant, prepared: Propagator, t: Scalar, x: State, u: Command, h: Scalar) -> State:
        """State after one step, in as many equal parts as the plant's effects need."""
        for begin, part in _parts(plant, t, h):
            x = _over(plant, prepared, _Begin(begin, x, u, part, x))
        return x

    def slide(
        self, plant: OneAxis, prepared: Propagator, t: Scalar, x: State, u: Scalar, h: Scalar, direction: Scalar
    ) -> State:
        """`step` of an axis that slides in a given direction: dry friction neither holds it nor turns with it."""
        w = plant.structure.states.index("w")
        for begin, part in _parts(plant, t, h):
            x = _over(plant, prepared, _Begin(begin, x, u, part, (*x[:w], direction, *x[w + 1 :]), w))
        return x


EXPONENTIAL_STEP = ExponentialStep()
"""The stepper that is used where none is passed in."""
