"""Typical sizes of commands, torques and rates in a set of logs: the units in which an unknown number is searched."""

from collections.abc import Callable, Sequence

import numpy as np

from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.kinds import GIVEN, HALVES, SERVO, of_half
from rwjax.logs.half_log import half_log
from rwjax.logs.log import Log
from rwjax.logs.segments import whole_runs
from rwjax.plant.structure import Structure
from rwjax.rig.half_rig import half_rig
from rwjax.rig.model import Rig

SIZE_OF = {
    "coulomb": "torque",
    "static": "torque",
    "torque": "torque",
    "viscous": "torque_per_rate",
    "b3": "torque",
    "b2": "torque_per_rate",
    "b1": "torque_per_rate2",
    "b0": "torque_per_rate3",
    "angle": "one",
    "friction": "damping",
    "inductance": "henry",
    "motor.inertia": "rotor",
    "difference": "inertial",
    "product_xy": "inertial",
    "product_xz": "inertial",
    "product_yz": "inertial",
}
"""Which scale is typical of a number of the rig, by its name or the end of that; of those that may be 0."""


def _fastest(log: Log) -> float | None:
    """Fastest yaw rate of a log [rad/s], from the rate or from differences of the angle; None where neither is logged."""
    for name in ("yaw_rad_s", "yaw_rad"):
        if name in log.outputs:
            y, t = log.outputs[name], log.time
            seen = np.isfinite(y)
            y, t = y[seen], t[seen]
            stride = max(1, len(t) // 200)
            rate = np.diff(y[::stride]) / np.diff(t[::stride]) if name == "yaw_rad" else y
            return float(np.max(np.abs(rate), initial=0.0))
    return None


def scales(rig: Rig, logs: Sequence[Log]) -> dict[str, float]:
    """Typical sizes in a set of logs, by the names used in `param(scale=…)`.

    Args:
        rig: A rig with one axis or none.
        logs: The logs.

    Returns:
        Typical command [V], torque [N m], rates [rad/s], current [A], angles [rad], and quotients of these.
    """
    n = rig.numbers
    command = max(float(np.sqrt(np.mean(np.concatenate([log.at_drive for log in logs]) ** 2))), 1e-9)
    gain = _torque_per_command(rig)
    rate = max([*(fastest for log in logs if (fastest := _fastest(log)) is not None), 1e-3])
    angles = np.concatenate([log.outputs["yaw_rad"] for log in logs if "yaw_rad" in log.outputs] or [np.zeros(1)])
    peak = max(float(np.max(np.abs(log.at_drive), initial=0.0)) for log in logs)
    currents = [float(np.nanmax(np.abs(log.outputs["current_A"]))) for log in logs if "current_A" in log.outputs]
    ohm, K = n.get("motor.resistance", 1.0), n.get("motor.torque_constant", 1.0)
    ampere, spin = command / ohm, command / K
    step = float(np.median(np.concatenate([np.diff(log.time) for log in logs])))
    return {
        "one": 1.0,
        "command": command,
        "peak": max(peak, 1e-9),
        "peak_ampere": max([*currents, 0.0 if currents else peak / ohm, 1e-9]),
        "torque": gain * command,
        "rate": rate,
        "torque_per_rate": gain * command / rate,
        "torque_per_rate2": gain * command / rate**2,
        "torque_per_rate3": gain * command / rate**3,
        "damping": 0.1 * K**2 / ohm,  # a tenth of what the back-EMF does
        "henry": 0.1 * ohm * step,
        "spin": spin,
        "torque_per_spin2": gain * command / spin**2,
        "sensed_rate": rate if rig.kind != "wheel" else spin,
        "inertial": n.get("axis.inertia", 1.0),
        "rotor": n.get("axis.inertia", 1.0) / n.get("gear.ratio", 1.0) ** 2,
        "ampere": ampere,
        "per_ampere2": ampere**-2,
        "per_command": 1.0 / command,
        "per_watt": 1.0 / (command * (ampere if "motor.torque_constant" in n else 1.0)),
        "per_rate": 1.0 / rate,
        "turn_per_run": 2.0 * np.pi / max(*(run.time[-1] - run.time[0] for run in whole_runs(logs)), 1e-9),
        "highest": float(np.nanmax(angles)),
        "lowest": float(np.nanmin(angles)),
        "span": float(np.nanmax(angles) - np.nanmin(angles)),
    }


def _torque_per_command(rig: Rig) -> float:
    """Torque of a motor that stands still, or of a joint behind its gear, for what its drive is given [N m/V, N m/A or 1]."""
    n, ratio = rig.numbers, rig.numbers.get("gear.ratio", 1.0)
    given = GIVEN.get(rig.driven.by) or (rig.servo.acts_on if rig.servo is not None else "voltage")
    if rig.kind == "platform":
        return abs(n["drive.gain"])
    if given == "torque":
        return 1.0
    amperes = 1.0 if given == "current" else 1.0 / n["motor.resistance"]
    volts = n.get("drive.supply", 1.0) if given == "duty" and not rig.driven.supplied else 1.0
    return n["motor.torque_constant"] * amperes * volts * ratio


def scales_for(rig: Rig, logs: Sequence[Log]) -> Callable[[str], dict[str, float]]:
    """`scales` for a number or an effect by its name.

    Args:
        rig: The rig.
        logs: The logs.

    Returns:
        A function from a name to its scales. On a two-axis rig they are those of the half that the name belongs to, or
        of pitch where it belongs to neither.
    """
    if rig.kind != "two_axis":
        whole = scales(rig, logs)
        return lambda name: whole
    of = [scales(half_rig(rig, k), [half_log(log, k) for log in logs]) for k in range(len(HALVES))]

    def sizes(name: str) -> dict[str, float]:
        found = of_half(name)
        return of[1 if found is None else found[0]]

    return sizes


def _size_in_servo(rig: Rig, name: str) -> float:
    """Typical size of a number of a servo, whose value may be 0 [SI]."""
    kp, period = rig.numbers[f"{SERVO}.kp"], rig.numbers[f"{SERVO}.period"]
    return {"ki": 10.0 * kp, "kd": kp * period, "derivative_filter": period, "phase": period}.get(
        name.removeprefix(f"{SERVO}."), 0.0
    )


def sizes_of(rig: Rig, structure: Structure, theta: np.ndarray, logs: Sequence[Log]) -> np.ndarray:
    """Size of every number: its own, or a tenth of what is typical of its kind where that is larger.

    Args:
        rig: The rig.
        structure: Its structure.
        theta: The structure's numbers `(p,)` [SI].
        logs: The logs.

    Returns:
        Sizes `(p,)` [SI], positive.
    """
    sizes = scales_for(rig, logs)
    size = np.abs(theta)
    for k, name in enumerate(structure.names):
        typical = sizes(name)
        if k < len(structure.numbers):
            scale = SIZE_OF.get(name) or SIZE_OF.get(name.rpartition(".")[2])
            least = typical[scale] if scale else 0.0
            least = _size_in_servo(rig, name) if name.startswith(f"{SERVO}.") else least
        else:
            effect, _, parameter = name.rpartition(".")
            least = abs(typical[parameters(BY_NAME[effect])[parameter].scale])
            size[k] = size[k] if size[k] < 1e5 else 0.0  # a limit that is far off says nothing about sizes
        size[k] = max(size[k], 0.1 * least, 1e-12)
    return size
