"""Coast-downs: the stretches of a log in which nothing drives the axis and it slides one way.

Of a joint at 0 V the motor brakes by its back-EMF, which counts as known; with torque off it does not.
"""

from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
from scipy.signal import lfilter

from rwjax.fitting.initial_guess import NO_COMMAND
from rwjax.fitting.predict import predict
from rwjax.logs.log import Log
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig

FILTER_S = 0.05
"""Time constant T of the derivative filter s/(T s + 1) [s]."""
SHORTEST_S = 1.0
"""Shortest coast-down that is used [s]."""
FEWEST = 20
"""Samples below which a coast-down is not used."""
SLOWEST = 0.02
"""Share of the fastest speed below which a coast-down is over, since the axis sticks next [1]."""
QUIET = 0.02
"""Share of a reaction wheel's largest torque above which it still brakes: too fast for a polynomial in time [1]."""


@dataclass(frozen=True)
class CoastDown:
    """One stretch without input.

    Attributes:
        time: Time from its start `(time,)` [s].
        speed: Speed against whose direction friction acts, always positive `(time,)` [rad/s].
        pushed: What else accelerates the axis in that direction `(time,)` [rad/s²].
    """

    time: np.ndarray
    speed: np.ndarray
    pushed: np.ndarray


def filtered_speed(time: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Speed of an angle through the filter $s/(Ts+1)$, exact for an angle that is straight between samples.

    Args:
        time: Times `(time,)` [s].
        angle: Angle `(time,)` [rad].

    Returns:
        Speed `(time,)` [rad/s].
    """
    grid = np.linspace(time[0], time[-1], len(time))
    slope = np.diff(np.interp(grid, time, angle)) / (grid[1] - grid[0])
    keep = np.exp(-(grid[1] - grid[0]) / FILTER_S)
    speed = np.asarray(lfilter([1.0 - keep], [1.0, -keep], np.concatenate([[0.0], slope])))
    return np.interp(time, grid, speed)


def coast_downs(rig: Rig, log: Log) -> list[CoastDown]:
    """The coast-downs of a log.

    Args:
        rig: The rig, for the torque of its wheel and of gravity.
        log: The log.

    Returns:
        The stretches that are long enough; none where the axis is not measured.
    """
    name = "yaw_rad" if "yaw_rad" in log.outputs else "yaw_rad_s"
    if name not in log.outputs:
        return []
    seen = np.isfinite(log.outputs[name])
    on = np.ones(len(log.time), bool) if log.enabled is None else log.enabled
    t, y, u = log.time[seen], log.outputs[name][seen], np.where(on, log.at_drive, 0.0)[seen]
    if len(t) < 8:
        return []
    speed = filtered_speed(t, y) if name == "yaw_rad" else y
    fastest = float(np.max(np.abs(speed)))
    wheel = _wheel_torque(rig, log)[seen]
    quiet = np.abs(wheel) <= QUIET * max(float(np.max(np.abs(wheel))), 1e-300)
    sliding = quiet & (np.abs(u) <= NO_COMMAND) & (np.abs(speed) > SLOWEST * fastest)
    way = np.where(sliding, np.sign(speed), 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], way, [0.0]])))
    push = (wheel + _gravity(rig, log)[seen] + _braking(rig, log)[seen] * speed) / coasting_inertia(rig)
    found = []
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        # the filter's own motion has died out by then
        begin = int(np.searchsorted(t, t[first] + 4.0 * FILTER_S)) if name == "yaw_rad" else first
        part = slice(begin, last)
        if way[first] and last - begin >= FEWEST and t[last - 1] - t[begin] >= SHORTEST_S:
            found.append(CoastDown(t[part] - t[begin], way[first] * speed[part], way[first] * push[part]))
    return found


def coasting_inertia(rig: Rig) -> float:
    """Inertia of an axis that coasts: of a joint with the motor's behind its gear.

    Args:
        rig: A rig with an axis.

    Returns:
        The inertia [kg m2].
    """
    structure = structure_of(rig)
    return float(one_axis_plant_of(structure, jnp.asarray(theta_of(rig, structure))).whole_inertia())


def _braking(rig: Rig, log: Log) -> np.ndarray:
    """Torque of a joint's back-EMF per rate of the axis [N m s/rad], where a voltage holds its motor's terminals."""
    if rig.kind != "joint" or log.input not in ("voltage_V", "duty"):
        return np.zeros_like(log.time)
    K, R = rig.numbers["motor.torque_constant"], rig.numbers["motor.resistance"]
    braking = -((rig.numbers.get("gear.ratio", 1.0) * K) ** 2) / R
    return np.full(len(log.time), braking) if log.enabled is None else np.where(log.enabled, braking, 0.0)


def _gravity(rig: Rig, log: Log) -> np.ndarray:
    """Torque of gravity on the axis [N m]."""
    n = rig.numbers
    if "axis.gravity.torque" not in n or "yaw_rad" not in log.outputs:
        return np.zeros_like(log.time)
    return -n["axis.gravity.torque"] * np.sin(log.outputs["yaw_rad"] + n.get("axis.gravity.angle", 0.0))


def _wheel_torque(rig: Rig, log: Log) -> np.ndarray:
    """Torque of a reaction wheel on the axis [N m], from the readings, and from a free run of the wheel for the rest."""
    if rig.kind != "reaction":
        return np.zeros_like(log.time)
    simulated = predict(rig, replace(log, outputs={}, resolution={}))
    current, rate = (
        np.where(np.isfinite(log.outputs[name]), log.outputs[name], simulated[name])
        if name in log.outputs
        else simulated[name]
        for name in ("current_A", "wheel_rad_s")
    )
    return rig.numbers.get("motor.friction", 0.0) * rate - rig.numbers["motor.torque_constant"] * current
