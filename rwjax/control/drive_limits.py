"""What a drive can give within its limits: torque at a wheel rate, and the rates that the wheel reaches."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.control.closed_loop import quasi_static, refuse_lags
from rwjax.effects.ports import CurrentLimit, WheelDry
from rwjax.errors import InputError, RigError
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.dry_friction import friction_level
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.types import Scalar

USABLE = 0.9
"""Share of the rate that the voltage reaches which a design counts on: no torque is left at that rate."""
COMMANDS = 201
"""Commands up to the limit among which the one of the largest torque is looked for: more of them may give less."""
RATES = 60
"""Wheel rates that are tried side by side."""
REFINEMENTS = 7
"""Times that the interval of rates is narrowed to its part where the torque ends."""


def turned(angle: float) -> str:
    """An angle as messages have it.

    Args:
        angle: The angle [rad].

    Returns:
        The angle in ° and in rad.
    """
    return f"{np.degrees(angle):g}° ({angle:g} rad)"


def turning(rate: float) -> str:
    """A rate of the wheel as messages have it.

    Args:
        rate: The rate [rad/s].

    Returns:
        The rate in 1/min and in rad/s.
    """
    return f"{rate * 30.0 / np.pi:g} 1/min ({rate:g} rad/s)"


class Limits(NamedTuple):
    """What the drive gives at most.

    Attributes:
        volts: Largest command [V].
        amps: Largest current [A].
        top: Largest wheel rate [rad/s].
    """

    volts: float
    amps: float = np.inf
    top: float = np.inf


def check_manoeuvre(rig: Rig, limits: Limits) -> None:
    """Refuses rigs and limits with which no manoeuvre can be planned.

    Args:
        rig: The rig.
        limits: What the drive gives.

    Raises:
        RigError: As `refuse_lags` does, and for a rig without a reaction wheel.
        InputError: For limits that are not positive.
    """
    if rig.kind != "reaction":
        raise RigError(f"kind `{rig.kind}`: there is no wheel that turns an axis; take a `reaction` rig")
    refuse_lags(rig)
    if not np.isfinite(limits.volts):
        raise InputError(f"limit `volts` {limits.volts:g}: has to be a finite number")
    for name, value in limits._asdict().items():
        if not value > 0.0:
            raise InputError(f"limit `{name}` {value:g}: has to be positive")


class AvailableTorque(NamedTuple):
    """What the drive gives at a wheel rate.

    Attributes:
        torque: Largest torque that speeds the wheel up [N m].
        by_current: Whether the current is what limits it.
    """

    torque: float
    by_current: bool


def available_torque(rig: Rig, limits: Limits, rate: float) -> AvailableTorque:
    """What the drive gives at a wheel rate, in the direction in which that is less.

    Effects of drive and motor and the wheel's friction count, as the run begins.

    Args:
        rig: The rig.
        limits: What the drive gives; `top` does not count.
        rate: Wheel rate [rad/s].

    Returns:
        Torque [N m], and whether the current limits it.
    """
    structure, theta = quasi_static(rig)
    torque, by_current = _torques(
        structure, theta, jnp.asarray(limits.volts), jnp.asarray(limits.amps), jnp.asarray(rate)
    )
    way = int(np.argmin(torque))
    return AvailableTorque(float(torque[way]), bool(by_current[way]))


@partial(jax.jit, static_argnums=0)
def _torques(
    structure: Structure, theta: Float[Array, " p"], volts: Scalar, amps: Scalar, rate: Scalar
) -> tuple[Array, Array]:
    """`available_torque` forward and backward, each with the best of `COMMANDS` commands."""
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
    """Torque that the motor has at a wheel rate within the limits of voltage and current [N m].

    Args:
        rig: The rig.
        limits: What the drive gives.
        rate: Wheel rate [rad/s].

    Returns:
        The torque [N m], in the direction in which it is less.
    """
    return available_torque(rig, limits, rate).torque


def fastest_rate(rig: Rig, limits: Limits) -> float:
    """Rate that the wheel reaches in the end within the limits [rad/s].

    Args:
        rig: The rig.
        limits: What the drive gives.

    Returns:
        The wheel rate [rad/s].
    """
    structure, theta = quasi_static(rig)
    rates = np.append(0.0, np.geomspace(1e-3, 1e6, RATES))
    for _ in range(REFINEMENTS):
        volts, amps, tried = (jnp.asarray(v) for v in (limits.volts, limits.amps, rates))
        least = np.min(_torques_at(structure, theta, volts, amps, tried), axis=1)
        last = max(int(np.argmax(least <= 0.0)) - 1, 0)  # no torque is left at a million rad/s
        rates = np.linspace(rates[last], rates[last + 1], RATES)
    return min(limits.top, float(rates[0]))


@partial(jax.jit, static_argnums=0)
def _torques_at(
    structure: Structure, theta: Float[Array, " p"], volts: Scalar, amps: Scalar, rates: Float[Array, " r"]
) -> Float[Array, "r 2"]:
    """Torques [N m] forward and backward at many wheel rates."""
    return jax.vmap(lambda rate: _torques(structure, theta, volts, amps, rate)[0])(rates)


def usable_rate(rig: Rig, limits: Limits) -> float:
    """Wheel rate [rad/s] that a design counts on: the given one, but no more than `USABLE` of what the voltage reaches.

    Args:
        rig: The rig.
        limits: What the drive gives.

    Returns:
        The wheel rate [rad/s].

    Raises:
        InputError: Where no torque is left at that rate.
    """
    rate = min(limits.top, USABLE * fastest_rate(rig, limits._replace(top=np.inf)))
    if not (rate > 0.0 and torque_at(rig, limits, rate) > 0.0):
        what = f"no torque is left at a wheel rate of {turning(rate)}"
        short = "amps" if available_torque(rig, limits, 0.0).by_current else "volts"
        raise InputError(
            f"{short} {getattr(limits, short):g}: {what}; raise the voltage or the current, or take a lower rate"
        )
    return rate
