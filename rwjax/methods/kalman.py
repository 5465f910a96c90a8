"""Prediction error: the likelihood of an extended Kalman filter's innovations, maximised over the numbers.

The plant takes one step a sample. White noise of unknown intensity disturbs the torque on every body; the likelihood
chooses it together with the numbers (Ljung, System Identification, 1999, ch. 7). What the model cannot explain goes into
that noise. The method is therefore robust against unmodelled torques, and blind to small lasting ones.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from scipy.optimize import minimize

from rwjax.fitting.fit import to_fit
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.scales import sizes_of
from rwjax.fitting.threads import THREADS
from rwjax.logs.log import Log
from rwjax.lowering.slopes import with_slopes
from rwjax.methods.identified import Identified, at_the_drive, estimated, left_out, undelayed
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.commands import Switched
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.simulation.windows import prepare

METHOD = "prediction-error method"
ROUNDS = 4
"""Searches in a row at most, each scaled by the curvature where the last one stopped."""
QUIET, LOUD = 1e-6, 1e3
"""Disturbing torque per root second, in units of the torque that doubles the noise of one reading [1]."""


class _Runs(NamedTuple):
    """Logs at equal steps.

    `h` (l,) step [s]; `command` (l, t) [V]; `on` (l, t) share of the time in which current can flow [1]; `reading` (l, t, y) [SI], NaN where there is none; `start`, `unsure` (l, n)
    initial states and their standard deviations [SI]; `theta_offset` (l, p) what is added to the numbers [SI].
    """

    h: Any
    command: Any
    on: Any
    reading: Any
    start: Any
    unsure: Any
    theta_offset: Any


def _cost(structure: Structure, theta, intensity, run: _Runs, noise):
    """Negative log likelihood of one log's innovations."""
    plant = one_axis_plant_of(structure, theta + run.theta_offset)
    moved = prepare(plant, EXPONENTIAL_STEP, run.h)
    n = len(structure.states)
    rates = jnp.array([1.0 if name in ("w", "Omega") else 0.0 for name in structure.states])

    def move(x, t, u, on):
        acting = Switched(plant.act(u), on) if structure.switched else plant.act(u)
        return jnp.stack(moved.step(t, tuple(x[k] for k in range(n)), acting))

    def read(x, t, u, on):
        at = plant.powered(on) if structure.switched else plant
        return jnp.stack(at.outputs(t, tuple(x[k] for k in range(n)), plant.act(u)))

    def filtered(carry, sample):
        x, P, k = carry
        u, on, y = sample
        t = k * run.h
        H, innovations, before, cost = jax.jacfwd(read)(x, t, u, on), y - read(x, t, u, on), x, 0.0
        for one in range(len(structure.outputs)):  # one after the other: their errors are independent
            seen = jnp.isfinite(y[one])
            towards = P @ H[one]
            variance = H[one] @ towards + noise[one] ** 2
            innovation = jnp.where(seen, innovations[one] - H[one] @ (x - before), 0.0)
            cost += jnp.where(seen, 0.5 * (innovation**2 / variance + jnp.log(variance)), 0.0)
            gain = jnp.where(seen, towards / variance, 0.0)
            x, P = x + gain * innovation, P - jnp.outer(gain, towards)
        F = jax.jacfwd(move)(x, t, u, on)
        P = F @ P @ F.T + jnp.diag(rates * intensity**2 * run.h)
        return (move(x, t, u, on), 0.5 * (P + P.T), k + 1.0), cost

    P0 = jnp.diag(run.unsure**2)
    return jnp.sum(jax.lax.scan(filtered, (run.start, P0, 0.0), (run.command, run.on, run.reading))[1])


def _of_unknowns(structure: Structure, z, basis, theta, noise, *run) -> tuple[Any]:
    """`_cost` by the free numbers and the intensity, `z`; `basis` (k, p) says which number each of them is."""
    return (_cost(structure, theta + z[:-1] @ basis, z[-1], _Runs(*run), noise),)


def _slope(structure: Structure, z, basis, theta, noise, runs: _Runs) -> tuple[float, np.ndarray]:
    """Negative log likelihood over all logs, and its derivatives by the free numbers and the intensity, `z`."""
    of = partial(_of_unknowns, structure)

    def one(log: int) -> tuple[list[np.ndarray], list[np.ndarray]] | None:
        fixed = [basis, theta, noise, *(np.asarray(a[log]) for a in runs)]
        return with_slopes("likelihood", structure, of, z, fixed, structure.from_library)

    with ThreadPoolExecutor(min(THREADS, len(runs.h))) as pool:
        found = [part for part in pool.map(one, range(len(runs.h))) if part is not None]
    if not found:
        value, slope = _by_xla(structure, z, basis, theta, noise, runs)
        return float(value), np.asarray(slope)
    return float(sum(value[0] for value, _ in found)), np.sum([slope[0] for _, slope in found], axis=0)


@partial(jax.jit, static_argnums=0)
def _by_xla(structure: Structure, z, basis, theta, noise, runs: _Runs):
    """The same by a program of XLA."""

    def total(z):
        return jnp.sum(jax.vmap(lambda run: _of_unknowns(structure, z, basis, theta, noise, *run)[0])(runs))

    return jax.value_and_grad(total)(z)


