"""The nonlinear closed loop at many gains, along many references, on many plants: maps of what the responses show.

Lanes run side by side under `jax.vmap`, in blocks that stay in the cache, one block on each core.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.closed_loop import Controller, LoopTiming, Run, closed_loop, posed
from rwjax.control.response import Response, step_response
from rwjax.plant.one_axis import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

LANES, SAMPLES = 800, 8_000_000
"""Closed loops that run side by side on one core, and the samples of all of them that are held at a time."""


def sweep(
    rig: Rig,
    controllers: Sequence[Controller],
    references: Float[np.ndarray, "r s"],
    clockwork: LoopTiming = LoopTiming(),  # noqa: B008 (a tuple, which nothing changes)
    thetas: Float[np.ndarray, "k p"] | None = None,
    since: int = 0,
) -> Response:
    """Responses `(g, r, k)` of the loop from rest, one plant for each row of `thetas` (the rig itself without), to the
    references' last values, judged from their sample `since` on. All plants have the delay of the rig.

    `references` [rad] at the controller's samples, after whose sample `since` nothing may change.
    Raises `InputError` as `posed` does, and `ValueError` for references that go on changing.
    """
    references = np.asarray(references)
    if np.any(references[:, since:] != references[:, -1:]):
        raise ValueError(f"the references have to keep their last value from sample {since} on")
    structure, theta, delayed, sign = posed(rig, clockwork, *controllers)
    plants = theta[None] if thetas is None else jnp.asarray(thetas)
    gains = jnp.asarray(np.array(controllers, float).reshape(-1, len(Controller._fields)))
    shape = len(gains), len(references), len(plants)
    lanes = np.stack(np.unravel_index(np.arange(np.prod(shape)), shape))
    blocks = -(-lanes.shape[1] // max(1, min(LANES, SAMPLES // references.shape[1])))
    padded = np.pad(lanes, ((0, 0), (0, -lanes.shape[1] % blocks)), mode="edge").reshape(3, blocks, -1)
    one = partial(_block, structure, delayed, since, gains, jnp.asarray(references), plants, sign)
    with ThreadPoolExecutor(min(blocks, os.cpu_count() or 1)) as pool:
        found = list(pool.map(one, jnp.asarray(np.moveaxis(padded, 1, 0))))
    return Response(*(jnp.concatenate(x)[: lanes.shape[1]].reshape(shape) for x in zip(*found, strict=True)))


@partial(jax.jit, static_argnums=(0, 1, 2))
def _block(
    structure: Structure,
    clockwork: LoopTiming,
    since: int,
    gains: Float[Array, "g c"],
    references: Float[Array, "r s"],
    plants: Float[Array, "k p"],
    sign: Scalar | float,
    lanes: Array,
) -> Response:
    start = jnp.zeros(len(structure.states))

    def one(gain: Float[Array, " c"], reference: Float[Array, " s"], theta: Float[Array, " p"]) -> Response:
        run = closed_loop(structure, theta, clockwork, Controller(*gain), reference, start, sign)
        late = Run(*(x[since:] for x in run))
        return step_response(late, reference[-1], clockwork.period, Controller(*gain).limit)

    many = jax.vmap(one, in_axes=(0, 0, 0 if len(plants) > 1 else None))
    return many(gains[lanes[0]], references[lanes[1]], plants[lanes[2]] if len(plants) > 1 else plants[0])
