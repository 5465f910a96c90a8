"""Where: the missing torque read off the logs, and what it is a function of.

What it is a function of is judged in free run: by the share of the excess error that the best law in a coordinate removes. A free run
sees small lasting torques that drown in the noise of a measured acceleration. The measured angle or speed is smoothed with an
acceleration (jerk for angles) that is a random walk. What the fitted rig cannot account for in the smoothed motion is the missing
torque, with the smoother's own standard deviation. The same steps are taken with readings that the fitted rig itself would have
given. What they make of these is the level against which regimes and bands stand out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np

from rwjax.diagnosis.localise.body_motion import Own, Read, read_body
from rwjax.diagnosis.localise.momentum import Momentum, split
from rwjax.diagnosis.localise.own_noise import rates
from rwjax.diagnosis.localise.regimes import Part, bands, regimes, weights
from rwjax.diagnosis.localise.regimes import shares as regime_shares
from rwjax.diagnosis.localise.spectrum import OctavePower, octave_power
from rwjax.diagnosis.settings import LocalisationSettings, RegimeSettings
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import Clock, CommandDelay, CommandFilter, Encoder, EncoderDelay, GoalDelay, Reading
from rwjax.fitting.initial_guess import NO_COMMAND, NO_SHARE
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.prediction import every_output
from rwjax.logs.log import Log
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.structure import Structure


@dataclass(frozen=True)
class Missing:
    """Missing torque of one log.

    Attributes:
        log: number of the log.
        torque: missing torque (time,) [N m].
        deviation: its standard deviation (time,) [N m].
        coordinates: what it may be a function of, at the same times (time,) [SI].
        own: missing torque that the fitted rig's own readings would show (time, draws) [N m].
        still: whether the body rests, in the log and in draws (time, 1 + draws).
        speed: speed of the body, in the log and in draws (time, 1 + draws) [rad/s].
    """

    log: int
    torque: np.ndarray
    deviation: np.ndarray
    coordinates: dict[str, np.ndarray]
    own: np.ndarray
    still: np.ndarray
    speed: np.ndarray


@dataclass(frozen=True)
class Where:
    """Where the gap lies.

    Attributes:
        coordinate: what the missing part is a function of.
        share: share of the excess squared error of the training logs that the best law in it removes [1].
        drawn: the logged coordinate over which the missing torque is laid.
        interval: range of `coordinate` [SI] that holds four fifths of the missing torque's square, where it was logged.
        shares: the same as `share` for every coordinate [1].
        missing: missing torque of each log.
        regimes: shares of the regimes.
        bands: shares of the frequency bands.
        momentum: which side of the motor lacks a torque.
    """

    coordinate: str
    share: float
    drawn: str | None
    interval: tuple[float, float] | None
    shares: dict[str, float]
    missing: tuple[Missing, ...]
    regimes: tuple[Part, ...] = ()
    bands: tuple[Part, ...] = ()
    momentum: Momentum | None = None

    def json(self) -> dict:
        """Shares by coordinate, regimes, bands and momentum as `diagnosis.json` holds them.

        Returns:
            Plain objects.
        """
        return {
            "shares": self.shares,
            "regimes": [{"regime": r.name, "share": r.share, "of_time": r.of_time, "p": r.p} for r in self.regimes],
            "bands": [
                {"from_hz": b.low, "to_hz": b.high, "share": b.share, "of_noise": b.of_time, "p": b.p}
                for b in self.bands
            ],
            "momentum": self.momentum.json() if self.momentum is not None else None,
        }


def missing_torque(
    fitted: Fit, number: int, clean: dict[str, np.ndarray], read: Read, limits: LocalisationSettings
) -> Missing:
    """Missing torque of one log on the axis, or on the wheel where there is no axis.

    It is the inertia times the acceleration that the fitted plant cannot account for along the smoothed motion.

    Args:
        fitted: the fit of the rig as it is.
        number: number of the log.
        clean: readings of the rig's own free run by output (time,) [SI].
        read: motion of the body, and draws of it.
        limits: limits of the localisation.

    Returns:
        The missing torque of the log and of the draws.
    """
    log = fitted.problem.logs[number]
    structure = fitted.problem.structure
    kind = structure.kind
    position, w, a = read.position(log.time), read.rate, read.acceleration
    w_sd, a_sd = read.deviation
    still = np.abs(w) <= limits.still * np.median(w_sd)
    speed = np.where(still, 0.0, w)
    body = {"theta": position, "Omega": speed} if kind == "wheel" else {"psi": position, "w": speed}
    rest = _rest_of(fitted, log, clean)
    drawn = {state: clean[name] for state, name in _READ_AS.items() if name in clean}
    states = {s: np.broadcast_to(np.zeros(()), w.shape) for s in structure.states}
    for s in rest:
        own = np.broadcast_to(drawn[s][:, None], (len(w), w.shape[1] - 1))
        states[s] = np.concatenate([rest[s][:, None], own], axis=1)
    states = {s: body.get(s, x) for s, x in (states | body).items() if s in structure.states}
    moving = "Omega" if kind == "wheel" else "w"
    along = rates(fitted, log, fitted.theta, states, log.at_drive, limits.chunk)[moving]
    theta = fitted.theta[: len(structure.names)] + np.array(structure.vector(log.added))
    plant = one_axis_plant_of(structure, jnp.asarray(theta))
    inertia = float(plant.numbers["wheel.inertia"] if kind == "wheel" else plant.whole_inertia())
    torque = inertia * (np.where(still, 0.0, a) - along)
    where = _coordinates(kind, log, w[:, 0], position[:, 0], rest)
    return Missing(number, torque[:, 0], inertia * a_sd, where, torque[:, 1:], still, w)


def _coordinates(
    kind: str, log: Log, w: np.ndarray, position: np.ndarray, rest: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """What the missing torque of a body with speed `w` and angle `position` may be a function of."""
    found = {("wheel_rate" if kind == "wheel" else "yaw_rate"): w, "time": log.time - log.origin}
    found["voltage"] = log.at_drive
    found["wheel_angle" if kind == "wheel" else "yaw"] = np.mod(position, 2.0 * np.pi)
    if "i" in rest:
        found["current"] = rest["i"]
    if kind == "reaction":
        found["wheel_rate"] = rest["Omega"]
    return found


BESIDE_THE_PLANT = (CommandDelay, CommandFilter, GoalDelay, Encoder, EncoderDelay, Reading, Clock)
"""Ports before and behind the plant's equations: along a measured motion these show nothing of them."""
_READ_AS = {"i": "current_A", "Omega": "wheel_rad_s"}
"""Output that tells a state other than the body's own."""


