r"""The thesis's two-stage method: a polynomial in time through the speed of a coast-down, then one in speed.

Stage 1 lays a polynomial in time through the speed (thesis eq. 3.12); its derivative is the acceleration (3.13). Stage 2
is linear least squares of $-\psi''$ on the friction's terms (3.14), $I\psi'' + b_0\psi'^3 + b_1\psi'^2 + b_2\psi' + b_3 = 0$
for a forward motion; the inertia is taken as known. A rig file with a Stribeck curve gets the curve that lies closest
to the polynomial over the measured speeds. The encoder's angle goes through a derivative filter first.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import least_squares
from scipy.signal import lfilter

from rwjax.errors import LogError, RigError
from rwjax.fitting.fit import to_fit
from rwjax.fitting.initial_guess import NO_COMMAND
from rwjax.fitting.predict import predict
from rwjax.logs.log import Log
from rwjax.methods.identified import Identified, estimated, left_out
from rwjax.rig.model import Rig

FILTER_S = 0.05
"""Time constant of the derivative filter s/(T s + 1) [s]."""
SHORTEST_S = 1.0
"""Shortest coast-down that is used [s]."""
SLOWEST = 0.02
"""Share of the fastest speed below which a coast-down is over: the next it does is stick."""
QUIET = 0.02
"""Share of a reaction wheel's largest torque above which it still brakes: too swift for a polynomial in time."""
ORDERS = range(1, 9)
FOLDS = 5
BLOCK_S = 0.25  # residuals of stage 1 closer than this are resampled together
RESAMPLES = 200
POLYNOMIAL = ("axis.friction.b3", "axis.friction.b2", "axis.friction.b1", "axis.friction.b0")
CURVE = (
    "axis.friction.coulomb",
    "axis.friction.static",
    "axis.friction.stribeck_velocity",
    "axis.friction.viscous",
)


@dataclass(frozen=True)
class CoastDown:
    """One stretch without input: time from its start [s], speed [rad/s] against whose direction friction acts (always
    positive), and what else accelerates the axis in that direction [rad/s^2]."""

    time: np.ndarray
    speed: np.ndarray
    pushed: np.ndarray


