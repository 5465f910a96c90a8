r"""Prediction error: an extended Kalman filter's innovations under the model, their likelihood maximised.

One step of the plant a sample; the torque on every body is disturbed by white noise of unknown intensity, which the
likelihood chooses with the numbers (Ljung, System Identification, 1999, ch. 7). What the model cannot explain goes into
that noise: robust against unmodelled torques, and for the same reason blind to small lasting ones.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import rwjax.setup_jax  # noqa: F401  (float64 comes first)

import jax  # isort: skip
import jax.numpy as jnp
import numpy as np
from scipy.optimize import minimize

from rwjax.fitting.fit import to_fit
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.scales import sizes_of
from rwjax.logs.log import Log
from rwjax.methods.identified import Identified, estimated, left_out, undelayed
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.plant.one_axis import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import one_axis_plant_of
from rwjax.simulation.step import propagator, step

ROUNDS = 4
"""Searches in a row, each scaled by the curvature where the last one stopped."""
QUIET, LOUD = 1e-6, 1e3
"""Disturbing torque per root second, in units of the torque that doubles the noise of one reading."""


class _Runs(NamedTuple):
    """Logs at equal steps: `h` (l,), `command` (l, t), `reading` (l, t, y) with NaN where there is none, first states
    and how unsure they are (l, n), what a run's numbers have more than the rig's `plus` (l, p)."""

    h: Any
    command: Any
    reading: Any
    start: Any
    unsure: Any
    theta_offset: Any


def _cost(structure: Structure, theta, intensity, run: _Runs, noise):
    """Negative log likelihood of one log's innovations."""
    plant = one_axis_plant_of(structure, theta + run.theta_offset)
    p = propagator(plant, run.h)
    n = len(structure.states)
    rates = jnp.array([1.0 if name in ("w", "Omega") else 0.0 for name in structure.states])

    def move(x, t, u):
        return jnp.stack(step(plant, p, t, tuple(x[k] for k in range(n)), plant.act(u), run.h))

    def read(x, t, u):
        return jnp.stack(plant.outputs(t, tuple(x[k] for k in range(n)), plant.act(u)))

    def filtered(carry, sample):
        x, P, k = carry
        u, y = sample
        t = k * run.h
        H = jax.jacfwd(read)(x, t, u)
        seen = jnp.isfinite(y)
        S = H @ P @ H.T + jnp.diag(noise**2)
        S = jnp.where(seen[:, None] & seen[None], S, 0.0) + jnp.diag(jnp.where(seen, 0.0, 1.0))
        innovation = jnp.where(seen, y - read(x, t, u), 0.0)
        L = jnp.linalg.cholesky(S)
        white = jax.scipy.linalg.solve_triangular(L, innovation, lower=True)
        cost = 0.5 * white @ white + jnp.sum(jnp.log(jnp.diag(L)))
        gain = jax.scipy.linalg.cho_solve((L, True), jnp.where(seen[:, None], H @ P, 0.0)).T
        x, P = x + gain @ innovation, P - gain @ jnp.where(seen[:, None], H @ P, 0.0)
        F = jax.jacfwd(move)(x, t, u)
        P = F @ P @ F.T + jnp.diag(rates * intensity**2 * run.h)
        return (move(x, t, u), 0.5 * (P + P.T), k + 1.0), cost

    P0 = jnp.diag(run.unsure**2)
    return jnp.sum(jax.lax.scan(filtered, (run.start, P0, 0.0), (run.command, run.reading))[1])


@partial(jax.jit, static_argnums=0)
def _slope(structure: Structure, theta, intensity, runs: _Runs, noise):
    def total(theta, intensity):
        return jnp.sum(jax.vmap(lambda run: _cost(structure, theta, intensity, run, noise))(runs))

    return jax.value_and_grad(total, argnums=(0, 1))(theta, intensity)


