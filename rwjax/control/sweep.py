"""The nonlinear closed loop at many gains, along many references, on many plants: maps of what the responses show."""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.closed_loop import ClosedLoopRun, closed_loop, loop_setup
from rwjax.control.controller import DEFAULT_CONTROLLER, DEFAULT_TIMING, Controller, LoopTiming, loop_timing
from rwjax.control.response import DEFAULT_STEP, Response, StepReference, step_response
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

BATCH = 800
"""Closed loops that run as one batch on one core: the batch stays in the cache."""
SAMPLES = 8_000_000
"""Samples of all loops of a batch that are held at a time."""


@dataclass(frozen=True, eq=False)
class GainSweep:
    """Step responses of a rig's nonlinear loop over PD gains.

    Attributes:
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.
        step: The step of the reference.
        response: Figures of the responses, `(p, d)` each.
    """

    kp: Float[np.ndarray, " p"]
    kd: Float[np.ndarray, " d"]
    step: StepReference
    response: Response

    @property
    def settled(self) -> int:
        """Number of gain pairs with which the axis settles [1]."""
        return int(np.isfinite(self.response.settling).sum())

    @property
    def fastest(self) -> tuple[int, int] | None:
        """Indices into `kp` and `kd` of the pair that settles first; None where none settles."""
        settling = np.asarray(self.response.settling)
        if not self.settled:
            return None
        i, j = np.unravel_index(np.argmin(settling), settling.shape)
        return int(i), int(j)

    def __str__(self) -> str:
        settling = np.asarray(self.response.settling)
        lines = [
            f"step of {np.degrees(self.step.angle):g}° over {self.step.seconds:g} s at {settling.size} pairs of PD gains:",
            f"  {self.settled} settle within 2 % of the step",
        ]
        if self.fastest is not None:
            i, j = self.fastest
            overshoot = 100.0 * float(self.response.overshoot[i, j])
            lines.append(
                f"  fastest: kp {self.kp[i]:g} V/rad, kd {self.kd[j]:g} V s/rad after {settling[i, j]:.3g} s, "
                f"overshoot {overshoot:.2g} %"
            )
        return "\n".join(lines)


def sweep(
    rig: Rig,
    kp: Float[np.ndarray, " p"],
    kd: Float[np.ndarray, " d"],
    *,
    controller: Controller = DEFAULT_CONTROLLER,
    step: StepReference = DEFAULT_STEP,
    timing: LoopTiming | None = None,
) -> GainSweep:
    """Step responses of a rig's nonlinear closed loop over PD gains: stick and slip, counts, sampling and limits.

    Args:
        rig: The rig.
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.
        controller: Integral gain, filter, feed-forward and limits; its `kp` and `kd` are not used.
        step: The step of the reference.
        timing: When the controller reads and acts; without it 100 Hz on the rig's encoder (`loop_timing`).

    Returns:
        Figures of the responses over the gains; the result prints itself.

    Raises:
        InputError: As `loop_setup` does.
    """
    rows, columns = np.asarray(kp, float), np.asarray(kd, float)
    timing = loop_timing(rig) if timing is None else timing
    controllers = [controller._replace(kp=p, kd=d) for p in rows for d in columns]
    found = step_responses(rig, controllers, step.samples(timing.period)[None], timing)
    maps = Response(*(x.reshape(len(rows), len(columns)) for x in found))
    return GainSweep(rows, columns, step, maps)


def step_responses(
    rig: Rig,
    controllers: Sequence[Controller],
    references: Float[np.ndarray, "r s"],
    timing: LoopTiming = DEFAULT_TIMING,
    thetas: Float[np.ndarray, "k p"] | None = None,
    since: int = 0,
) -> Response:
    """Responses of the loop from rest, of every controller along every reference on every plant.

    Args:
        rig: The rig; all plants have its delay.
        controllers: g controllers.
        references: Angles that are wanted [rad] at the controller's samples, `(r, s)`; nothing may change after `since`.
        timing: When the controllers read and act.
        thetas: Parameter vectors [SI], one plant for each row, `(k, p)`; without them the rig itself counts, k = 1.
        since: Sample [1] from which on the response to the references' last values is judged.

    Returns:
        Figures of the responses, `(g, r, k)` each.

    Raises:
        InputError: As `loop_setup` does.
        ValueError: For references that go on changing.
    """
    references = np.asarray(references)
    if np.any(references[:, since:] != references[:, -1:]):
        raise ValueError(f"the references have to keep their last value from sample {since} on")
    structure, theta, delayed, sign = loop_setup(rig, timing, *controllers)
    plants = theta[None] if thetas is None else jnp.asarray(thetas)
    gains = jnp.asarray(np.array(controllers, float).reshape(-1, len(Controller._fields)))
    shape = len(gains), len(references), len(plants)
    runs = np.stack(np.unravel_index(np.arange(np.prod(shape)), shape))
    batches = -(-runs.shape[1] // max(1, min(BATCH, SAMPLES // references.shape[1])))
    padded = np.pad(runs, ((0, 0), (0, -runs.shape[1] % batches)), mode="edge").reshape(3, batches, -1)
    one = partial(_batch, structure, delayed, since, gains, jnp.asarray(references), plants, sign)
    with ThreadPoolExecutor(min(batches, os.cpu_count() or 1)) as pool:
        found = list(pool.map(one, jnp.asarray(np.moveaxis(padded, 1, 0))))
    return Response(*(jnp.concatenate(x)[: runs.shape[1]].reshape(shape) for x in zip(*found, strict=True)))


@partial(jax.jit, static_argnums=(0, 1, 2))
def _batch(
    structure: Structure,
    timing: LoopTiming,
    since: int,
    gains: Float[Array, "g c"],
    references: Float[Array, "r s"],
    plants: Float[Array, "k p"],
    sign: Scalar | float,
    runs: Array,
) -> Response:
    """Responses of runs side by side; `runs` `(3, b)`: indices of controller, reference and plant."""
    start = jnp.zeros(len(structure.states))

    def one(gain: Float[Array, " c"], reference: Float[Array, " s"], theta: Float[Array, " p"]) -> Response:
        run = closed_loop(structure, theta, timing, Controller(*gain), reference, start, sign)
        late = ClosedLoopRun(*(x[since:] for x in run))
        return step_response(late, reference[-1], timing.period, Controller(*gain).voltage_limit)

    many = jax.vmap(one, in_axes=(0, 0, 0 if len(plants) > 1 else None))
    return many(gains[runs[0]], references[runs[1]], plants[runs[2]] if len(plants) > 1 else plants[0])
