"""Commands that minimise the time of a manoeuvre, found by optimisation through the plant.

A manoeuvre takes a time T in which the command runs straight between `PIECES` + 1 values; all of these are unknowns. The
plant is the nonlinear one, stick and slip included; its derivatives by every command and by T are exact.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.optimize import minimize

from rwjax.control.closed_loop import holding, settled, without_lags
from rwjax.control.linear import lateness
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import CurrentLimit, WheelDry
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import Plant, Structure, friction_level
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import one_axis_plant_of
from rwjax.simulation.step import propagator, sliding_step, step, with_friction
from rwjax.types import Scalar

PIECES = 30
STEPS = 10
"""Time steps of the plant in one piece of the command."""
REACHED = 1e-4
"""Largest violation of a condition, in its own scale, at which a manoeuvre counts as possible."""
SPARE = 0.9
COMMANDS = 201
"""Commands up to the limit among which the one of the largest torque is looked for."""
RATES = 60
LONGER = (1.0, 1.4)
"""Durations from which the search begins, over the guessed one, until one ends well."""
TRIES, GAIN = 4, 2e-3
"""Searches at most, and the share of the time that one has to gain for another to go on from there."""
PATIENCE = {"maxiter": 200, "ftol": 1e-6}
STILL = 1e-9
"""Angle [rad], and share of the wheel's rate, within which nothing moves."""
BARELY = 1.0 + 1e-9
"""Share of a limit that counts as within it, so that a start at the limit does."""


class Limits(NamedTuple):
    """What the drive gives: largest command `volts` [V], current `amps` [A] and wheel rate `top` [rad/s]."""

    volts: float
    amps: float = np.inf
    top: float = np.inf


class Course(NamedTuple):
    """A manoeuvre at its times `(t,)` [s]: `angle` [rad] and `rate` [rad/s] of the axis, `wheel` rate [rad/s], `current` [A],
    `torque` [N m] on the axis besides its dry friction, which holds an axis at rest within `holds` `(t, 2)` (backward, forward);
    `command` [V] that comes next."""

    time: Float[Array, " t"]
    angle: Float[Array, " t"]
    rate: Float[Array, " t"]
    wheel: Float[Array, " t"]
    current: Float[Array, " t"]
    torque: Float[Array, " t"]
    holds: Float[Array, "t 2"]
    command: Float[Array, " t"]


@partial(jax.jit, static_argnums=0)
def course(
    structure: Structure,
    theta: Float[Array, " p"],
    commands: Float[Array, " c"],
    duration: Scalar | float,
    start: Float[Array, " n"],
) -> Course:
    """What the plant does under the mean commands of equal steps of a duration; the last time is its end."""
    return _course(structure, theta, commands, duration, start, len(commands), jnp.ones(()))


def _course(
    structure: Structure,
    theta: Float[Array, " p"],
    commands: Float[Array, " c"],
    duration: Scalar | float,
    start: Float[Array, " n"],
    stick: int,
    way: Scalar,
) -> Course:
    """`course` of an axis that slides `way` from the step `stick` on."""
    plant = one_axis_plant_of(structure, theta)
    h = jnp.asarray(duration) / len(commands)
    p = propagator(plant, h)

    def moved(by: Callable) -> Callable:
        def one(carry: tuple, u: Scalar) -> tuple[tuple, Course]:
            t, x = carry
            return (t + h, by(plant, p, t, x, plant.act(u), h)), _seen(plant, t, x, u)

        return one

    first = (jnp.zeros(()), tuple(start[k] for k in range(len(structure.states))))
    middle, sticks = jax.lax.scan(moved(step), first, commands[:stick])
    slides = partial(sliding_step, way=way)
    (t, x), slid = jax.lax.scan(moved(slides), middle, commands[stick:])
    last = _seen(plant, t, x, commands[-1])
    return Course(*(jnp.concatenate([a, b, c[None]]) for a, b, c in zip(sticks, slid, last, strict=True)))


