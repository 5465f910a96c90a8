# pyright: reportOptionalSubscript=false, reportOptionalOperand=false
"""Reference simulation: an adaptive diffrax solver between samples, dry friction with located events.

Slow and accurate: an oracle for the fixed step of `rwjax.simulation.exponential_step`, and the way to a solver of one's own choice.
The smooth field of the plant is an ordinary `diffrax.ODETerm`. A body with dry friction slides forward, slides backward or sticks;
between two changes of mode or command the field is smooth. The host goes from one such change to the next. While a body slides, its
speed reaching 0 is an event; while it sticks, the torque on it reaching breakaway is one.
"""

from collections.abc import Callable
from functools import cache, partial
from itertools import pairwise
from typing import NamedTuple

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Bool, Float

from rwjax.logs.log import Log
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.dry_friction import friction_level
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.structure import State, Structure
from rwjax.simulation.exponential_step import linear_part
from rwjax.types import Scalar

STIFF = 1e3
"""Fastest rate of the linear part times the sampling interval above which the implicit solver is taken: an explicit one is stable only
up to a few units of it a step."""
MOST_EVENTS = 200
"""Most changes of mode in one stretch of held command; more mean that a body chatters."""
MOST_STEPS = 100_000
"""Most steps of the solver in one stretch."""
SAME = 1e-9
"""Distance [rad/s or N m] within which events of several bodies happen together."""
TINY = 1e-300
"""Distance that stands for 0 where a body has just left it."""

Modes = Float[Array, " body"]
"""Direction in which each body of `OneAxis.bodies` slides: 1 or -1, 0 where it sticks."""


def simulate_adaptively(
    plant: OneAxis,
    log: Log,
    start: np.ndarray,
    *,
    solver: diffrax.AbstractSolver | None = None,
    rtol: float = 1e-9,
    atol: float = 1e-11,
) -> dict[str, np.ndarray]:
    """Free run under the command of a log.

    The command is held between samples; before the first one its first value counts as held. Lags and rate limits of the drive, the
    logger's clock and lateness of the encoder are left out. The error is that of `rtol` and `atol`, events included. It takes about a
    millisecond a sample.

    Args:
        plant: The plant.
        log: The log; its outputs do not matter.
        start: First state `(n,)` [SI].
        solver: Any diffrax solver; `solver_for` chooses where it is None.
        rtol: Relative tolerance of a step [1].
        atol: Absolute tolerance of a step [SI].

    Returns:
        Readings `(time,)` of each output at the log's times [rad, rad/s or A].

    Raises:
        RuntimeError: A body changes between stick and slip too often to be followed.
    """
    t = log.time - log.origin
    solver = solver_for(plant, float(np.median(np.diff(t)))) if solver is None else solver
    command, edges = _acting(plant, log)
    segment = partial(_segment, plant, _Solving(solver, rtol, atol))
    x = tuple(jnp.asarray(float(v)) for v in start)
    found = [_readings(plant, jnp.asarray(t[0]), x, jnp.asarray(command(t[0])))]
    for begin, end in pairwise(t):
        inner = edges[(edges > begin) & (edges < end)]
        for a, b in zip(np.append(begin, inner), np.append(inner, end), strict=True):
            x = _stretch(plant, segment, x, float(a), float(b), command(0.5 * (a + b)))
        found.append(_readings(plant, jnp.asarray(end), x, jnp.asarray(command(end))))
    return {name: np.array([y[k] for y in found], float) for k, name in enumerate(plant.structure.outputs)}


def solver_for(plant: OneAxis, dt: float) -> diffrax.AbstractSolver:
    """Solver that suits a plant: an implicit one where a time constant is far shorter than the sampling interval.

    Args:
        plant: The plant.
        dt: Sampling interval [s].

    Returns:
        `Dopri8` or `Kvaerno5`.
    """
    fastest = np.max(np.abs(np.linalg.eigvals(np.asarray(linear_part(plant)))))
    return diffrax.Kvaerno5() if fastest * dt > STIFF else diffrax.Dopri8()


def _acting(plant: OneAxis, log: Log) -> tuple[Callable[[float], float], np.ndarray]:
    """The acting command as a function of time, continuous from the right, and the times of its jumps."""
    acting = np.array([float(plant.act(jnp.asarray(u))) for u in log.command])
    delay = plant.delay()
    edges = log.time - log.origin + (0.0 if delay is None else float(delay))

    def command(t: float) -> float:
        # a sample's time plus the delay may round to either side of the edge; 1e-12 s is below any interval
        return float(acting[max(int(np.searchsorted(edges, t + 1e-12, side="right")) - 1, 0)])

    return command, edges


@eqx.filter_jit
def _readings(plant: OneAxis, t: Scalar, x: State, u: Scalar) -> tuple[Scalar, ...]:
    """Readings at one time, in the order of the outputs."""
    return plant.outputs(t, x, u)


