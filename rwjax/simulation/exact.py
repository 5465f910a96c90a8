"""The solver that is used where none is passed in: fixed steps in which dry friction holds a resting body exactly."""

from collections.abc import Callable, Sequence
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from rwjax.logs.log import Log
from rwjax.plant.plant import Plant
from rwjax.rig.model import Rig
from rwjax.simulation.batch import Batch
from rwjax.simulation.commands import commands
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.simulation.reading import Slots, readings
from rwjax.simulation.solver import Solver
from rwjax.simulation.stepper import Stepper
from rwjax.simulation.windows import prepare, time_grid
from rwjax.types import Scalar


class Exact(Solver):
    """Equal steps of a time grid; a resting body stays at rest up to its breakaway level.

    Attributes:
        stepper: What moves the plant over one step.
    """

    name: ClassVar[str] = "exact"
    stepper: Stepper = eqx.field(static=True, default=EXPONENTIAL_STEP)

    @property
    def from_library(self) -> bool:
        """Whether it is the library's own, with a stepper of the library's."""
        return type(self) is Exact and self.stepper.from_library

    def suited(self, rig: Rig, logs: Sequence[Log]) -> "Exact":
        """Itself: it has nothing to choose."""
        return self

    def whole(
        self, plant: Plant, run: Batch, x0: Float[Array, " n"]
    ) -> tuple[Float[Array, "w q y"], Float[Array, "w n"]]:
        """Free run of one log."""
        if plant.age() is not None:
            return self._with_late_readings(plant, run, x0)
        window, inputs = self._window_by_window(plant, run)
        return jax.lax.scan(window, x0, inputs)[1]

    def beginning(
        self, plant: Plant, run: Batch, x0: Float[Array, " n"], windows: Int[Array, ""]
    ) -> Float[Array, "w q y"]:
        """The first windows of a free run; readings of later ones are 0, or are there all the same."""
        if plant.age() is not None:
            return self._with_late_readings(plant, run, x0)[0]
        window, inputs = self._window_by_window(plant, run)

        def one(w: Int[Array, ""], carry: tuple[Array, Array]) -> tuple[Array, Array]:
            x, y = carry
            x, (seen, _) = window(x, tuple(a[w] for a in inputs))
            return x, y.at[w].set(seen)

        W, q = run.slot_step.shape
        nothing = jnp.zeros((W, q, len(plant.structure.outputs)))
        return jax.lax.fori_loop(0, windows, one, (x0, nothing))[1]

    def windows(
        self, plant: Plant, run: Batch, nodes: Float[Array, "w n"]
    ) -> tuple[Float[Array, "w q y"], Float[Array, "w n"]]:
        """Every window of one log from a first state of its own, all side by side."""
        h, t0 = time_grid(plant, run)
        moved = prepare(plant, self.stepper, h)
        steps, at_reading = commands(plant, run)
        W, m = run.slot_step.shape[0], run.step_index.shape[0]
        u = steps[np.add.outer(m * np.arange(W), np.arange(m + len(run.overlap_index)))]

        def one(w: Scalar, x0: Array, u: Array, slots: Slots) -> tuple[Array, Array]:
            begin = t0 + w * m * h
            states = moved.states(begin, x0, u)
            y = readings(plant, h, begin, states, slots)
            return y, jnp.stack([s[m] for s in states])

        slots = Slots(at_reading, jnp.asarray(run.slot_step), jnp.asarray(run.slot_part))
        return jax.vmap(one)(jnp.arange(W, dtype=float), nodes, u, slots)

    def _window_by_window(self, plant: Plant, run: Batch) -> tuple[Callable, tuple]:
        """What goes through a window, from its first state and its inputs, to its end; and the inputs of all windows."""
        h, t0 = time_grid(plant, run)
        moved = prepare(plant, self.stepper, h)
        steps, at_reading = commands(plant, run)
        W, m = run.slot_step.shape[0], run.step_index.shape[0]

        def window(x: Float[Array, " n"], inputs: tuple) -> tuple[Float[Array, " n"], tuple[Array, Array]]:
            w, u, *slots = inputs
            begin = t0 + w * m * h
            states = moved.states(begin, x, u)
            y = readings(plant, h, begin, states, Slots(*slots))
            return jnp.stack([s[-1] for s in states]), (y, x)

        slots = jnp.asarray(run.slot_step), jnp.asarray(run.slot_part)
        return window, (jnp.arange(W, dtype=float), steps.reshape(W, m, *steps.shape[1:]), at_reading, *slots)

    def _with_late_readings(self, plant: Plant, run: Batch, x0: Float[Array, " n"]) -> tuple[Array, Array]:
        """Readings of one log, each of which may show another window, and the states at its windows' starts."""
        h, t0 = time_grid(plant, run)
        steps, at_reading = commands(plant, run)
        slot_step, slot_part = jnp.asarray(run.slot_step), jnp.asarray(run.slot_part)
        W, m = slot_step.shape[0], run.step_index.shape[0]
        states = prepare(plant, self.stepper, h).states(t0, x0, steps)
        at = (m * jnp.arange(W)[:, None] + slot_step).ravel()
        slots = Slots(at_reading.reshape(at.size, *at_reading.shape[2:]), at, slot_part.ravel())
        y = readings(plant, h, t0, states, slots)
        return y.reshape(W, -1, y.shape[-1]), jnp.stack([s[: W * m : m] for s in states], axis=-1)


EXACT = Exact()
"""The solver that is used where none is passed in."""
