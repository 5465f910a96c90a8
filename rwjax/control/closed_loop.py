"""The nonlinear closed loop: the whole plant with stick and slip, an encoder in counts, a sampled controller and its limits."""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.controller import DEFAULT_TIMING, Controller, LoopTiming, wheel_holding_voltage
from rwjax.control.delays import delays_of
from rwjax.control.linear import linearised
from rwjax.control.transfer import transfer
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import CommandFilter, Coupling
from rwjax.errors import InputError, RigError
from rwjax.lowering.arrays import Spread
from rwjax.lowering.kept import lowered
from rwjax.plant import servo
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.types import Scalar


class ClosedLoopRun(NamedTuple):
    """What a loop does, at the controller's samples `(s,)` before each of them acts.

    Where readings are late, all of it is as it was at the instant that is read.

    Attributes:
        angle: Angle of the axis [rad], `(s,)`.
        rate: Rate of the axis [rad/s], `(s,)`.
        command: Command that follows [V], `(s,)`.
        wheel: Wheel rate [rad/s], `(s,)`; 0 where there is no wheel.
    """

    angle: Float[Array, " s"]
    rate: Float[Array, " s"]
    command: Float[Array, " s"]
    wheel: Float[Array, " s"]


class _LoopState(NamedTuple):
    """State of plant and controller at a sample. `held`: commands that act or wait [V], the newest first."""

    time: Scalar
    plant: tuple
    error: Scalar
    slope: Scalar
    integral: Scalar
    held: Float[Array, " k"]


@partial(jax.jit, static_argnums=(0, 2))
def closed_loop(
    structure: Structure,
    theta: Float[Array, " p"],
    timing: LoopTiming,
    controller: Controller,
    reference: Float[Array, " s"],
    start: Float[Array, " n"],
    sign: Scalar | float,
) -> ClosedLoopRun:
    """One run of the loop along a reference.

    Maps of the command (dead zone, saturation and the like) act as they do in a log. The rig's delays of command and
    reading are part of `timing.delay` (`loop_setup`): a loop knows only their sum. Lags and rate limits are not simulated.

    Args:
        structure: Structure of the plant.
        theta: Parameter vector of that structure, `(p,)` [SI].
        timing: When the controller reads and acts, the rig's own delays included.
        controller: Gains and limits.
        reference: Angle that is wanted [rad] at the controller's samples, `(s,)`.
        start: First state of the plant in the structure's order, `(n,)` [SI].
        sign: Sign of the plant [1], with which positive gains restore.

    Returns:
        The run at the controller's samples, `(s,)`.
    """
    plant, states = one_axis_plant_of(structure, theta), structure.states
    h = jnp.asarray(timing.period / timing.steps)
    p, c = EXPONENTIAL_STEP.prepare(plant, h), controller
    wheel = states.index("Omega") if "Omega" in states else None
    whole, part = timing.delay_parts

    def sample(state: _LoopState, wanted: Scalar) -> tuple[_LoopState, tuple]:
        t, x, before, slope, integral, held = state
        error = wanted - _reading(plant, timing, t, x, held[-1])
        slope = servo.slope(slope, before, error, c.filter_time, timing.period)
        feedforward = c.feedforward * jnp.where(jnp.abs(error) > c.deadband, jnp.sign(error), 0.0)
        asked = c.kp * error + c.ki * integral + c.kd * slope + feedforward
        given = jnp.clip(asked, -c.voltage_limit, c.voltage_limit)
        new = sign * given
        if wheel is not None:
            new = _wheel_rate_held(plant, controller, new, x[wheel])
        integral = servo.integral(integral, error, asked, sign * new, timing.period)
        seen = (
            x[states.index("psi")],
            x[states.index("w")],
            new,
            x[wheel] if wheel is not None else jnp.zeros_like(new),
        )
        held = jnp.concatenate([new[None], held])
        acts = plant.act(held[-1]), plant.act(held[-2])

        def within(carry: tuple, k: Scalar) -> tuple[tuple, None]:  # unrolled it would take four times as long
            t, x = carry
            old = jnp.clip(part - k, 0.0, 1.0)  # share of the step in which the command before acts
            return (t + h, EXPONENTIAL_STEP.step(plant, p, t, x, old * acts[0] + (1.0 - old) * acts[1], h)), None

        (t, x), _ = jax.lax.scan(within, (t, x), jnp.arange(float(timing.steps)))
        return _LoopState(t, x, error, slope, integral, held[:-1]), seen

    first = tuple(start[k] for k in range(len(states)))
    zero = jnp.zeros(())
    error = reference[0] - _reading(plant, timing, zero, first, zero)
    begin = _LoopState(zero, first, error, zero, zero, jnp.zeros(whole + 1))
    _, found = jax.lax.scan(sample, begin, reference)
    return ClosedLoopRun(*found)


def _reading(plant: OneAxis, timing: LoopTiming, t: Scalar, x: tuple, u: Scalar) -> Scalar:
    """Angle that the controller reads [rad], in counts where the encoder has them."""
    y = plant.outputs(t, x, u, x)[plant.structure.outputs.index("yaw_rad")]
    if not timing.counts:
        return y
    return jnp.round(y * timing.counts / (2.0 * np.pi)) * (2.0 * np.pi / timing.counts)


