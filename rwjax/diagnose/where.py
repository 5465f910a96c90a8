"""Where: the missing torque read off the logs, and what it is a function of.

What it is a function of is judged in free run, which sees small lasting torques that drown in the noise of a measured
acceleration: the share of the excess error that the best law in a coordinate removes. The measured angle or speed is smoothed by a Rauch-Tung-Striebel smoother whose acceleration (jerk for angles) is a
random walk; its intensity maximises the likelihood. What the fitted rig cannot account for in the smoothed motion is
the missing torque, with the smoother's own standard deviation.
"""

from dataclasses import dataclass

import numpy as np

from rwjax.diagnose.smoother import smoother
from rwjax.fit.end_to_end import Fit
from rwjax.grid import by_sample
from rwjax.log import Log
from rwjax.simulate import free_run, rates_along


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
    smooth = smoother(log.outputs[name], dt, problem.noise[name], 3 if name == angle else 2)
    X, D = smooth(log.outputs[name]), smooth.deviation
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
