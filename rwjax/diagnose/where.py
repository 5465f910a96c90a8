"""Where: the missing torque or voltage read off the logs, and what it is a function of.

The measured angle or speed is smoothed by a Rauch-Tung-Striebel smoother whose acceleration (jerk for angles) is a
random walk; its intensity maximises the likelihood. What the fitted rig cannot account for in the smoothed motion is
the missing torque (volts for a wheel: torque times R/K), with the smoother's own standard deviation.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from rwjax.fit.end_to_end import Fit
from rwjax.log import Log

BINS = 12
FOLD_S = 1.0  # the smooth function is cross-validated on blocks of this length


@dataclass(frozen=True)
class Missing:
    """Missing torque of one log [N m] with its standard deviation, and the coordinates at the same times."""

    log: int
    torque: np.ndarray
    deviation: np.ndarray
    coordinates: dict[str, np.ndarray]


@dataclass(frozen=True)
class Where:
    """Share of the missing torque's variance (noise taken out) that a smooth function of each coordinate explains.

    `interval`: range of the first coordinate that holds four fifths of the missing torque's square. `windows`: log,
    from, to [s], share of the held-out squared error.
    """

    coordinate: str
    share: float
    interval: tuple[float, float]
    shares: dict[str, float]
    missing: tuple[Missing, ...]
    unit: str


def _smooth(y: np.ndarray, dt: np.ndarray, noise: float, order: int) -> tuple[np.ndarray, np.ndarray]:
    """State `(time, order)` and variance of an `order`-fold integrated Wiener process seen through white noise."""

    def transition(h: float, q: float) -> tuple[np.ndarray, np.ndarray]:
        F = np.eye(order)
        Q = np.zeros((order, order))
        fact = [1.0, 1.0, 2.0, 6.0]
        for a in range(order):
            for b in range(a, order):
                F[a, b] = h ** (b - a) / fact[b - a]
            for b in range(order):
                pa, pb = order - 1 - a, order - 1 - b
                Q[a, b] = q * h ** (pa + pb + 1) / (fact[pa] * fact[pb] * (pa + pb + 1))
        return F, Q

    def run(q: float) -> tuple[float, list, list, list]:
        x, P = np.zeros(order), np.diag([1e6] * order) * max(noise, 1e-12) ** 2 * 1e6
        x[0] = y[np.flatnonzero(np.isfinite(y))[0]]
        cost, xs, Ps, steps = 0.0, [], [], []
        steps_cache: dict[float, tuple[np.ndarray, np.ndarray]] = {}
        for k in range(len(y)):
            if k:
                h = round(float(dt[k - 1]), 9)
                if h not in steps_cache:
                    steps_cache[h] = transition(h, q)
                F, Q = steps_cache[h]
                x, P = F @ x, F @ P @ F.T + Q
                steps.append((F, x, P))
            if np.isfinite(y[k]):
                s = P[0, 0] + noise**2
                r = y[k] - x[0]
                gain = P[:, 0] / s
                x, P = x + gain * r, P - np.outer(gain, P[0])
                if k > order:
                    cost += r * r / s + np.log(s)
            xs.append(x)
            Ps.append(P)
        return cost, xs, Ps, steps

    stride = max(1, len(y) // 1500)  # the intensity is chosen on a stretch of the log
    part = slice(0, max(len(y) // stride, 200))
    y_all, dt_all = y, dt
    y, dt = y_all[part], dt_all[part]
    typical = noise**2 / np.median(dt) ** (2 * order - 1)
    best = minimize_scalar(
        lambda e: run(typical * 10.0**e)[0], bounds=(-9.0, 4.0), method="bounded", options={"xatol": 0.1}
    )
    y, dt = y_all, dt_all
    _, xs, Ps, steps = run(typical * 10.0**best.x)
    X, V = np.array(xs), np.array(Ps)
    for k in range(len(y) - 2, -1, -1):
        F, ahead, P_ahead = steps[k]
        G = np.linalg.solve(P_ahead.T, F @ V[k].T).T
        X[k] = X[k] + G @ (X[k + 1] - ahead)
        V[k] = V[k] + G @ (V[k + 1] - P_ahead) @ G.T
    return X, np.sqrt(np.maximum(np.diagonal(V, axis1=1, axis2=2), 0.0))


def _dry(level: float, free: np.ndarray, rate: np.ndarray, still: float) -> np.ndarray:
    """Dry friction at a smoothed rate: against the motion, or what holds where the rate is lost in noise."""
    return np.where(np.abs(rate) > still, level * np.sign(rate), np.clip(free, -level, level))


def missing_torque(fitted: Fit, number: int, log: Log) -> Missing | None:
    """Missing torque of one log on the axis, or on the wheel where there is no axis."""
    n, problem = fitted.numbers(), fitted.problem
    kind = problem.structure.kind
    dt = np.diff(log.time)
    u = log.command
    angle, rate = ("wheel_rad", "wheel_rad_s") if kind == "wheel" else ("yaw_rad", "yaw_rad_s")
    name = angle if angle in log.outputs else rate
    if name not in log.outputs:
        return None
    X, D = _smooth(log.outputs[name], dt, problem.noise[name], 3 if name == angle else 2)
    if name == angle:
        position, w, a, w_sd, a_sd = X[:, 0], X[:, 1], X[:, 2], D[:, 1], D[:, 2]
    else:
        w, a, w_sd, a_sd = X[:, 0], X[:, 1], D[:, 0], D[:, 1]
        position = np.concatenate([[0.0], np.cumsum(0.5 * (w[1:] + w[:-1]) * dt)])
    still = float(3.0 * np.median(w_sd))
    friction = n.get("axis.friction.viscous", 0.0) * w
    gravity = n.get("axis.gravity.torque", 0.0) * np.sin(position + n.get("axis.gravity.angle", 0.0))
    current = log.outputs.get("current_A")
    wheel_rate = w if kind == "wheel" else log.outputs.get("wheel_rad_s", np.zeros_like(w))
    if kind != "platform" and (current is None or not np.all(np.isfinite(current))):
        current = _current(n, log, wheel_rate if kind == "wheel" or "wheel_rad_s" in log.outputs else None)
    if kind == "platform":
        drive, inertia = n["drive.gain"] * u, n["axis.inertia"]
    elif kind == "reaction":
        assert current is not None
        drive, inertia = -(n["motor.torque_constant"] * current - n["motor.friction"] * wheel_rate), n["axis.inertia"]
    else:
        assert current is not None
        drive, inertia = n["motor.torque_constant"] * current, n["wheel.inertia"]
        friction, gravity = n["motor.friction"] * w, np.zeros_like(w)
    free = drive - friction - gravity
    level = n.get("axis.friction.coulomb", 0.0) if kind != "wheel" else 0.0
    if "axis.friction.b3" in n and kind != "wheel":
        s = np.abs(w)
        polynomial = sum(n[f"axis.friction.b{3 - p}"] * s**p for p in range(4))
        torque = inertia * a - (free - np.sign(w) * polynomial)
    else:
        torque = inertia * a - (free - _dry(level, free - inertia * a, w, still))
    where = {("wheel_rate" if kind == "wheel" else "yaw_rate"): w, "time": log.time - log.time[0], "voltage": u}
    where["wheel_angle" if kind == "wheel" else "yaw"] = np.mod(position, 2.0 * np.pi)
    if kind != "platform" and current is not None:
        where["current"] = np.asarray(current)
    return Missing(number, torque, inertia * a_sd, where)


def _current(n: dict[str, float], log: Log, wheel_rate: np.ndarray | None) -> np.ndarray:
    """Current [A] that the motor's equations give for the logged voltage and the wheel's rate (simulated if unlogged)."""
    K, R, L = n["motor.torque_constant"], n["motor.resistance"], n.get("motor.inductance", 0.0)
    J, b = n["wheel.inertia"], n["motor.friction"]
    i, omega, out = 0.0, 0.0, []
    dt = np.append(np.diff(log.time), 0.0)
    for k, u in enumerate(log.command):
        rate = wheel_rate[k] if wheel_rate is not None else omega
        if L == 0.0:
            i = (u - K * rate) / R
        out.append(i)
        if L > 0.0:
            settled = (u - K * rate) / R
            i = settled + (i - settled) * np.exp(-dt[k] * R / L)
        omega += dt[k] * (K * i - b * omega) / J
    return np.array(out)


def _explained(c: np.ndarray, y: np.ndarray, weight: np.ndarray, block: np.ndarray) -> float:
    """Cross-validated share of the weighted variance of `y` that a function of `c`, constant on bins, explains."""
    if np.ptp(c) <= 0.0:
        return 0.0
    edges = np.unique(np.quantile(c, np.linspace(0.0, 1.0, BINS + 1)[1:-1]))
    bin_of = np.searchsorted(edges, c)
    count = len(edges) + 1
    fold = block % 5
    error = total = 0.0
    for f in range(5):
        train, test = fold != f, fold == f
        mass = np.bincount(bin_of[train], weights=weight[train], minlength=count)
        mean = np.bincount(bin_of[train], weights=(weight * y)[train], minlength=count) / np.maximum(mass, 1e-300)
        error += float(np.sum(weight[test] * (y[test] - mean[bin_of[test]]) ** 2))
        total += float(np.sum(weight[test] * y[test] ** 2))
    return 1.0 - error / total if total > 0.0 else 0.0


def locate(fitted: Fit, logs: tuple[int, ...], coordinate: str | None) -> Where | None:
    """Map of the missing torque over all coordinates; `coordinate` fixes the first one where an effect is named."""
    found = [m for k in logs if (m := missing_torque(fitted, k, fitted.problem.logs[k])) is not None]
    if not found:
        return None
    y = np.concatenate([m.torque for m in found])
    sd = np.concatenate([m.deviation for m in found])
    weight = 1.0 / np.maximum(sd, 1e-3 * np.median(sd) + 1e-300) ** 2
    block = np.concatenate([1000 * j + np.floor(m.coordinates["time"] / FOLD_S).astype(int) for j, m in enumerate(found)])
    names = set.intersection(*(set(m.coordinates) for m in found))
    noise = float(np.sum(weight * sd**2) / np.sum(weight * y**2))
    shares = {}
    for name in ("yaw_rate", "yaw", "wheel_rate", "wheel_angle", "current", "voltage", "time"):
        if name in names:
            c = np.concatenate([m.coordinates[name] for m in found])
            raw = _explained(c, y, weight, block)
            shares[name] = float(np.clip(raw / max(1.0 - noise, 0.05), 0.0, 1.0))
    first = coordinate if coordinate in shares else max(shares, key=lambda k: shares[k])
    c = np.concatenate([m.coordinates[first] for m in found])
    return Where(first, shares[first], _interval(c, weight, y), shares, tuple(found), "N m")


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
