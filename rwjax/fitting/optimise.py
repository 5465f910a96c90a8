"""Least squares by optimistix over whole free runs, for a solver whose readings are smooth in all numbers.

Unknown are the free numbers, in the coordinates of `rwjax.fitting.coordinates`, and the unknown entries of the initial states.
An initial state may instead follow the numbers along a line, as one that is taken from the start of its run does to first order.
"""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import lineax
import numpy as np
import optimistix
from jaxtyping import Array, Bool, Float, Int

from rwjax.plant.structure import Structure
from rwjax.simulation.batch import Batch
from rwjax.simulation.forward_mode import with_jacobian
from rwjax.simulation.program_cache import stored
from rwjax.simulation.solver import Solver
from rwjax.simulation.windows import plant_of_run

MOST_ITERATIONS = 25
"""Iterations at most from each start."""
DAMPING = 1e-2
"""Damping of the first step [1]."""
GAINED = 0.75
"""Share of the predicted gain above which the damping falls [1]."""
FURTHEST = 2.0
"""Change of a logarithm that a search cannot go beyond [1]: far from its optimum a step may overshoot."""


class _LevenbergMarquardt(optimistix.LevenbergMarquardt):
    """Levenberg-Marquardt whose damping falls after every step that gains most of what was predicted."""

    def __init__(self, tolerance: Any) -> None:
        super().__init__(tolerance, tolerance, linear_solver=lineax.Normal(lineax.Cholesky()))
        self.search = _TrustRegion(high_cutoff=GAINED)


class _TrustRegion(optimistix.ClassicalTrustRegion):
    """A trust region that begins with little damping."""

    def init(self, y: Any, f_info_struct: Any) -> Any:
        """The state at the beginning."""
        return eqx.tree_at(lambda state: state.step_size, super().init(y, f_info_struct), jnp.asarray(1.0 / DAMPING))


class Unknowns(NamedTuple):
    """What a fit may change, and where it begins. Axes: log `l`, state `n`, entry of the parameter vector `t`, free number `k`.

    Attributes:
        theta: Parameter vector at the beginning `(t,)` [SI].
        start: Initial states at the beginning `(l, n)` [SI].
        index: Entries of `theta` that are free `(k,)`.
        logarithmic: Which of them move in their logarithm `(k,)`.
        size: Unit of the others `(k,)` [SI].
        bounds: Lower and upper bound `(k, 2)` [SI].
        start_index: Log and state of each entry of the initial states that is unknown by itself `(f, 2)`.
        response: Change of the initial states by each free number `(l, n, k)` [SI].
        scale: Step of each coordinate, then of each of these entries, that changes the readings by their noise `(m,)`, m = k + f.
    """

    theta: Float[Any, " t"]
    start: Float[Any, "l n"]
    index: Int[Any, " k"]
    logarithmic: Bool[Any, " k"]
    size: Float[Any, " k"]
    bounds: Float[Any, "k 2"]
    start_index: Int[Any, "f 2"]
    response: Float[Any, "l n k"]
    scale: Float[Any, " m"]

    def at(self, z: Float[Array, " m"]) -> tuple[Float[Array, " t"], Float[Array, "l n"]]:
        """Parameter vector and initial states at a point.

        Args:
            z: Steps from the beginning in units of `scale` [1].

        Returns:
            Parameter vector `(t,)` [SI], within its bounds, and initial states `(l, n)` [SI].
        """
        k, step = len(self.index), z * self.scale
        free = self.theta[self.index]
        factor = jnp.exp(FURTHEST * jnp.tanh(step[:k] / FURTHEST))
        moved = jnp.where(self.logarithmic, free * factor, free + self.size * step[:k])
        low, high = self.bounds[:, 0], self.bounds[:, 1]
        # a number on its bound may move inwards: the derivative of `clip` alone is half of that there
        moved = jnp.where((low <= moved) & (moved <= high), moved, jnp.clip(moved, low, high))
        start = jnp.asarray(self.start).at[self.start_index[:, 0], self.start_index[:, 1]].add(step[k:])
        return jnp.asarray(self.theta).at[self.index].set(moved), start + self.response @ (moved - free)


class Optimum(NamedTuple):
    """Where a fit ended; each entry has a first axis of starts `s`.

    Attributes:
        theta: Parameter vector `(s, t)` [SI].
        start: Initial states `(s, l, n)` [SI].
        cost: Half the sum of squares in units of noise, and the prior's share `(s,)` [1]; infinite where no run got to its end.
        steps: Iterations `(s,)` [1].
    """

    theta: Float[Any, "s t"]
    start: Float[Any, "s l n"]
    cost: Float[Any, " s"]
    steps: Int[Any, " s"]


@stored(lambda found: Optimum(*map(np.asarray, found)))
def optimise(
    structure: Structure,
    unknowns: Unknowns,
    weight: Float[Any, "s l w q y"],
    prior: Float[Any, "s t 2"],
    tolerance: Float[Any, ""],
    batch: Batch,
    *,
    solver: Solver,
) -> Any:
    """Least squares from several starts side by side, by the method of Levenberg and Marquardt.

    A run that fails has infinite readings. A step to it is refused, and the next one is shorter.

    Args:
        structure: What the plant is made of.
        unknowns: What may change; every entry has a first axis of starts `s`.
        weight: Inverse noise of the readings for each start `(s, l, w, q, y)` [1/SI], in place of the batch's own.
        prior: Mean [SI] and inverse variance [1/SI²] of each number `(s, t, 2)`, 0 where nothing is known.
        tolerance: Step in units of `Unknowns.scale` below which a search ends [1].
        batch: The logs.
        solver: What moves the plant through a log.

    Returns:
        An `Optimum`.

    Source:
        Moré (1978), The Levenberg-Marquardt algorithm: implementation and theory.
    """

    def one(unknowns: Unknowns, weight: Array, prior: Array) -> tuple:
        unit = jnp.sqrt(jnp.maximum(jnp.sum(weight > 0.0), 1))

        def residual(z: Array) -> Array:
            theta, start = unknowns.at(z)
            y, _ = solver.of_logs(
                lambda run, x0: solver.whole(plant_of_run(structure, theta, run), run, x0), batch, start
            )
            r = jnp.where(weight > 0.0, (y - jnp.asarray(batch.reading)) * weight, 0.0)
            return jnp.append(r.ravel(), jnp.sqrt(prior[:, 1]) * (theta - prior[:, 0])) / unit

        smooth = with_jacobian(residual)
        search = _LevenbergMarquardt(jnp.asarray(tolerance))
        found = optimistix.least_squares(
            lambda z, _: smooth(z), search, jnp.zeros_like(unknowns.scale), max_steps=MOST_ITERATIONS, throw=False
        )
        cost = 0.5 * jnp.sum(found.state.f_info.residual**2) * unit**2
        cost = jnp.where(jnp.isfinite(cost), cost, jnp.inf)
        return *unknowns.at(found.value), cost, found.stats["num_steps"]

    return list(jax.vmap(one)(jax.tree.map(jnp.asarray, unknowns), jnp.asarray(weight), jnp.asarray(prior)))