def _stretch(plant: OneAxis, segment: Callable, x: State, begin: float, end: float, u: float) -> State:
    """State at `end` under a held command, through all changes of mode on the way."""
    rates = _body_rates(plant.structure)
    modes = [float(np.sign(x[k])) for k in rates]
    settled = [mode != 0.0 for mode in modes]  # a resting body's mode follows from the torque on it
    for _ in range(MOST_EVENTS):
        modes = _released(plant, x, begin, u, modes, settled)
        at, x, happened = segment(jnp.asarray(begin), jnp.asarray(end), x, jnp.asarray(u), jnp.asarray(modes))
        happened = np.asarray(happened)
        if not happened.any():
            return x
        begin = float(at)
        for body, k in enumerate(rates):
            if happened[body] and modes[body] != 0.0:  # it slid and stopped: stuck unless the torque turns it
                x = tuple(jnp.zeros(()) if j == k else v for j, v in enumerate(x))
                modes[body], settled[body] = 0.0, False
            elif happened[body]:  # it stuck and broke away
                modes[body], settled[body] = float(_push(plant, x, begin, u, modes)[body]), True
            elif x[k] == 0.0 and modes[body] == 0.0:
                settled[body] = False
        if begin >= end:
            return x
    raise RuntimeError(
        f"more than {MOST_EVENTS} changes between stick and slip between {begin} s and {end} s: "
        "a level of dry friction jumps with the motion; smooth it or simulate with the fixed step"
    )


def _released(plant: OneAxis, x: State, t: float, u: float, modes: list[float], settled: list[bool]) -> list[float]:
    """Modes, with every body that rests and is pushed beyond breakaway set sliding, the driving one first."""
    modes = list(modes)
    for body in range(len(modes)):
        if not settled[body]:
            modes[body] = 0.0
            forward, backward = _margins(plant, jnp.asarray(t), x, jnp.asarray(u), jnp.asarray(modes))
            modes[body] = 1.0 if forward[body] < 0.0 else -1.0 if backward[body] < 0.0 else 0.0
    return modes


def _push(plant: OneAxis, x: State, t: float, u: float, modes: list[float]) -> np.ndarray:
    """Direction in which the torque pushes each body, 1 or -1."""
    forward, backward = _margins(plant, jnp.asarray(t), x, jnp.asarray(u), jnp.asarray(modes))
    return np.where(np.asarray(forward) < np.asarray(backward), 1.0, -1.0)


@cache
def _body_rates(structure: Structure) -> tuple[int, ...]:
    """Index of each body's rate in the state."""
    return tuple(body.rate for body, _ in one_axis_plant_of(structure, jnp.ones(len(structure.names))).bodies())


def _forces(plant: OneAxis, t: Scalar, x: State, u: Scalar, modes: Modes) -> tuple[State, list[Scalar], list[Scalar]]:
    """Rates with dry friction in these modes, and the distance of the torque on each body from its breakaway levels [N m]."""
    rates, motion = plant.field(t, x, u), plant.motion(t, x, u)
    ahead, behind = [], []
    for k, (body, effects) in enumerate(plant.bodies(motion)):
        free = rates[body.rate] * body.inertia
        forward, backward = friction_level(effects, motion, 1.0), friction_level(effects, motion, -1.0)
        friction = jnp.where(modes[k] > 0.0, forward, jnp.where(modes[k] < 0.0, -backward, free))
        changed = [r + c * friction for r, c in zip(rates, body.reaction, strict=True)]
        changed[body.rate] = jnp.where(modes[k] == 0.0, 0.0, changed[body.rate])  # exactly, not to rounding
        rates = tuple(changed)
        ahead.append(forward - free)
        behind.append(free + backward)
    return rates, ahead, behind


@eqx.filter_jit
def _margins(plant: OneAxis, t: Scalar, x: State, u: Scalar, modes: Modes) -> tuple[list[Scalar], list[Scalar]]:
    """How far the torque on each body is from its breakaway level, forward and backward [N m]."""
    return _forces(plant, t, x, u, modes)[1:]


class _Solving(NamedTuple):
    """A diffrax solver with its tolerances."""

    solver: diffrax.AbstractSolver
    rtol: float
    atol: float


@eqx.filter_jit
def _segment(
    plant: OneAxis, by: _Solving, t0: Scalar, t1: Scalar, x: State, u: Scalar, modes: Modes
) -> tuple[Scalar, State, Bool[Array, " body"]]:
    """Solve from `t0` to `t1` or the first event: time and state there, and which bodies had an event."""

    def field(t: Scalar, x: State, args: None) -> State:
        return _forces(plant, t, x, u, modes)[0]

    def distances(t: Scalar, x: State) -> list[Scalar]:  # of each body from its mode's end, above 0 before it
        _, ahead, behind = _forces(plant, t, x, u, modes)
        rates = [x[body.rate] for body, _ in plant.bodies()]
        apart = [
            jnp.where(modes[k] == 0.0, jnp.minimum(ahead[k], behind[k]), modes[k] * w) for k, w in enumerate(rates)
        ]
        # a body that has just broken away starts at 0 and rises
        return [jnp.where(d == 0.0, TINY, d) for d in apart]

    def nearest(t: Scalar, y: State, args: None, **_) -> Scalar:
        return jnp.min(jnp.stack(distances(t, y)))

    bodies = plant.bodies()
    root = optx.Bisection(rtol=1e-13, atol=1e-13)
    event = diffrax.Event(nearest, root, direction=False) if bodies else None
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field),  # pyright: ignore[reportArgumentType]
        by.solver,
        t0,
        t1,
        None,
        x,
        stepsize_controller=diffrax.PIDController(rtol=by.rtol, atol=by.atol),
        event=event,
        max_steps=MOST_STEPS,
    )
    end = jax.tree.map(lambda y: y[-1], solution.ys)
    if not bodies:
        return solution.ts[-1], end, jnp.zeros(0, bool)
    apart = jnp.stack(distances(solution.ts[-1], end))
    return solution.ts[-1], end, solution.event_mask & (apart <= jnp.maximum(jnp.min(apart), 0.0) + SAME)