def _seen(plant: Plant, t: Scalar, x: tuple, u: Scalar) -> Course:
    volts = plant.act(u)
    m = plant.motion(t, x, volts)
    bodies = plant.bodies()
    torques = with_friction(plant, t, x, volts, x)[1]
    dry = [k for k, (body, _) in enumerate(bodies) if body.rate == plant.structure.states.index("w")]
    if dry:
        torque, effects = torques[dry[0]][0], bodies[dry[0]][1]
        holds = jnp.stack([friction_level(effects, m, -1.0), friction_level(effects, m, 1.0)])
    else:
        rate = plant.field(t, x, volts)[plant.structure.states.index("w")]
        torque, holds = rate * plant.numbers["axis.inertia"], jnp.zeros(2)
    return Course(t, m.psi, m.w, m.Omega, m.i, torque, holds, u)


def check(rig: Rig, limits: Limits) -> None:
    """Raises `InputError` as `without_lags` does, for a rig without a reaction wheel and for limits that are not positive."""
    if rig.kind != "reaction":
        raise InputError(f"kind `{rig.kind}`: there is no wheel that turns an axis; take a `reaction` rig")
    without_lags(rig)
    if not np.isfinite(limits.volts):
        raise InputError(f"limit `volts` {limits.volts:g}: has to be a finite number")
    for name, value in limits._asdict().items():
        if not value > 0.0:
            raise InputError(f"limit `{name}` {value:g}: has to be positive")


class Push(NamedTuple):
    """Largest `torque` [N m] that speeds the wheel up at a rate, and whether the current is what limits it."""

    torque: float
    by_current: bool


def push_at(rig: Rig, limits: Limits, rate: float) -> Push:
    """What the plant's motor gives at a rate of the wheel [rad/s] within the limits of voltage and current, in the direction in
    which that is less: the drive's and the motor's effects and the wheel's friction included, as the run begins."""
    structure, theta = settled(rig)
    torque, by_current = _pushes(
        structure, theta, jnp.asarray(limits.volts), jnp.asarray(limits.amps), jnp.asarray(rate)
    )
    way = int(np.argmin(torque))
    return Push(float(torque[way]), bool(by_current[way]))


@partial(jax.jit, static_argnums=0)
def _pushes(
    structure: Structure, theta: Float[Array, " p"], volts: Scalar, amps: Scalar, rate: Scalar
) -> tuple[Array, Array]:
    """`push_at` forward and backward, each with the best of `COMMANDS` commands: more of them may give less."""
    plant, zero = one_axis_plant_of(structure, theta), jnp.zeros(())

    def one(way: float, command: Scalar) -> tuple[Array, Array]:
        x = tuple(way * rate if name == "Omega" else zero for name in structure.states)
        m = plant.motion(zero, x, plant.act(way * command))
        most = jnp.stack([amps, *(effect.limit() for effect in plant.on(CurrentLimit))]).min()
        held = m._replace(i=jnp.clip(m.i, -amps, amps))
        torque = way * plant.wheel_torque(held) - friction_level(plant.on(WheelDry), held, way)
        return torque, jnp.abs(m.i) >= most * (1.0 - 1e-9)

    commands = volts * jnp.linspace(0.0, 1.0, COMMANDS)
    torque, by_current = (
        jnp.stack(x) for x in zip(*(jax.vmap(partial(one, w))(commands) for w in (1.0, -1.0)), strict=True)
    )
    best = jnp.argmax(torque, axis=1, keepdims=True)
    return jnp.take_along_axis(torque, best, 1)[:, 0], jnp.take_along_axis(by_current, best, 1)[:, 0]


def torque_at(rig: Rig, limits: Limits, rate: float) -> float:
    """Torque that the motor has at a rate of the wheel within the limits of voltage and current [N m]."""
    return push_at(rig, limits, rate).torque


def fastest_rate(rig: Rig, limits: Limits) -> float:
    """Rate that the wheel reaches in the end within the limits [rad/s]."""
    structure, theta = settled(rig)
    rates = np.append(0.0, np.geomspace(1e-3, 1e6, RATES))
    for _ in range(7):
        least = np.min(
            _at_rates(structure, theta, *(jnp.asarray(v) for v in (limits.volts, limits.amps, rates))), axis=1
        )
        last = max(int(np.argmax(least <= 0.0)) - 1, 0)  # no torque is left at a million rad/s
        rates = np.linspace(rates[last], rates[last + 1], RATES)
    return min(limits.top, float(rates[0]))


@partial(jax.jit, static_argnums=0)
def _at_rates(
    structure: Structure, theta: Float[Array, " p"], volts: Scalar, amps: Scalar, rates: Float[Array, " r"]
) -> Float[Array, "r 2"]:
    return jax.vmap(lambda rate: _pushes(structure, theta, volts, amps, rate)[0])(rates)