def prediction_error(rig: Rig, logs: Sequence[Log]) -> Identified:
    """Maximum likelihood of the innovations over all logs. Raises as `to_fit`."""
    undelayed(rig, "prediction-error method")
    train = to_fit(rig, logs)
    structure = structure_of(rig)
    problem = pose(structure, train)
    theta = theta_of(rig, structure)
    free = np.flatnonzero([name in rig.free for name in structure.names])
    size = sizes_of(rig, structure, theta, train)[free]
    low, high = bounds_of(rig, structure)[free].T / size
    noise = np.array([problem.noise.get(name, 1.0) for name in structure.outputs])
    runs = _laid_out(problem)
    seen = [name in problem.noise for name in structure.outputs]
    unit = float(np.min(noise[seen])) / float(runs.h[0])

    def cost(z: np.ndarray) -> tuple[float, np.ndarray]:
        numbers = theta.copy()
        numbers[free] = z[:-1] * size
        intensity = unit * np.exp(z[-1])
        value, (by_theta, by_intensity) = _slope(structure, numbers, intensity, runs, noise)
        slope = np.append(np.asarray(by_theta)[free] * size, float(by_intensity) * intensity)
        if not (np.isfinite(value) and np.all(np.isfinite(slope))):
            return 1e12, np.zeros(len(z))
        return float(value), slope

    def curvature(z: np.ndarray) -> np.ndarray:
        columns = []
        for k in range(len(z)):
            d = np.zeros(len(z))
            d[k] = 1e-4 * max(abs(z[k]), 1e-3)
            columns.append((cost(z + d)[1] - cost(z - d)[1]) / (2.0 * d[k]))
        return 0.5 * (np.array(columns) + np.array(columns).T)

    z = np.append(np.clip(theta[free] / size, low, high), 0.0)
    limits = np.array([*zip(low, high, strict=True), (np.log(QUIET), np.log(LOUD))])
    settled = False
    for _ in range(ROUNDS):
        scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(curvature(z))), 1e-12))

        def scaled(s: np.ndarray, scale: np.ndarray = scale) -> tuple[float, np.ndarray]:
            value, slope = cost(s * scale)
            return value, slope * scale

        best = minimize(
            scaled,
            z / scale,
            jac=True,
            method="L-BFGS-B",
            bounds=limits / scale[:, None],
            options={"maxiter": 30},
        )
        z = best.x * scale
        if settled := bool(best.success):
            break
    variance = np.diag(np.linalg.pinv(curvature(z)))[:-1]
    errors = np.sqrt(np.where(variance > 0.0, variance, np.inf)) * size
    notes = left_out(rig, prior=False) + (() if settled else ("the search did not settle",))
    names = [structure.names[k] for k in free]
    return Identified(estimated(rig, names, z[:-1] * size, errors), notes)


def _laid_out(problem: Problem) -> _Runs:
    """Logs at equal steps of their own, as long as the longest; a sample is taken to lie on the nearest step."""
    longest = max(len(log.time) for log in problem.logs)
    h, commands, readings = [], [], []
    for log in problem.logs:
        n = len(log.time)
        nearest = np.searchsorted(log.time, np.linspace(log.time[0], log.time[-1], n) - 1e-9).clip(0, n - 1)
        nothing = np.full(n, np.nan)
        reading = np.stack([log.outputs.get(name, nothing) for name in problem.structure.outputs], axis=1)
        h.append((log.time[-1] - log.time[0]) / (n - 1))
        commands.append(np.pad(log.command[nearest], (0, longest - n), mode="edge"))
        readings.append(np.pad(reading[nearest], ((0, longest - n), (0, 0)), constant_values=np.nan))
    unsure = np.where(problem.start_free, 0.1 * np.maximum(np.abs(problem.start), 1.0), 1e-6)
    return _Runs(np.array(h), np.array(commands), np.array(readings), problem.start, unsure, problem.batch.theta_offset)
