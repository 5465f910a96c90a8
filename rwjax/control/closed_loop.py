"""The nonlinear closed loop: the whole plant with stick and slip, an encoder in counts, a sampled controller and its limits.

Every entry of `Controller` and of the plant's numbers may be an array under `jax.vmap`; what decides the shape of the
computation stands in `LoopTiming`.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.linear import lateness, linearised, transfer
from rwjax.control.region import waits
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import AxisElastic, CommandFilter, Coupling
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import Structure, friction_level
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import one_axis_plant_of
from rwjax.simulation.step import propagator, step, with_friction
from rwjax.types import Scalar

LEAST, FARTHEST, COMMANDS = 1e-6, 1e6, 600
"""V between which a command is looked for, and how many are tried: what a drive gives may fall again with more of it."""


class Controller(NamedTuple):
    r"""$u = K_p e + K_i \int e + K_d \dot e + u_d\,\mathrm{sgn}\,e$, clipped; `kp` V/rad, `ki` V/(rad s), `kd` V s/rad.

    `smooth` [s]: time constant of the derivative's filter; `forward` [V]: what overcomes dry friction, fed forward where
    the error is larger than `dead` [rad]; `limit` [V]: largest command; `spin` [rad/s]: wheel rate from which on a command
    that drives it further is held to what keeps that rate. The integral stands still while the command is clipped or held and
    the error drives it further.
    """

    kp: Scalar | float
    ki: Scalar | float = 0.0
    kd: Scalar | float = 0.0
    smooth: Scalar | float = 0.0
    forward: Scalar | float = 0.0
    dead: Scalar | float = 0.0
    limit: Scalar | float = np.inf
    spin: Scalar | float = np.inf


class LoopTiming(NamedTuple):
    """`period` [s] of the controller; `steps` of the plant in it; how many of such steps after its reading a command acts, `late`, a
    part of one or more than a period too; `counts` per turn of the encoder, 0 where it reads the angle itself."""

    period: float = 0.01
    steps: int = 4
    late: float = 0.0
    counts: int = 0

    @property
    def lateness(self) -> float:
        """Time from a reading to its command [s]."""
        return self.late * self.period / self.steps

    @property
    def waits(self) -> tuple[int, float]:
        """Whole periods in which a command only waits, and the steps of the next one after which it acts."""
        return waits(self.late, float(self.steps))

    def later(self, time: float) -> "LoopTiming":
        """The clockwork whose commands act `time` [s] later still."""
        return self._replace(late=self.late + time * self.steps / self.period)


class Run(NamedTuple):
    """What happened at the controller's samples `(s,)`, before each of them acts: `angle` [rad] and `rate` [rad/s] of the
    axis, the `command` [V] that follows, `wheel` rate [rad/s] (0 where there is none). Where readings are late, all of it as it
    was at the instant that is read."""

    angle: Float[Array, " s"]
    rate: Float[Array, " s"]
    command: Float[Array, " s"]
    wheel: Float[Array, " s"]


@partial(jax.jit, static_argnums=(0, 2))
def closed_loop(
    structure: Structure,
    theta: Float[Array, " p"],
    clockwork: LoopTiming,
    controller: Controller,
    reference: Float[Array, " s"],
    start: Float[Array, " n"],
    sign: Scalar | float,
) -> Run:
    """One run of the loop along a `reference` [rad] at the controller's samples, from a first state; `sign` of the plant.

    Maps of the command (dead zone, saturation and the like) act as they do in a log. Delays of command and reading are `late` in
    the clockwork (`posed`): from one reading to the next a loop knows only their sum. Lags and rate limits are not in it.
    """
    plant, states = one_axis_plant_of(structure, theta), structure.states
    h = jnp.asarray(clockwork.period / clockwork.steps)
    p, c = propagator(plant, h), controller
    spins = states.index("Omega") if "Omega" in states else None
    whole, part = clockwork.waits

    def sense(t: Scalar, x: tuple, u: Scalar) -> Scalar:
        y = plant.outputs(t, x, u, x)[structure.outputs.index("yaw_rad")]
        return (
            jnp.round(y * clockwork.counts / (2.0 * np.pi)) * (2.0 * np.pi / clockwork.counts)
            if clockwork.counts
            else y
        )

    def sample(carry: tuple, wanted: Scalar) -> tuple[tuple, tuple]:
        t, x, before, slope, integral, held = carry  # held: commands that act or wait, the newest first
        error = wanted - sense(t, x, held[-1])
        slope = (c.smooth * slope + error - before) / (c.smooth + clockwork.period)
        forward = c.forward * jnp.where(jnp.abs(error) > c.dead, jnp.sign(error), 0.0)
        asked = c.kp * error + c.ki * integral + c.kd * slope + forward
        given = jnp.clip(asked, -c.limit, c.limit)
        new = sign * given
        if spins is not None:
            fast = (jnp.abs(x[spins]) >= c.spin) & (jnp.sign(new) == jnp.sign(x[spins]))
            new = jnp.where(fast, jnp.sign(new) * jnp.minimum(jnp.abs(new), holding(plant.numbers) * c.spin), new)
        winds = (sign * new != asked) & (jnp.sign(asked) == jnp.sign(error))
        integral = integral + jnp.where(winds, 0.0, clockwork.period * error)
        at = (x[states.index("psi")], x[states.index("w")], new, x[spins] if spins is not None else jnp.zeros_like(new))
        held = jnp.concatenate([new[None], held])
        acts = plant.act(held[-1]), plant.act(held[-2])

        def within(carry: tuple, k: Scalar) -> tuple[tuple, None]:  # unrolled it would take four times as long
            t, x = carry
            old = jnp.clip(part - k, 0.0, 1.0)  # share of the step in which the command before acts
            return (t + h, step(plant, p, t, x, old * acts[0] + (1.0 - old) * acts[1], h)), None

        (t, x), _ = jax.lax.scan(within, (t, x), jnp.arange(float(clockwork.steps)))
        return (t, x, error, slope, integral, held[:-1]), at

    first = tuple(start[k] for k in range(len(states)))
    zero = jnp.zeros(())
    error = reference[0] - sense(zero, first, zero)
    _, found = jax.lax.scan(sample, (zero, first, error, zero, zero, jnp.zeros(whole + 1)), reference)
    return Run(*found)


def holding(numbers: Mapping[str, Scalar | float]) -> Scalar | float:
    r"""Voltage per rate that keeps a wheel turning against its back-EMF and viscous friction, $K + R\,b/K$ [V s/rad]."""
    K, R = numbers["motor.torque_constant"], numbers["motor.resistance"]
    return K + R * numbers.get("motor.friction", 0.0) / K


def run_rig(
    rig: Rig,
    controller: Controller,
    reference: Float[np.ndarray, " s"],
    clockwork: LoopTiming = LoopTiming(),  # noqa: B008 (a tuple, which nothing changes)
    **start: float,
) -> Run:
    """The closed loop of a rig from rest, or from states given by name; its own delays come on top of the clockwork's.

    Raises `InputError` as `posed` does, and for a state that the rig lacks.
    """
    structure, theta, delayed, sign = posed(rig, clockwork, controller)
    if strange := sorted({*start} - {*structure.states}):
        raise InputError(f"no state `{strange[0]}`; this rig has {', '.join(structure.states)}")
    first = jnp.array([start.get(name, 0.0) for name in structure.states])
    values = Controller(*(jnp.asarray(float(v)) for v in controller))
    return closed_loop(structure, theta, delayed, values, jnp.asarray(reference), first, sign)


def without_lags(rig: Rig) -> None:
    """Raises `InputError` for a rig with a lag or a rate limit of its drive, which neither loops nor manoeuvres have."""
    if lags := [name for name in rig.effects if issubclass(BY_NAME[name], CommandFilter)]:
        raise InputError(f"`{lags[0]}`: lags and rate limits are not simulated here, leave it out")


def posed(
    rig: Rig, clockwork: LoopTiming, *controllers: Controller
) -> tuple[Structure, Float[Array, " p"], LoopTiming, float]:
    """Structure, parameter vector, clockwork with the rig's own delays, and sign of a rig whose loop is to be closed by one of these.

    Raises `InputError` as `linearised` and `without_lags` do, and for a limit of the wheel's rate beside a late reading of the
    angle: the loop is run as if all that the controller reads were late alike.
    """
    without_lags(rig)
    structure, late = structure_of(rig), lateness(rig)
    if structure.has_wheel and late.readings[0] > 0.0 and any(np.isfinite(float(law.spin)) for law in controllers):
        raise InputError(
            f"the wheel's rate is read at once and the angle {late.readings[0]:g} s late, which is not simulated; leave the limit of "
            "the wheel's rate out, or the delay of the encoder"
        )
    sign = float(np.sign(transfer(linearised(rig)).num[0]))
    return structure, jnp.asarray(theta_of(rig, structure)), clockwork.later(float(late.loop[0])), sign


def settled(rig: Rig) -> tuple[Structure, Float[Array, " p"]]:
    """Structure and parameter vector of a rig whose currents and couplings have settled, without what comes and goes: its
    inductance, couplings, ripple and periodic torque left out."""
    numbers = {name: value for name, value in rig.numbers.items() if name != "motor.inductance"}
    gone = [name for name in rig.effects if issubclass(BY_NAME[name], Coupling) or BY_NAME[name].comes_and_goes]
    effects = {name: given for name, given in rig.effects.items() if name not in gone}
    still = replace(rig, numbers=numbers, effects=effects)
    structure = structure_of(still)
    return structure, jnp.asarray(theta_of(still, structure))


@partial(jax.jit, static_argnums=0)
def _spare(structure: Structure, theta: Float[Array, " p"], commands: Float[Array, " c"]) -> Float[Array, " c"]:
    """Torque [N m] on the axis at rest at 0 beyond what friction holds against turning forward, by commands."""
    plant, zero, w = one_axis_plant_of(structure, theta), jnp.zeros(()), structure.states.index("w")
    elastic = [f"{effect.name}:z" for effect in plant.on(AxisElastic)]  # before it slides, all of it is built up
    rest = tuple(jnp.ones(()) if name in elastic else zero for name in structure.states)

    def one(command: Scalar) -> Scalar:
        volts = plant.act(command)
        rates, torques = with_friction(plant, zero, rest, volts, rest)
        for (body, dry), (free, _) in zip(plant.bodies(), torques, strict=True):
            if body.rate == w:
                return free - friction_level(dry, plant.motion(zero, rest, volts), 1.0)
        return rates[w] * plant.numbers["axis.inertia"]

    return jax.vmap(one)(commands)


def breakaway(rig: Rig) -> float:
    """Command [V] at which the axis of a rig at rest at angle 0 breaks loose towards positive angles, its wheel standing: what to
    feed forward against dry friction, the wheel's included, a load and a dead zone; 0 where the load alone turns it that way.
    Friction that grows with the drive's torque, a limited current and what else the plant has count; as the run begins.

    Raises `InputError` as `linearised` does, and where the drive never gives so much.
    """
    sign = float(np.sign(transfer(linearised(rig)).num[0]))
    structure, theta = settled(rig)
    commands = np.append(0.0, np.geomspace(LEAST, FARTHEST, COMMANDS))
    spare = np.asarray(_spare(structure, theta, jnp.asarray(sign * commands)))
    if not np.any(spare > 0.0):
        raise InputError(
            f"the drive never gives the torque at which the axis breaks loose; at its most {-np.max(spare):.3g} N m are missing"
        )
    first = int(np.argmax(spare > 0.0))
    low, high = commands[max(first - 1, 0)], commands[first]
    for _ in range(50):
        middle = 0.5 * (low + high)
        enough = float(_spare(structure, theta, jnp.asarray([sign * middle]))[0]) > 0.0
        low, high = (low, middle) if enough else (middle, high)
    return float(low)
