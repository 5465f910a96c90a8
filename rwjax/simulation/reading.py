"""Readings of a motion between the grid points of its time steps."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from rwjax.kinds import SERVO
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.plant import Plant
from rwjax.simulation.windows import History
from rwjax.types import Scalar


class Slots(NamedTuple):
    """Where in a window its readings are taken.

    Attributes:
        u: Voltage at every reading `(q,)` or `(q, 2)` [V].
        step: Grid step in which it lies `(q,)`.
        part: Part of that step that has passed `(q,)` [1].
        on: 1 where current can flow `(q,)`, else 0; None where it always can.
    """

    u: Float[Array, "q *channels"]
    step: Int[Array, " q"]
    part: Float[Array, " q"]
    on: Float[Array, " q"] | None = None

    def beside(self, plant: Plant, states: History, given: Any) -> "Slots":
        """The same slots with what a servo gave there, and whether torque was on.

        Args:
            plant: The plant of the run.
            states: For each state its values at the grid points `(m + 1,)`.
            given: What moved the plant over every step, arrays with a first axis of steps `(m, …)`.

        Returns:
            The slots.
        """
        structure, slots = plant.structure, self
        if structure.servo is not None:
            acting = states[structure.states.index(f"{SERVO}:acting")]
            slots = slots._replace(u=acting[self.step + 1])
        return slots._replace(on=jnp.round(given.powered[self.step])) if structure.switched else slots


def readings(plant: Plant, h: Scalar, begin: Scalar, states: History, slots: Slots) -> Float[Array, "q y"]:
    """Outputs at the reading slots of a window, interpolated between its grid points.

    Args:
        plant: The plant of the run.
        h: Length of a step [s].
        begin: Time at which the window begins [s].
        states: For each state its values at the grid points `(m + 1,)`.
        slots: Where the readings are taken.

    Returns:
        Readings `(q, y)` [rad, rad/s or A], in the order of the structure's outputs.
    """
    x, age = _between(plant, h, states, slots.step, slots.part), plant.age()
    seen = x if age is None else _earlier(plant, h, states, slots, age)
    t = begin + h * (slots.step.astype(float) + slots.part)
    if slots.on is not None and isinstance(plant, OneAxis):
        powered = jax.vmap(lambda on, *at: plant.powered(on).outputs(*at))
        return jnp.stack(powered(slots.on, t, x, slots.u, seen), axis=-1)
    return jnp.stack(jax.vmap(plant.outputs)(t, x, slots.u, seen), axis=-1)


def _turning(plant: Plant) -> list[tuple[int, int]]:
    """Indices of each angle and its rate among the states."""
    names = plant.structure.states
    return [(names.index(angle), names.index(rate)) for angle, rate, *_ in plant.structure.turning]


def _between(plant: Plant, h: Scalar, states: History, step: Int[Array, " q"], part: Float[Array, " q"]) -> History:
    """States at a part of these grid steps."""
    left, right = tuple(s[step] for s in states), tuple(s[step + 1] for s in states)
    x = [a + part * (b - a) for a, b in zip(left, right, strict=True)]
    for angle, rate in _turning(plant):  # curvature of the angle from the change of its rate
        x[angle] -= 0.5 * part * (1.0 - part) * h * (right[rate] - left[rate])
    return tuple(x)


def _earlier(plant: Plant, h: Scalar, states: History, slots: Slots, age: Scalar) -> History:
    """States a time `age` before the slots; before the first grid point every angle changes at its rate there."""
    step = slots.step
    position = slots.part - age / h
    whole = jnp.floor(position)
    before = jnp.minimum(step.astype(float) + position, 0.0)
    step = step + whole.astype(step.dtype)
    x = list(_between(plant, h, states, jnp.maximum(step, 0), jnp.where(step < 0, 0.0, position - whole)))
    for angle, rate in _turning(plant):
        x[angle] += h * before * x[rate]
    return tuple(x)
