"""The nonlinear closed loop at many gains, along many references, on many plants: maps of what the responses show."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from rwjax.control.closed_loop import ClosedLoopRun, closed_loop, loop_setup
from rwjax.control.controller import DEFAULT_CONTROLLER, DEFAULT_TIMING, Controller, LoopTiming, loop_timing
from rwjax.control.response import DEFAULT_STEP, Response, StepReference, step_response
from rwjax.errors import in_two_digits, refuses_other_types
from rwjax.fitting.threads import THREADS
from rwjax.lowering.arrays import Spread
from rwjax.lowering.kept import LANES, lowered
from rwjax.lowering.machine import doubles_in_a_vector
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

SAME, OF_LANE = Spread(), Spread(lanes=True)
VECTORS = 2
"""Vectors of closed loops side by side in machine code, since the operations of a single one wait for each other [1]."""
BATCH = 800
"""Closed loops that run as one batch of XLA on one core: the batch stays in the cache."""
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
                f"overshoot {in_two_digits(overshoot)} %"
            )
        return "\n".join(lines)


@refuses_other_types
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
        InputError: For no rig, and as `loop_setup` does.
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
    references = np.asarray(references, float)
    if np.any(references[:, since:] != references[:, -1:]):
        raise ValueError(f"the references have to keep their last value from sample {since} on")
    structure, theta, delayed, sign = loop_setup(rig, timing, *controllers)
    plants = theta[None] if thetas is None else np.asarray(thetas)
    gains = np.array(controllers, float).reshape(-1, len(Controller._fields))
    shape = len(gains), len(references), len(plants)
    g, r, k = np.unravel_index(np.arange(np.prod(shape)), shape)
    known = _Known(structure, delayed, since)
    each = gains[g], r, np.asarray(plants)[k if len(plants) > 1 else 0]
    found = _by_machine_code(known, references, sign, *each)
    if found is None:
        found = _by_xla(known, references, sign, *each)
    return Response(*(jnp.asarray(x.reshape(shape)) for x in found))


class _Known(NamedTuple):
    """What is known when a program is made: structure of the plant, timing with its delay, first sample that is judged."""

    structure: Structure
    timing: LoopTiming
    since: int

    def response(self, references: Array, sign: Scalar | float, gain: Array, r: Array, theta: Array) -> Response:
        """Response along the reference numbered `r`."""
        reference = references[0] if len(references) == 1 else references[r]
        start = jnp.zeros(len(self.structure.states))
        run = closed_loop(self.structure, theta, self.timing, Controller(*gain), reference, start, sign)
        late = ClosedLoopRun(*(x[self.since :] for x in run))
        return step_response(late, reference[-1], self.timing.period, Controller(*gain).voltage_limit)


def _by_machine_code(
    known: _Known, references: np.ndarray, sign: float, gains: np.ndarray, r: np.ndarray, thetas: np.ndarray
) -> list[np.ndarray] | None:
    """Figures of runs, each with gains, a reference and, unless `thetas` has one axis only, a plant of its own.

    None where the program runs through XLA.
    """
    first = [references, np.array(sign), gains[0], np.array(r[0]), thetas[0] if thetas.ndim > 1 else thetas]
    given = [SAME, SAME, OF_LANE, OF_LANE, OF_LANE if thetas.ndim > 1 else SAME]
    wide = max(VECTORS * doubles_in_a_vector(), LANES)
    lanes = wide if len(gains) > wide else LANES
    program = lowered("responses", known, known.response, first, given, known.structure.from_library, lanes)
    if program is None:
        return None
    found = program([references, np.array(sign), gains, r, thetas], rows=len(gains), threads=THREADS)
    return [np.broadcast_to(x, len(gains)) for x in found]  # all alike where there is no wheel


def _by_xla(
    known: _Known, references: np.ndarray, sign: float, gains: np.ndarray, r: np.ndarray, thetas: np.ndarray
) -> list[np.ndarray]:
    """The same by programs of XLA, in batches of equal length."""
    runs = len(gains)
    batches = -(-runs // max(1, min(BATCH, SAMPLES // references.shape[1])))
    which = np.pad(np.arange(runs), (0, -runs % batches), mode="edge").reshape(batches, -1)

    def one(k: np.ndarray) -> Response:
        return _batch(known, references, sign, gains[k], r[k], thetas[k] if thetas.ndim > 1 else thetas)

    with ThreadPoolExecutor(min(batches, THREADS)) as pool:
        found = list(pool.map(one, which))
    return [np.concatenate(x)[:runs] for x in zip(*found, strict=True)]


@partial(jax.jit, static_argnums=0)
def _batch(
    known: _Known,
    references: Float[Array, "r s"],
    sign: Scalar | float,
    gains: Float[Array, "b c"],
    r: Int[Array, " b"],
    thetas: Float[Array, "*b p"],
) -> Response:
    """Responses of runs side by side."""
    many = jax.vmap(known.response, in_axes=(None, None, 0, 0, 0 if thetas.ndim > 1 else None))
    return many(references, sign, gains, r, thetas)