class _Likelihood:
    """Negative log likelihood over all logs, of the free numbers in units of their size and the noise's logarithm.

    The last entry of `z` `(k+1,)` is the logarithm of the disturbance's intensity, in units of `unit`.
    """

    def __init__(self, rig: Rig, structure: Structure, train: Sequence[Log]) -> None:
        problem = pose(structure, train)
        self.structure, self.theta = problem.structure, theta_of(rig, structure)
        self.free = np.flatnonzero([name in rig.free for name in structure.names])
        self.basis = np.eye(len(self.theta))[self.free]
        self.known = self.theta * (1.0 - self.basis.sum(axis=0))
        self.size = sizes_of(rig, structure, self.theta, train)[self.free]
        outputs = problem.structure.outputs
        self.noise = np.array([problem.noise.get(name, 1.0) for name in outputs])
        self.runs = _laid_out(problem)
        seen = [name in problem.noise for name in outputs]
        self.unit = float(np.min(self.noise[seen])) / float(self.runs.h[0])

    def __call__(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        """Value and slope `(k+1,)`; a large value without slope where they are not finite."""
        intensity = self.unit * np.exp(z[-1])
        unknowns = np.append(z[:-1] * self.size, intensity)
        value, slope = _slope(self.structure, unknowns, self.basis, self.known, self.noise, self.runs)
        slope = slope * np.append(self.size, intensity)
        if not (np.isfinite(value) and np.all(np.isfinite(slope))):
            return 1e12, np.zeros(len(z))
        return value, slope

    def curvature(self, z: np.ndarray) -> np.ndarray:
        """Second derivative `(k+1, k+1)`, by differences of the slope."""
        columns = []
        for k in range(len(z)):
            d = np.zeros(len(z))
            d[k] = 1e-4 * max(abs(z[k]), 1e-3)
            columns.append((self(z + d)[1] - self(z - d)[1]) / (2.0 * d[k]))
        return 0.5 * (np.array(columns) + np.array(columns).T)


def _maximum(likelihood: _Likelihood, z: np.ndarray, limits: np.ndarray) -> tuple[np.ndarray, bool]:
    """Where the likelihood is largest within `limits` (k+1, 2), and whether the search settled there."""
    settled = False
    for _ in range(ROUNDS):
        scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(likelihood.curvature(z))), 1e-12))

        def scaled(s: np.ndarray, scale: np.ndarray = scale) -> tuple[float, np.ndarray]:
            value, slope = likelihood(s * scale)
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
    return z, settled


def prediction_error(rig: Rig, logs: Sequence[Log]) -> Identified:
    """Maximum likelihood of the innovations over all logs.

    Args:
        rig: The rig with its free numbers, without delays.
        logs: The logs; those marked for validation are left out.

    Returns:
        The estimates.

    Raises:
        RigError: Nothing is free, or the rig has a delay.
        LogError: No log may be fitted.
    """
    undelayed(rig, METHOD)
    opened, logs, about = at_the_drive(rig, logs, METHOD)
    train = to_fit(opened, logs)
    structure = structure_of(opened)
    likelihood = _Likelihood(opened, structure, train)
    free, size = likelihood.free, likelihood.size
    low, high = bounds_of(opened, structure)[free].T / size
    z = np.append(np.clip(likelihood.theta[free] / size, low, high), 0.0)
    limits = np.array([*zip(low, high, strict=True), (np.log(QUIET), np.log(LOUD))])
    z, settled = _maximum(likelihood, z, limits)
    variance = np.diag(np.linalg.pinv(likelihood.curvature(z)))[:-1]
    errors = np.sqrt(np.where(variance > 0.0, variance, np.inf)) * size
    notes = left_out(rig, prior=False) + about + (() if settled else ("the search did not settle",))
    names = [structure.names[k] for k in free]
    return Identified(estimated(rig, names, z[:-1] * size, errors), notes)


def _laid_out(problem: Problem) -> _Runs:
    """Logs at equal steps of their own, padded to the longest; a sample is taken to lie on the nearest step."""
    longest = max(len(log.time) for log in problem.logs)
    h, commands, on, readings = [], [], [], []
    for log in problem.logs:
        n = len(log.time)
        nearest = np.searchsorted(log.time, np.linspace(log.time[0], log.time[-1], n) - 1e-9).clip(0, n - 1)
        nothing = np.full(n, np.nan)
        reading = np.stack([log.outputs.get(name, nothing) for name in problem.structure.outputs], axis=1)
        h.append((log.time[-1] - log.time[0]) / (n - 1))
        commands.append(np.pad(log.command[nearest], (0, longest - n), mode="edge"))
        powered = np.ones(n) if log.enabled is None else log.enabled.astype(float)
        on.append(np.pad(powered[nearest], (0, longest - n), mode="edge"))
        readings.append(np.pad(reading[nearest], ((0, longest - n), (0, 0)), constant_values=np.nan))
    unsure = np.where(problem.start_free, 0.1 * np.maximum(np.abs(problem.start), 1.0), 1e-6)
    laid = _Runs(h, commands, on, readings, problem.start, unsure, problem.batch.theta_offset)
    return _Runs(*map(np.array, laid))