def _rest_of(fitted: Fit, log: Log, clean: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Current and wheel rate at a log's times: measured where they are, else of the fitted free run."""
    found = {}
    for state, name in _READ_AS.items():
        if name in clean:
            measured = log.outputs.get(name, clean[name])
            found[state] = np.where(np.isfinite(measured), measured, clean[name])
    return found


def locate(
    fitted: Fit,
    logs: Sequence[int],
    shares: dict[str, float],
    coordinate: str | None,
    limits: LocalisationSettings,
    *,
    deep: bool = True,
) -> Where | None:
    """Where the gap lies: the missing torque of the rig as it is, laid over the coordinate of which it is a function.

    Of a two-axis rig, whose axes push one another, no missing torque is read off: only the shares are told.

    Args:
        fitted: the fit of the rig as it is.
        logs: numbers of the training logs.
        shares: share of the excess that the best law in each coordinate removes [1].
        coordinate: the coordinate of the named effect, None where none is named.
        limits: limits of the localisation.
        deep: whether regimes, bands and momentum are worked out besides.

    Returns:
        Where the gap lies, None where nothing was tried and no effect is named.
    """
    clean = every_output(fitted.problem, fitted.theta, fitted.start)
    read = _read_logs(fitted, logs, clean, limits, limits.draws if deep else 0)
    told = tells_torque(fitted.problem.structure)
    found = [missing_torque(fitted, k, clean[k], r, limits) for k, r in read.items()] if told else []
    logged = set.intersection(*(set(m.coordinates) for m in found)) if found else set()
    ordered = sorted((name for name in shares), key=lambda name: -shares[name])
    first = coordinate if coordinate is not None else next(iter(ordered), None)
    if first is None:
        return None
    drawn = first if first in logged else next((name for name in ("voltage", "time") if name in logged), None)
    interval = _interval(found, drawn) if drawn is not None and drawn == first else None
    where = Where(first, shares.get(first, 0.0), drawn, interval, shares, tuple(found))
    if not deep or not read:
        return where
    where = replace(where, momentum=_momentum(fitted, read, clean, limits))
    if not found:
        return where
    power = power_of(fitted, found, limits.regimes.window)
    return replace(where, regimes=_regimes(fitted, found, limits.regimes), bands=tuple(bands(power)))


def missing_torques(fitted: Fit, logs: Sequence[int], limits: LocalisationSettings) -> tuple[Missing, ...]:
    """Missing torque of logs with draws of what the fitted rig's own noise would show.

    Args:
        fitted: the fit.
        logs: numbers of the logs.
        limits: limits of the localisation.

    Returns:
        The missing torque of those logs that tell it; of none where the rig's structure hides it (`tells_torque`).
    """
    if not tells_torque(fitted.problem.structure):
        return ()
    clean = every_output(fitted.problem, fitted.theta, fitted.start)
    read = _read_logs(fitted, logs, clean, limits, limits.draws)
    return tuple(missing_torque(fitted, k, clean[k], r, limits) for k, r in read.items())


def tells_torque(structure: Structure) -> bool:
    """Whether a missing torque can be read off the motion: no effect has a state of its own, comes late, or bends a reading.

    Args:
        structure: the structure of the fitted rig.

    Returns:
        False for such an effect, for a servo, whose own states are not read, for readings without a sign, and for a rig of two axes.
    """
    effects = [BY_NAME[name] for name in structure.effects]
    hidden = any(effect.states or issubclass(effect, BESIDE_THE_PLANT) for effect in effects)
    return not (hidden or structure.servo or structure.halves or structure.unsigned)


def _read_logs(
    fitted: Fit, logs: Sequence[int], clean: list[dict[str, np.ndarray]], limits: LocalisationSettings, draws: int
) -> dict[int, Read]:
    """Motion of the body on which the missing torque acts, by log; of a two-axis rig, whose axes push one another, none."""
    structure = fitted.problem.structure
    body = "wheel" if structure.kind == "wheel" else "yaw"
    told = () if structure.halves else logs
    return {k: r for k in told if (r := read_body(fitted, k, body, limits, Own(clean[k], draws))) is not None}


def _regimes(fitted: Fit, found: list[Missing], limits: RegimeSettings) -> tuple[Part, ...]:
    logs = fitted.problem.logs
    top = max(float(np.max(np.abs(logs[m.log].at_drive))) for m in found)
    nothing = NO_COMMAND if all(logs[m.log].input == "voltage_V" for m in found) else NO_SHARE * top
    mass, own, label, own_label = [], [], [], []
    for m in found:
        log, weight = logs[m.log], weights(m.deviation)
        mass.append(weight * m.torque**2)
        own.append(weight[:, None] * m.own**2)
        of = [
            regimes(log.time, w, s, log.at_drive, top, nothing, limits)
            for w, s in zip(m.speed.T, m.still.T, strict=True)
        ]
        label.append(of[0])
        own_label.append(np.stack(of[1:], axis=1))
    return tuple(regime_shares(mass, own, label, own_label, limits.shifts))


def power_of(fitted: Fit, found: Sequence[Missing], window: int) -> OctavePower:
    """Power of the missing torque and of what the rig's own noise would show, by octave.

    Args:
        fitted: the fit.
        found: missing torque of each log, with draws.
        window: samples of a Welch window.

    Returns:
        The power [N² m² s].
    """
    interval = [float(np.median(np.diff(fitted.problem.logs[m.log].time))) for m in found]
    return octave_power([m.torque for m in found], [m.own for m in found], interval, window)


def _momentum(
    fitted: Fit, yaw: dict[int, Read], clean: list[dict[str, np.ndarray]], limits: LocalisationSettings
) -> Momentum | None:
    if fitted.problem.structure.kind != "reaction":
        return None
    wheel = {k: r for k in yaw if (r := read_body(fitted, k, "wheel", limits)) is not None}
    return split(fitted, yaw, wheel, clean, limits)


def _interval(found: list[Missing], coordinate: str) -> tuple[float, float]:
    """Shortest range of a coordinate that holds four fifths of the missing torque's weighted square."""
    weight = np.concatenate([weights(m.deviation) for m in found])
    y = np.concatenate([m.torque for m in found])
    c = np.concatenate([m.coordinates[coordinate] for m in found])
    order = np.argsort(c)
    mass = np.cumsum((weight * y**2)[order])
    mass = mass / mass[-1]
    c = c[order]
    first = np.searchsorted(mass, np.linspace(0.0, 0.2, 41))
    last = np.minimum(np.searchsorted(mass, np.linspace(0.8, 1.0, 41)), len(c) - 1)
    k = int(np.argmin(c[last] - c[first]))
    return float(c[first[k]]), float(c[last[k]])