def _wheel_rate_held(plant: OneAxis, controller: Controller, command: Scalar, rate: Scalar) -> Scalar:
    """A command [V] that does not drive a wheel beyond its limit at this rate [rad/s]."""
    most = controller.wheel_rate_limit
    fast = (jnp.abs(rate) >= most) & (jnp.sign(command) == jnp.sign(rate))
    held = jnp.sign(command) * jnp.minimum(jnp.abs(command), wheel_holding_voltage(plant.numbers) * most)
    return jnp.where(fast, held, command)


def run_rig(
    rig: Rig,
    controller: Controller,
    reference: Float[np.ndarray, " s"],
    timing: LoopTiming = DEFAULT_TIMING,
    **start: float,
) -> ClosedLoopRun:
    """The closed loop of a rig.

    Args:
        rig: The rig; its own delays come on top of the timing's.
        controller: Gains and limits.
        reference: Angle that is wanted [rad] at the controller's samples, `(s,)`.
        timing: When the controller reads and acts.
        **start: First states by name [SI]; those not given are 0, the axis at rest at angle 0.

    Returns:
        The run at the controller's samples, `(s,)`.

    Raises:
        InputError: As `loop_setup` does, and for a state that the rig lacks.
    """
    structure, theta, delayed, sign = loop_setup(rig, timing, controller)
    if unknown := sorted({*start} - {*structure.states}):
        raise InputError(f"no state `{unknown[0]}`; this rig has {', '.join(structure.states)}")
    first = jnp.array([start.get(name, 0.0) for name in structure.states])
    values = np.array(controller, float)

    def function(theta: Array, gains: Array, reference: Array, first: Array, sign: Array) -> tuple[Array, ...]:
        return tuple(closed_loop(structure, theta, delayed, Controller(*gains), reference, first, sign))

    arguments = [np.asarray(theta), values, np.asarray(reference, float), np.asarray(first), np.array(sign)]
    known = (structure, delayed)
    program = lowered("closed_loop", known, function, arguments, [Spread()] * len(arguments), structure.from_library)
    if program is not None:
        return ClosedLoopRun(*map(jnp.asarray, program(arguments)))
    return closed_loop(structure, theta, delayed, Controller(*map(jnp.asarray, values)), *arguments[2:])


class LoopSetup(NamedTuple):
    """What a simulation of the loop takes from a rig.

    Attributes:
        structure: Structure of the plant.
        theta: Parameter vector of that structure, `(p,)` [SI].
        timing: Timing of the controller with the rig's own delays.
        sign: Sign of the plant [1], with which positive gains restore.
    """

    structure: Structure
    theta: Float[Array, " p"]
    timing: LoopTiming
    sign: float


def loop_setup(rig: Rig, timing: LoopTiming, *controllers: Controller) -> LoopSetup:
    """What a simulation of the loop takes from a rig that one of some controllers is to close.

    Args:
        rig: The rig.
        timing: When the controllers read and act, without the rig's own delays.
        *controllers: Gains and limits.

    Returns:
        Structure, parameter vector, timing with the rig's delays, and sign of the plant.

    Raises:
        InputError: As `linearised` and `refuse_lags` do, and for a limit of the wheel's rate beside a late reading of the
            angle, since the loop is run as if all that the controller reads were late alike.
    """
    refuse_lags(rig)
    structure, delays = structure_of(rig), delays_of(rig)
    limited = any(np.isfinite(float(law.wheel_rate_limit)) for law in controllers)
    if structure.has_wheel and delays.readings[0] > 0.0 and limited:
        raise InputError(
            f"the wheel's rate is read at once and the angle {delays.readings[0]:g} s late, which is not simulated; leave the limit of "
            "the wheel's rate out, or the delay of the encoder"
        )
    timing = timing.with_extra_delay(float(delays.loop[0]))
    return LoopSetup(structure, jnp.asarray(theta_of(rig, structure)), timing, plant_sign(rig))


def plant_sign(rig: Rig) -> float:
    """Sign of a plant [1]: -1 where a positive command turns the axis backward.

    Args:
        rig: The rig.

    Returns:
        1 or -1.

    Raises:
        InputError: As `linearised` and `transfer` do.
    """
    return float(np.sign(transfer(linearised(rig)).num[0]))


def refuse_lags(rig: Rig) -> None:
    """Refuses a lag or a rate limit of the drive, which neither loops nor manoeuvres simulate.

    Args:
        rig: The rig.

    Raises:
        RigError: For a rig with such an effect.
    """
    if lags := [name for name in rig.effects if issubclass(BY_NAME[name], CommandFilter)]:
        raise RigError(f"`{lags[0]}`: lags and rate limits are not simulated here, leave it out")


def quasi_static(rig: Rig) -> tuple[Structure, Float[Array, " p"]]:
    """A rig whose currents and couplings have settled, without what comes and goes.

    The inductance, couplings, the motor's ripple and the periodic torque are left out.

    Args:
        rig: The rig.

    Returns:
        Structure of its plant, and parameter vector of that structure `(p,)` [SI].
    """
    numbers = {name: value for name, value in rig.numbers.items() if name != "motor.inductance"}
    gone = [name for name in rig.effects if issubclass(BY_NAME[name], Coupling) or BY_NAME[name].comes_and_goes]
    effects = {name: given for name, given in rig.effects.items() if name not in gone}
    still = replace(rig, numbers=numbers, effects=effects)
    structure = structure_of(still)
    return structure, jnp.asarray(theta_of(still, structure))
