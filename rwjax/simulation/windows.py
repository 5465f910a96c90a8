"""A log's plant moved through one window of its time grid, and the logs of a batch worked out together."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from rwjax.plant.assemble import plant_of
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.plant import Plant
from rwjax.plant.servo import acted
from rwjax.plant.structure import State, Structure
from rwjax.simulation.batch import WITHOUT_LOG_AXIS, Batch
from rwjax.simulation.stepper import Stepper
from rwjax.types import Scalar, entries

History = tuple[Float[Array, " _"], ...]
"""For each state its values at the grid points of a window, or at its readings."""
OneLog = Callable[..., Any]
"""What is worked out for one log: called with a log of a batch, which has no axis of logs, and with values of that log."""


def side_by_side(one: OneLog, batch: Batch, *of_log: Array) -> Any:
    """What a function makes of every log of a batch, all logs at once.

    Args:
        one: The function, called with one log and its values.
        batch: The logs.
        of_log: Arrays `(l, …)` of which each log gets its own entry.

    Returns:
        The function's arrays with a first axis of logs.
    """
    each, runs = _one_log(one, batch)
    return jax.vmap(each)(runs, *of_log)


def log_by_log(one: OneLog, batch: Batch, *of_log: Array) -> Any:
    """What a function makes of every log of a batch, one log after the other.

    Windows and derivatives run side by side already; those of one log fit into a processor's nearest cache.

    Args:
        one: The function, called with one log and its values.
        batch: The logs.
        of_log: Arrays `(l, …)` of which each log gets its own entry.

    Returns:
        The function's arrays with a first axis of logs.
    """
    each, runs = _one_log(one, batch)
    return jax.lax.map(lambda values: each(*values), (runs, *of_log))


def _one_log(one: OneLog, batch: Batch) -> tuple[OneLog, Batch]:
    """`one` with the entries that have no axis of logs put back into its log, and the batch without these entries."""
    shared = {name: jnp.asarray(getattr(batch, name)) for name in WITHOUT_LOG_AXIS}
    runs = jax.tree.map(jnp.asarray, batch._replace(**dict.fromkeys(WITHOUT_LOG_AXIS, batch.h)))
    return (lambda run, *values: one(run._replace(**shared), *values)), runs


def plant_of_run(structure: Structure, theta: Float[Array, " t"], run: Batch) -> Plant:
    """Plant with the numbers of one log: its own entries of `theta`, and what is known to be added to them.

    Args:
        structure: What the plant is made of.
        theta: Numbers of all logs `(t,)` [SI].
        run: One log of a batch.

    Returns:
        The plant.
    """
    return plant_of(structure, theta[jnp.asarray(run.theta_index)] + jnp.asarray(run.theta_offset))


def time_grid(plant: Plant, run: Batch) -> tuple[Scalar, Scalar]:
    """Time grid of one log, in the plant's time and not the logger's.

    Args:
        plant: The plant of the log.
        run: One log of a batch.

    Returns:
        Length of a step [s], and the time of the log's first sample [s].
    """
    return jnp.asarray(run.h) * plant.pace(), jnp.asarray(run.t0) * plant.pace()


class PreparedPlant(NamedTuple):
    """A plant ready to be moved in equal steps.

    Attributes:
        plant: The plant.
        stepper: What moves it over one step.
        prepared: What all steps share, as the stepper prepared it.
        without_torque: The same of the plant whose torque is off; None where it never is.
        h: Length of a step [s].
    """

    plant: Plant
    stepper: Stepper
    prepared: Any
    without_torque: Any
    h: Scalar

    def states(self, begin: Scalar, x0: Float[Array, " n"], given: Any) -> History:
        """States at the grid points of one window.

        Args:
            begin: Time at which the window begins [s].
            x0: First state `(n,)` [SI].
            given: What moves the plant over every step, arrays with a first axis of steps `(m, …)`: `commands.given` of the window.

        Returns:
            For each state its values `(m + 1,)`.
        """

        def one(carry: tuple[Scalar, State], of_step: Any) -> tuple[tuple[Scalar, State], State]:
            t, x = carry
            return (t + self.h, self.step(t, x, of_step)), x

        (_, end), states = jax.lax.scan(one, (begin, entries(x0)), given)
        return tuple(jnp.concatenate([s, e[None]]) for s, e in zip(states, end, strict=True))

    def step(self, t: Scalar, x: State, given: Any) -> State:
        """State after one step.

        Args:
            t: Time at which it begins [s].
            x: State at its beginning.
            given: What moves the plant over it: a voltage [V], `commands.Switched` or `servo.Tick`.

        Returns:
            State at its end.
        """
        plant, prepared, structure = self.plant, self.prepared, self.plant.structure
        if not isinstance(plant, OneAxis) or not (structure.switched or structure.servo):
            return self.stepper.step(plant, prepared, t, x, given, self.h)
        if structure.switched:
            plant, on = plant.powered(given.powered), given.powered
            prepared = jax.tree.map(lambda a, b: on * a + (1.0 - on) * b, prepared, self.without_torque)
            x = plant.opened(x)
        x, u = acted(plant, t, x, given, self.h) if structure.servo else (x, given.u)
        body = plant.without_servo()
        n = len(body.structure.states)
        return self.stepper.step(body, prepared, t, x[:n], u, self.h) + x[n:]


def prepare(plant: Plant, stepper: Stepper, h: Scalar) -> PreparedPlant:
    """A plant ready to be moved in steps of equal length.

    Args:
        plant: The plant.
        stepper: What moves it over one step.
        h: Length of a step [s].

    Returns:
        The plant with what all its steps share.
    """
    if not isinstance(plant, OneAxis):
        return PreparedPlant(plant, stepper, stepper.prepare(plant, h), None, h)
    body = plant.without_servo()
    off = stepper.prepare(body.powered(jnp.zeros(())), h) if plant.structure.switched else None
    return PreparedPlant(plant, stepper, stepper.prepare(body, h), off, h)