def filtered_speed(time: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Speed [rad/s] of an angle through $s/(Ts+1)$, exact for an angle that is straight between samples."""
    grid = np.linspace(time[0], time[-1], len(time))
    slope = np.diff(np.interp(grid, time, angle)) / (grid[1] - grid[0])
    keep = np.exp(-(grid[1] - grid[0]) / FILTER_S)
    speed = np.asarray(lfilter([1.0 - keep], [1.0, -keep], np.concatenate([[0.0], slope])))
    return np.interp(time, grid, speed)


def coast_downs(rig: Rig, log: Log) -> list[CoastDown]:
    """The stretches of a log in which no voltage is applied and the axis slides one way."""
    name = "yaw_rad" if "yaw_rad" in log.outputs else "yaw_rad_s"
    if name not in log.outputs:
        return []
    seen = np.isfinite(log.outputs[name])
    t, y, u = log.time[seen], log.outputs[name][seen], log.command[seen]
    if len(t) < 8:
        return []
    speed = filtered_speed(t, y) if name == "yaw_rad" else y
    fastest = float(np.max(np.abs(speed)))
    wheel = _wheel_torque(rig, log)[seen]
    quiet = np.abs(wheel) <= QUIET * max(float(np.max(np.abs(wheel))), 1e-300)
    sliding = quiet & (np.abs(u) <= NO_COMMAND) & (np.abs(speed) > SLOWEST * fastest)
    way = np.where(sliding, np.sign(speed), 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], way, [0.0]])))
    push = (wheel + _gravity(rig, log)[seen]) / rig.numbers["axis.inertia"]
    found = []
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        settle = int(np.searchsorted(t, t[first] + 4.0 * FILTER_S)) if name == "yaw_rad" else first
        part = slice(settle, last)
        if way[first] and last - settle >= 20 and t[last - 1] - t[settle] >= SHORTEST_S:
            found.append(CoastDown(t[part] - t[settle], way[first] * speed[part], way[first] * push[part]))
    return found


def _gravity(rig: Rig, log: Log) -> np.ndarray:
    n = rig.numbers
    if "axis.gravity.torque" not in n or "yaw_rad" not in log.outputs:
        return np.zeros_like(log.time)
    return -n["axis.gravity.torque"] * np.sin(log.outputs["yaw_rad"] + n.get("axis.gravity.angle", 0.0))


def _wheel_torque(rig: Rig, log: Log) -> np.ndarray:
    """Torque of a reaction wheel on the axis [N m], from a free run of the rig's wheel and the readings that there are."""
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


def cross_validated_order(stretch: CoastDown) -> int:
    """Order of the polynomial in time that predicts left-out parts best (every part is spread over the whole run)."""
    n = len(stretch.time)
    fold = (np.arange(n) * 4 * FOLDS // n) % FOLDS
    error = []
    for order in ORDERS:
        square = 0.0
        for k in range(FOLDS):
            fitted = Polynomial.fit(stretch.time[fold != k], stretch.speed[fold != k], order)
            square += float(np.sum((fitted(stretch.time[fold == k]) - stretch.speed[fold == k]) ** 2))
        error.append(square)
    return ORDERS[int(np.argmin(error))]


def _stage_two(
    stretches: Sequence[CoastDown], speeds: Sequence[Polynomial], powers: Sequence[int], known: Polynomial
) -> np.ndarray:
    """Friction's coefficients per unit inertia, for the powers of speed that are sought; `known` is given."""
    rows, target = [], []
    for stretch, speed in zip(stretches, speeds, strict=True):
        w = speed(stretch.time)
        rows.append(np.stack([w**p for p in powers], axis=1))
        target.append(stretch.pushed - speed.deriv()(stretch.time) - known(w))
    A = np.concatenate(rows)
    scale = np.linalg.norm(A, axis=0)
    return np.linalg.lstsq(A / scale, np.concatenate(target), rcond=None)[0] / scale


def _curve(values: np.ndarray, w: np.ndarray) -> np.ndarray:
    coulomb, static, velocity, viscous = values
    return coulomb + (static - coulomb) * np.exp(-((w / velocity) ** 2)) + viscous * w


def to_stribeck(friction: Polynomial, speeds: np.ndarray, rig: Rig, free: Sequence[str]) -> np.ndarray:
    """Numbers `free` of the Stribeck curve closest to a friction polynomial [N m] over `speeds` [rad/s]."""
    w = np.linspace(np.min(speeds), np.max(speeds), 200)
    wanted = friction(w)
    index = [CURVE.index(name) for name in free]
    start = np.array([wanted.min(), wanted[0], 0.3 * w[-1], max((wanted[-1] - wanted.min()) / w[-1], 1e-9)])
    fixed = np.array([rig.numbers.get(name, 0.0) for name in CURVE])

    def values(z: np.ndarray) -> np.ndarray:
        full = fixed.copy()
        full[index] = np.exp(z)
        return full

    z0 = np.log(np.maximum(start[index], 1e-9))
    best = least_squares(lambda z: (_curve(values(z), w) - wanted) / np.max(np.abs(wanted)), z0, x_scale=1.0)
    return values(best.x)[index]


def two_stage(rig: Rig, logs: Sequence[Log], *, order: int | None = None) -> Identified:
    """Friction of the axis from coast-downs. `order`: of the polynomial in time, cross-validated without it.

    Raises `RigError` for a `wheel` and where no friction number is free, `LogError` where no log coasts.
    """
    train = to_fit(rig, logs)
    if rig.kind == "wheel":
        raise RigError(f"rig `{rig.name}`: a `wheel` has no axis that coasts; the two-stage method needs one")
    free = [name for name in rig.free if name in (*POLYNOMIAL, *CURVE)]
    if not free:
        raise RigError(
            f"rig `{rig.name}`: [fit] free names no number of [axis.friction]; the two-stage method estimates only those"
        )
    stretches = [stretch for log in train for stretch in coast_downs(rig, log)]
    if not stretches:
        names = ", ".join(log.name for log in train)
        raise LogError(
            f"{names}: no stretch of {SHORTEST_S:.0f} s in which the axis turns at 0 V; the two-stage method needs a coast-down"
        )
    if loaded := next((log for log in train if log.added), None):
        raise LogError(
            f"{loaded.name}: has an `# add` note; the two-stage method takes one rig for all runs: leave it out"
        )
    inertia = rig.numbers["axis.inertia"]
    power = {name: 3 - k for k, name in enumerate(reversed(POLYNOMIAL))} | {CURVE[0]: 0, CURVE[3]: 1}
    stribeck = "axis.friction.static" in rig.numbers
    powers = [0, 1, 2, 3] if stribeck else [power[name] for name in free]
    known = np.zeros(4)
    if not stribeck:
        for name, p in power.items():
            if name in rig.numbers and name not in free:
                known[p] += rig.numbers[name] / inertia
    orders = [cross_validated_order(s) if order is None else order for s in stretches]
    fitted = [Polynomial.fit(s.time, s.speed, n) for s, n in zip(stretches, orders, strict=True)]
    seen = np.concatenate([p(s.time) for p, s in zip(fitted, stretches, strict=True)])

    def estimate(speeds: Sequence[Polynomial]) -> np.ndarray:
        found = inertia * _stage_two(stretches, speeds, powers, Polynomial(known))
        return to_stribeck(Polynomial(found), seen, rig, free) if stribeck else found

    values = estimate(fitted)
    for name, value in zip(free, values, strict=True):
        low, high = rig.bounds.get(name, (-np.inf, np.inf))
        if not low <= value <= high:
            raise RigError(
                f"rig `{rig.name}`: `{name}` comes out as {value:.4g}, outside its `fit.bounds` [{low:.4g}, {high:.4g}], which "
                "the two-stage method cannot heed; take them out"
            )
    rng = np.random.default_rng(0)
    drawn = []
    for _ in range(RESAMPLES):
        again = [
            Polynomial.fit(s.time, p(s.time) + _shuffled(rng, s.time, s.speed - p(s.time)), n)
            for s, p, n in zip(stretches, fitted, orders, strict=True)
        ]
        drawn.append(estimate(again))
    notes = [*left_out(rig, prior=False)]
    notes += [f"{name} is not estimated by the two-stage method" for name in rig.free if name not in free]
    notes.append(
        f"{len(stretches)} coast-downs, polynomials in time of order {', '.join(map(str, sorted({*orders})))}, "
        f"speeds from {np.min(seen):.3g} to {np.max(seen):.3g} rad/s"
    )
    return Identified(estimated(rig, free, values, np.std(drawn, axis=0, ddof=1)), tuple(notes))


def _shuffled(rng: np.random.Generator, time: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Residual with blocks drawn anew (moving blocks; Kuensch, Ann. Stat. 17, 1989)."""
    n = len(residual)
    length = max(1, min(n - 1, int(np.searchsorted(time, time[0] + BLOCK_S))))
    starts = rng.integers(0, n - length + 1, -(-n // length))
    return np.concatenate([residual[s : s + length] for s in starts])[:n]
