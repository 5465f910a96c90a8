"""What acts on a plant in time: the logged command after the drive, over every time step and at every reading."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from rwjax.plant.plant import Drive, Plant
from rwjax.simulation.batch import Batch
from rwjax.types import Scalar


def commands(plant: Plant, run: Batch) -> tuple[Float[Array, "s *channels"], Float[Array, "w q *channels"]]:
    """Voltage that acts over the steps of one log, and at its readings.

    A delay shifts the command in time, continuously. A reading sees the mean from its own time to the next sample, or over one
    grid step, whichever is shorter.

    Args:
        plant: The plant of the log.
        run: One log of a batch.

    Returns:
        Mean voltage over every grid step of the log and of its last window's overlap `(s,)` or `(s, 2)` [V], and the voltage at
        every reading `(w, q)` or `(w, q, 2)` [V].
    """
    return plant.by_channel(
        lambda drive, command: _of_channel(drive, command, run, plant.pace()),
        jnp.asarray(run.u_command),
    )


def _of_channel(
    drive: Drive, command: Float[Array, " k"], run: Batch, pace: Scalar | float
) -> tuple[Float[Array, " s"], Float[Array, "w q"]]:
    """`commands` of one channel."""
    t, h, slot_step = jnp.asarray(run.t_command), jnp.asarray(run.h), jnp.asarray(run.slot_step)
    W, m = slot_step.shape[0], run.step_index.shape[0]
    u = jax.vmap(drive.act)(jnp.asarray(command))
    delay = drive.delay()
    area = jnp.concatenate([jnp.zeros(1), jnp.cumsum(u * jnp.diff(t))])

    held = jnp.asarray(run.held)
    early = held.shape[0] - (W * m + len(run.overlap_index) + 1)

    def until(time: Float[Array, " s"], point: Int[Array, " s"], between: bool) -> Float[Array, " s"]:
        """Area of the command up to some times, given the grid points before them."""
        i = held[point + early]
        for _ in run.sample_index if between else ():
            i = jnp.where(t[i + 1] <= time, i + 1, i)
        return area[i] + u[i] * (time - t[i])  # the first command is taken to have been held before the log

    def acting(time: Float[Array, " s"], point: Int[Array, " s"], between: bool) -> Float[Array, " s"]:
        """`until` of the delayed command."""
        if delay is None:
            return until(time, point, between)
        late = time - delay
        return until(late, jnp.clip(jnp.floor(late / h).astype(int), -early, held.shape[0] - early - 1), True)

    grid = jnp.arange(W * m + len(run.overlap_index) + 1)
    steps = drive.follow(jnp.diff(acting(h * grid.astype(float), grid, False)) / h, h * pace)
    point = (m * jnp.arange(W)[:, None] + slot_step).ravel()
    sample = h * (point.astype(float) + jnp.asarray(run.slot_part).ravel())
    width = jnp.minimum(h, jnp.min(jnp.diff(t)))
    end = jnp.floor((sample + width) / h).astype(int)
    readings = (acting(sample + width, end, True) - acting(sample, point, True)) / width
    if drive.filters:  # a voltage that lags does not jump between steps
        readings = steps[point]
    return steps, readings.reshape(W, -1)
