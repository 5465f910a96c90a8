"""The solver that is used where none is passed in: fixed steps in which dry friction holds a resting body exactly."""

from collections.abc import Sequence
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from rwjax.logs.log import Log
from rwjax.plant.plant import Plant
from rwjax.rig.model import Rig
from rwjax.simulation.batch import Batch
from rwjax.simulation.commands import Stretch, each_window, given, whole_log
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.simulation.reading import Slots, readings
from rwjax.simulation.solver import Solver, ThroughWindow
from rwjax.simulation.stepper import Stepper
from rwjax.simulation.windows import prepare, time_grid


class Exact(Solver):
    """Equal steps of a time grid; a resting body stays at rest up to its breakaway level.

    Attributes:
        stepper: What moves the plant over one step.
    """

    name: ClassVar[str] = "exact"
    stepper: Stepper = eqx.field(static=True, default=EXPONENTIAL_STEP)

    def __repr__(self) -> str:
        """The same in every process: a program on disk is named by it."""
        return f"{type(self).__name__}({self.stepper!r})"

    @property
    def from_library(self) -> bool:
        """Whether it is the library's own, with a stepper of the library's."""
        return type(self) is Exact and self.stepper.from_library

    def suited(self, rig: Rig, logs: Sequence[Log]) -> "Exact":
        """Itself: it has nothing to choose."""
        return self

    def through_windows(self, plant: Plant, run: Batch) -> tuple[ThroughWindow, Any]:
        """Equal steps through a window, and its readings between them."""
        h, t0 = time_grid(plant, run)
        moved, acting = prepare(plant, self.stepper, h), given(plant, run)
        m = run.step_index.shape[0]

        def window(x: Float[Array, " n"], part: Stretch) -> tuple[Float[Array, " n"], Float[Array, "q y"]]:
            begin = t0 + h * part.points[0].astype(float)
            steps, at_reading = acting(part)
            states = moved.states(begin, x, steps)
            slots = Slots(at_reading, part.slot_step, part.slot_part).beside(plant, states, steps)
            return jnp.stack([s[m] for s in states]), readings(plant, h, begin, states, slots)

        return window, each_window(run)

    def whole(
        self, plant: Plant, run: Batch, x0: Float[Array, " n"]
    ) -> tuple[Float[Array, "w q y"], Float[Array, "w n"]]:
        """Free run of one log."""
        if plant.age() is not None:
            return self._with_late_readings(plant, run, x0)
        return super().whole(plant, run, x0)

    def beginning(
        self, plant: Plant, run: Batch, x0: Float[Array, " n"], windows: Int[Array, ""]
    ) -> tuple[Float[Array, "w q y"], Float[Array, "w n"]]:
        """The first windows of a free run; where readings are late, those of later windows are there all the same."""
        if plant.age() is not None:
            return self._with_late_readings(plant, run, x0)
        return super().beginning(plant, run, x0, windows)

    def _with_late_readings(self, plant: Plant, run: Batch, x0: Float[Array, " n"]) -> tuple[Array, Array]:
        """Readings of one log, each of which may show another window, and the states at its windows' starts.

        The steps of a window's overlap with the next one are so taken once, not twice.
        """
        h, t0 = time_grid(plant, run)
        part = whole_log(run)
        steps, at_reading = given(plant, run)(part)
        W, m = run.slot_step.shape[0], run.step_index.shape[0]
        states = prepare(plant, self.stepper, h).states(t0, x0, steps)
        slots = Slots(at_reading, part.slot_step, part.slot_part).beside(plant, states, steps)
        y = readings(plant, h, t0, states, slots)
        return y.reshape(W, -1, y.shape[-1]), jnp.stack([s[: W * m : m] for s in states], axis=-1)


EXACT = Exact()
"""The solver that is used where none is passed in."""
