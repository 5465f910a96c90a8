"""Where: the missing torque read off the logs, and what it is a function of.

What it is a function of is judged in free run, which sees small lasting torques that drown in the noise of a measured
acceleration: the share of the excess error that the best law in a coordinate removes. The measured angle or speed is smoothed by a Rauch-Tung-Striebel smoother whose acceleration (jerk for angles) is a
random walk; its intensity maximises the likelihood. What the fitted rig cannot account for in the smoothed motion is
the missing torque, with the smoother's own standard deviation.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from rwjax.fit.end_to_end import Fit
from rwjax.grid import by_sample
from rwjax.log import Log
from rwjax.simulate import free_run, rates_along

STRETCH = 1500  # samples


@dataclass(frozen=True)
class Missing:
    """Missing torque of one log [N m] with its standard deviation, and the coordinates at the same times."""

    log: int
    torque: np.ndarray
    deviation: np.ndarray
    coordinates: dict[str, np.ndarray]


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

    length = min(len(y), STRETCH)  # the intensity is chosen on the stretch that moves most
    starts = range(0, len(y) - length + 1, max(1, length // 2))
    first = max(starts, key=lambda s: np.nanstd(np.diff(y[s : s + length])))
    part = slice(first, first + length)
    y_all, dt_all = y, dt
    y, dt = y_all[part], dt_all[first : first + length - 1]
    typical = noise**2 / np.median(dt) ** (2 * order - 1)
    best: dict = minimize_scalar(  # pyright: ignore[reportAssignmentType]
        lambda e: run(typical * 10.0**e)[0], bounds=(-9.0, 4.0), method="bounded", options={"xatol": 0.1}
    )
    y, dt = y_all, dt_all
    _, xs, Ps, steps = run(typical * 10.0 ** float(best["x"]))
    X, V = np.array(xs), np.array(Ps)
    for k in range(len(y) - 2, -1, -1):
        F, ahead, P_ahead = steps[k]
        G = np.linalg.solve(P_ahead.T, F @ V[k].T).T
        X[k] = X[k] + G @ (X[k + 1] - ahead)
        V[k] = V[k] + G @ (V[k + 1] - P_ahead) @ G.T
    return X, np.sqrt(np.maximum(np.diagonal(V, axis1=1, axis2=2), 0.0))


def missing_torque(fitted: Fit, number: int, log: Log) -> Missing | None:
    """Missing torque of one log on the axis, or on the wheel where there is no axis: inertia times the acceleration
    that the fitted plant cannot account for along the smoothed motion."""
    problem = fitted.problem
    structure = problem.structure
    kind = structure.kind
    angle, rate = ("wheel_rad", "wheel_rad_s") if kind == "wheel" else ("yaw_rad", "yaw_rad_s")
    name = angle if angle in log.outputs else rate
    if name not in log.outputs:
        return None
    t, dt = log.time - log.origin, np.diff(log.time)
    X, D = _smooth(log.outputs[name], dt, problem.noise[name], 3 if name == angle else 2)
    if name == angle:
        position, w, a, w_sd, a_sd = X[:, 0], X[:, 1], X[:, 2], D[:, 1], D[:, 2]
    else:
        w, a, w_sd, a_sd = X[:, 0], X[:, 1], D[:, 0], D[:, 1]
        position = np.concatenate([[0.0], np.cumsum(0.5 * (w[1:] + w[:-1]) * dt)])
    body = {"theta": position, "Omega": w} if kind == "wheel" else {"psi": position, "w": w}
    still = np.abs(w) <= 3.0 * np.median(w_sd)
    body["Omega" if kind == "wheel" else "w"] = np.where(still, 0.0, w)
    simulated = _rest_of(fitted, number, log)
    states = np.stack([body.get(state, simulated.get(state, np.zeros_like(w))) for state in structure.states], axis=1)
    theta = fitted.theta + np.array(structure.vector(log.added))
    rates = np.asarray(rates_along(structure, theta, t, states, log.command))
    inertia = theta[structure.names.index("wheel.inertia" if kind == "wheel" else "axis.inertia")]
    column = structure.states.index("Omega" if kind == "wheel" else "w")
    where = {("wheel_rate" if kind == "wheel" else "yaw_rate"): w, "time": t, "voltage": log.command}
    where["wheel_angle" if kind == "wheel" else "yaw"] = np.mod(position, 2.0 * np.pi)
    if kind != "platform":
        where["current"] = simulated["i"]
    if kind == "reaction":
        where["wheel_rate"] = simulated["Omega"]
    return Missing(number, inertia * (np.where(still, 0.0, a) - rates[:, column]), inertia * a_sd, where)


def _rest_of(fitted: Fit, number: int, log: Log) -> dict[str, np.ndarray]:
    """Current and wheel rate at a log's times: measured where they are, else of the fitted free run."""
    problem = fitted.problem
    y, _ = free_run(problem.structure, fitted.theta, fitted.start, problem.batch)
    samples = by_sample(problem.batch, number, np.asarray(y)[number], len(log.time))
    found = {}
    for state, name in (("i", "current_A"), ("Omega", "wheel_rad_s")):
        if name in problem.structure.outputs:
            simulated = samples[:, problem.structure.outputs.index(name)]
            measured = log.outputs.get(name, simulated)
            found[state] = np.where(np.isfinite(measured), measured, simulated)
    return found


def locate(fitted: Fit, logs: tuple[int, ...], shares: dict[str, float], coordinate: str | None) -> Where | None:
    """Missing torque of the rig as it is, laid over the coordinate of which it is a function.

    `shares`: what the best law in each coordinate explains; `coordinate` is set where an effect is named. None where no
    coordinate that was logged explains anything.
    """
    found = [m for k in logs if (m := missing_torque(fitted, k, fitted.problem.logs[k])) is not None]
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
    return Where(first, shares.get(first, 0.0), drawn, interval, shares, tuple(found))


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