def usable_rate(rig: Rig, limits: Limits) -> float:
    """Rate of the wheel [rad/s] that a design counts on: where no rate is given, `SPARE` of what the voltage reaches, since
    no torque is left there. Raises `InputError` where none is left at the given one either."""
    rate = min(limits.top, SPARE * fastest_rate(rig, limits._replace(top=np.inf)))
    if not (rate > 0.0 and torque_at(rig, limits, rate) > 0.0):
        raise InputError(f"no torque is left at a wheel rate of {rate:g} rad/s; raise the voltage or the current")
    return rate


def steady(rig: Rig, spin: float = 0.0) -> tuple[Structure, Float[Array, " p"], Float[Array, " n"]]:
    """Structure, parameter vector and state of a rig at rest whose wheel turns steadily."""
    structure = structure_of(rig)
    current = rig.values.get("motor.friction", 0.0) * spin / rig.values["motor.torque_constant"]
    state = jnp.array([{"Omega": spin, "i": current}.get(name, 0.0) for name in structure.states])
    return structure, jnp.asarray(theta_of(rig, structure)), state


def resting(rig: Rig, spin: float = 0.0) -> Course:
    """The rig at rest with a steady wheel: the torque of its load, and what friction holds."""
    structure, theta, start = steady(rig, spin)
    keeps = jnp.array([holding(rig.values) * spin])
    return Course(*(x[0] for x in course(structure, theta, keeps, 1e-3, start)))


def waiting(rig: Rig, spin: float = 0.0) -> float:
    """The drive's delay [s], over which a rig waits for the first command as it is at its beginning: at rest, a command that keeps
    the `spin` [rad/s] of its wheel given before.

    Raises `InputError` for a rig that does not: one that its load or its drive moves meanwhile, whose wheel changes its rate, or that
    changes with time.
    """
    delay = float(lateness(rig).commands[0])
    if delay == 0.0:
        return delay
    why = next((f"`{name}` changes with time" for name in rig.effects if BY_NAME[name].changes_over_time), "")
    if not why:
        structure, theta, start = steady(rig, spin)
        keeps = jnp.full(PIECES * STEPS, holding(rig.values) * spin)
        seen = course(structure, theta, keeps, delay, start)
        if not np.max(np.abs(seen.angle)) <= STILL:
            why = "the axis turns"
        elif not np.max(np.abs(seen.wheel - spin)) <= STILL * max(abs(spin), 1.0):
            why = "the wheel changes its rate"
    if why:
        raise InputError(
            f"{why} before the first command acts, after the drive's delay of {delay:g} s; leave the delay out"
        )
    return delay


Conditions = Callable[[Course, Array], tuple[Array, Array]]
"""What has to be 0 and what must not be negative, of a course and of some numbers, each in its own scale."""


class Task(NamedTuple):
    """What a search is given besides the conditions: plant, `limits`, the conditions' `numbers`, first state, guessed `duration`
    [s] and the `way` in which the axis slides."""

    theta: Float[Array, " p"]
    limits: Limits
    numbers: Float[Array, " m"]
    start: Float[Array, " n"]
    duration: float
    way: float

    def scaled(self, z: Array) -> tuple[Array, Array]:
        """Mean command of every step and duration, from commands over their limit and the duration over the guessed one."""
        return self.limits.volts * (jnp.asarray(_between()) @ z[:-1]), self.duration * z[-1]


def _judged(conditions: Conditions, task: Task, found: Course) -> tuple[Array, Array]:
    """The conditions, the limits of wheel rate and current among them."""
    zero, positive = conditions(found, task.numbers)
    held = ((found.wheel, task.limits.top), (found.current, task.limits.amps))
    within = [worst(BARELY - (x / most) ** 2) for x, most in held]
    return zero, jnp.concatenate([positive, *within])


def _outcome(structure: Structure, conditions: Conditions, stick: int, task: Task, z: Array) -> tuple[Array, Array]:
    commands, duration = task.scaled(z)
    found = _course(structure, task.theta, commands, duration, task.start, stick * STEPS, jnp.asarray(task.way))
    return _judged(conditions, task, found)


