"""Where: the missing torque read off the logs, and what it is a function of.

What it is a function of is judged in free run, which sees small lasting torques that drown in the noise of a measured
acceleration: the share of the excess error that the best law in a coordinate removes. The measured angle or speed is
smoothed with an acceleration (jerk for angles) that is a random walk. What the fitted rig cannot account for in the
smoothed motion is the missing torque, with the smoother's own standard deviation; what the same steps make of readings
that the fitted rig itself would have given is the level against which regimes and bands stand out.
"""

from dataclasses import dataclass, replace

import numpy as np

from rwjax.diagnosis.localise.momentum import Momentum, Read, split
from rwjax.diagnosis.localise.own_noise import draws, rates, simulated
from rwjax.diagnosis.localise.regimes import Part, bands, regimes, weights
from rwjax.diagnosis.localise.regimes import shares as regime_shares
from rwjax.diagnosis.localise.smoother import smoother
from rwjax.fitting.multiple_shooting import Fit
from rwjax.logs.log import Log

DRAWS = 24  # of the fitted rig's own readings
STILL = 3.0  # deviations of the smoothed speed below which a body rests


@dataclass(frozen=True)
class Missing:
    """Missing torque of one log [N m] with its standard deviation, and the coordinates at the same times.

    `own` (time, draws): what the fitted rig's own readings would show; `still`, `speed` (time, 1 + draws) of log and draws.
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
    """`coordinate`: what the missing part is a function of; `share` of the excess squared error of the training logs
    that the best law in it removes, and `shares` the same for every coordinate. `drawn`: the logged coordinate over
    which the missing torque is laid; `interval` of `coordinate`, where it was logged, holds four fifths of the missing
    torque's square.
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
        """Shares by coordinate, regimes, bands and momentum as plain objects."""
        return {
            "shares": self.shares,
            "regimes": [{"regime": r.name, "share": r.share, "of_time": r.of_time, "p": r.p} for r in self.regimes],
            "bands": [
                {"from_hz": b.low, "to_hz": b.high, "share": b.share, "of_noise": b.of_time, "p": b.p}
                for b in self.bands
            ],
            "momentum": self.momentum.json() if self.momentum is not None else None,
        }


def read_body(
    fitted: Fit, number: int, log: Log, body: str, clean: dict[str, np.ndarray] | None = None, count: int = 0
) -> Read | None:
    """Motion of `yaw` or `wheel` from a log and, if wanted, from draws of what the fitted rig would have read."""
    noise = fitted.problem.noise
    angle, rate = f"{body}_rad", f"{body}_rad_s"
    name = angle if angle in log.outputs else rate
    if name not in log.outputs:
        return None
    smooth = smoother(log.outputs[name], np.diff(log.time), noise[name], 3 if name == angle else 2)
    readings = log.outputs[name][:, None]
    if clean is not None and count:
        rng = np.random.default_rng([number, body == "wheel"])
        readings = np.concatenate([readings, draws(fitted, log, clean[name], name, count, rng)], axis=1)
    states = smooth(readings[:, :1])
    if readings.shape[1] > 1:
        gaps = np.isnan(readings[:, :1])
        states = np.concatenate([states, smooth(np.where(gaps, np.nan, readings[:, 1:]))], axis=2)
    return Read(name, smooth, readings, states)


def missing_torque(
    fitted: Fit, number: int, log: Log, clean: dict[str, np.ndarray] | None = None, read: Read | None = None
) -> Missing | None:
    """Missing torque of one log on the axis, or on the wheel where there is no axis: inertia times the acceleration
    that the fitted plant cannot account for along the smoothed motion. `own`: the same for draws of the fitted rig."""
    structure = fitted.problem.structure
    kind = structure.kind
    clean = simulated(fitted)[number] if clean is None else clean
    read = read_body(fitted, number, log, "wheel" if kind == "wheel" else "yaw") if read is None else read
    if read is None:
        return None
    position, w, a = read.position(log.time), read.rate, read.acceleration
    w_sd, a_sd = read.deviation
    still = np.abs(w) <= STILL * np.median(w_sd)
    speed = np.where(still, 0.0, w)
    body = {"theta": position, "Omega": speed} if kind == "wheel" else {"psi": position, "w": speed}
    rest = _rest_of(fitted, log, clean)
    drawn = {state: clean[name] for state, name in OTHERS.items() if name in clean}
    states = {s: np.broadcast_to(np.zeros(()), w.shape) for s in structure.states}
    for s in rest:
        own = np.broadcast_to(drawn[s][:, None], (len(w), w.shape[1] - 1))
        states[s] = np.concatenate([rest[s][:, None], own], axis=1)
    states = {s: body.get(s, x) for s, x in (states | body).items() if s in structure.states}
    moving = "Omega" if kind == "wheel" else "w"
    along = rates(fitted, log, fitted.theta, states, log.command)[moving]
    inertia = fitted.theta[structure.names.index("wheel.inertia" if kind == "wheel" else "axis.inertia")]
    torque = inertia * (np.where(still, 0.0, a) - along)
    where = {("wheel_rate" if kind == "wheel" else "yaw_rate"): w[:, 0], "time": log.time - log.origin}
    where["voltage"] = log.command
    where["wheel_angle" if kind == "wheel" else "yaw"] = np.mod(position[:, 0], 2.0 * np.pi)
    if kind != "platform":
        where["current"] = rest["i"]
    if kind == "reaction":
        where["wheel_rate"] = rest["Omega"]
    return Missing(number, torque[:, 0], inertia * a_sd, where, torque[:, 1:], still, w)