@partial(jax.jit, static_argnums=(0, 1, 2))
def _with_slopes(structure: Structure, conditions: Conditions, stick: int, task: Task, z: Array) -> tuple:
    one = partial(_outcome, structure, conditions, stick, task)
    return one(z), jax.jacfwd(one)(z)


def fastest(
    structure: Structure,
    conditions: Conditions,
    stick: int,
    task: Task,
    guess: Float[np.ndarray, " c"],
    pushes: float,
) -> tuple[Course, float]:
    """The course of least time within the limits that meets the conditions, and how far it violates them (0 where it meets
    them), from a guess of `PIECES` + 1 commands; `pushes`: the part of a command [V] that makes the torque, in which they are
    searched. The search takes the axis to slide from the piece `stick` on; what it ends with is judged on the plant, which may
    stick. The best that was met on the way is kept, the guess included, and the search goes on from there.

    Sequential quadratic programming (Kraft 1988), derivatives through the plant."""
    count = PIECES + 1
    scale = np.append(np.full(count, min(pushes / task.limits.volts, 1.0)), 1.0)
    known: dict[bytes, tuple] = {}
    met: list[np.ndarray] = []  # each quicker than those before

    def at(y: np.ndarray) -> tuple:
        key = y.tobytes()
        if key not in known:
            known.clear()
            z = scale * y
            found = jax.tree.map(np.asarray, _with_slopes(structure, conditions, stick, task, jnp.asarray(z)))
            if _missed(*found[0]) <= REACHED and (not met or z[count] < met[-1][count]):
                met.append(z)
            known[key] = found
        return known[key]

    def judged(z: np.ndarray) -> Found:
        z = np.append(np.clip(z[:count], -1.0, 1.0), z[count])
        found = course(structure, task.theta, *task.scaled(jnp.asarray(z)), task.start)
        return Found(max(_missed(*_judged(conditions, task, found)), REACHED), float(found.time[-1]), z, found)

    last = np.eye(count + 1)[count]
    bounds = [(-1.0 / s, 1.0 / s) for s in scale[:count]] + [(1e-2, 1e2)]
    posed = [
        {"type": "eq", "fun": lambda y: at(y)[0][0], "jac": lambda y: at(y)[1][0] * scale},
        {"type": "ineq", "fun": lambda y: at(y)[0][1], "jac": lambda y: at(y)[1][1] * scale},
    ]
    first, *others = [np.append(np.clip(guess / task.limits.volts, -1.0, 1.0), longer) for longer in LONGER]
    best, start, searched = judged(first), first, False
    for _ in range(TRIES):
        ended = minimize(
            lambda y: (y[count], last),
            start / scale,
            jac=True,
            method="SLSQP",
            bounds=bounds,
            constraints=posed,
            options=PATIENCE,
        ).x
        new = min((judged(z) for z in (scale * ended, *met[-1:])), key=lambda found: found[:2])
        gained = new.missed < best.missed or (new.missed == best.missed and new.time < (1.0 - GAIN) * best.time)
        best = min(best, new, key=lambda found: found[:2])
        searched = searched or (gained and best.missed <= REACHED)
        if gained and best.missed <= REACHED:
            start = best.z
        elif others and not searched:
            start = others.pop()
        else:
            break
    return best.course, best.missed if best.missed > REACHED else 0.0


class Found(NamedTuple):
    """A course, how far it violates the conditions, `REACHED` where it counts as possible, its time [s] and what was searched."""

    missed: float
    time: float
    z: np.ndarray
    course: Course


def _missed(zero: Array | np.ndarray, positive: Array | np.ndarray) -> float:
    """How far conditions are violated, infinitely where one is no number."""
    most = np.max(np.concatenate([np.abs(zero), -np.asarray(positive), np.zeros(1)]))
    return float(np.where(np.isnan(most), np.inf, most))


def _between() -> Float[np.ndarray, "s c"]:
    """Mean commands of the steps by the values between which the command runs straight."""
    at = (np.arange(PIECES * STEPS) + 0.5) / STEPS
    return np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(PIECES + 1)))


def worst(values: Float[Array, " t"]) -> Float[Array, " c"]:
    """The least value in each piece of the command, both its ends included."""
    inside = values[:-1].reshape(PIECES, STEPS).min(axis=1)
    return jnp.minimum(inside, values[STEPS::STEPS])