OTHERS = {"i": "current_A", "Omega": "wheel_rad_s"}


def _rest_of(fitted: Fit, log: Log, clean: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Current and wheel rate at a log's times: measured where they are, else of the fitted free run."""
    found = {}
    for state, name in OTHERS.items():
        if name in clean:
            measured = log.outputs.get(name, clean[name])
            found[state] = np.where(np.isfinite(measured), measured, clean[name])
    return found


def locate(
    fitted: Fit, logs: tuple[int, ...], shares: dict[str, float], coordinate: str | None, *, deep: bool = True
) -> Where | None:
    """Missing torque of the rig as it is, laid over the coordinate of which it is a function.

    `shares`: what the best law in each coordinate explains; `coordinate` is set where an effect is named; `deep`: regimes,
    bands and momentum besides. None where nothing was tried and no effect is named. Of a two-axis rig, whose axes push
    one another, no missing torque is read off: only the shares are told.
    """
    every, clean = fitted.problem.logs, simulated(fitted)
    count = DRAWS if deep else 0
    body = "wheel" if fitted.problem.structure.kind == "wheel" else "yaw"
    told = () if fitted.problem.structure.halves else logs
    read = {k: r for k in told if (r := read_body(fitted, k, every[k], body, clean[k], count)) is not None}
    found = [m for k, r in read.items() if (m := missing_torque(fitted, k, every[k], clean[k], r)) is not None]
    logged = set.intersection(*(set(m.coordinates) for m in found)) if found else set()
    ordered = sorted((name for name in shares), key=lambda name: -shares[name])
    first = coordinate if coordinate is not None else next(iter(ordered), None)
    if first is None:
        return None
    drawn = first if first in logged else next((name for name in ("voltage", "time") if name in logged), None)
    interval = None
    if drawn is not None and drawn == first:
        sd = np.concatenate([m.deviation for m in found])
        weight = 1.0 / np.maximum(sd, 1e-3 * np.median(sd) + 1e-300) ** 2
        y = np.concatenate([m.torque for m in found])
        interval = _interval(np.concatenate([m.coordinates[drawn] for m in found]), weight, y)
    where = Where(first, shares.get(first, 0.0), drawn, interval, shares, tuple(found))
    if not deep or not found:
        return where
    return replace(
        where, regimes=_regimes(fitted, found), bands=_bands(fitted, found), momentum=_momentum(fitted, read, clean)
    )


def _regimes(fitted: Fit, found: list[Missing]) -> tuple[Part, ...]:
    logs = fitted.problem.logs
    top = max(float(np.max(np.abs(logs[m.log].command))) for m in found)
    mass, own, label, own_label = [], [], [], []
    for m in found:
        log, weight = logs[m.log], weights(m.deviation)
        mass.append(weight * m.torque**2)
        own.append(weight[:, None] * m.own**2)
        of = [regimes(log.time, w, s, log.command, top) for w, s in zip(m.speed.T, m.still.T, strict=True)]
        label.append(of[0])
        own_label.append(np.stack(of[1:], axis=1))
    return tuple(regime_shares(mass, own, label, own_label))


def _bands(fitted: Fit, found: list[Missing]) -> tuple[Part, ...]:
    interval = [float(np.median(np.diff(fitted.problem.logs[m.log].time))) for m in found]
    return tuple(bands([m.torque for m in found], [m.own for m in found], interval))


def _momentum(fitted: Fit, yaw: dict[int, Read], clean: list[dict[str, np.ndarray]]) -> Momentum | None:
    if fitted.problem.structure.kind != "reaction":
        return None
    every = fitted.problem.logs
    wheel = {k: r for k in yaw if (r := read_body(fitted, k, every[k], "wheel")) is not None}
    return split(fitted, yaw, wheel, clean)


def _interval(c: np.ndarray, weight: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Shortest range of a coordinate that holds four fifths of the missing torque's weighted square."""
    order = np.argsort(c)
    mass = np.cumsum((weight * y**2)[order])
    mass = mass / mass[-1]
    c = c[order]
    first = np.searchsorted(mass, np.linspace(0.0, 0.2, 41))
    last = np.minimum(np.searchsorted(mass, np.linspace(0.8, 1.0, 41)), len(c) - 1)
    k = int(np.argmin(c[last] - c[first]))
    return float(c[first[k]]), float(c[last[k]])
