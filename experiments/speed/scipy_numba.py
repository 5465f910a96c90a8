"""The strong conventional way: scipy's least squares with finite differences over a compiled simulation, in the library's
own step, and in Runge-Kutta steps with a smoothed sign as it is usually written."""

from collections.abc import Callable

import numpy as np
from numba import njit
from scipy.optimize import least_squares

from experiments.speed.c_limit import Found
from experiments.speed.problem import TRUTH, Arrays


@njit(cache=True)
def simulate(command, inertia, viscous, coulomb, gain, psi, w, h, substeps):
    """Angles at the samples: the linear part by its exponential, exact stick, a crossing of rest resolved in the step."""
    rate = viscous / inertia
    E = np.exp(-rate * h)
    P = -np.expm1(-rate * h) / rate
    Q = (h - P) / rate
    out = np.empty(len(command))
    for k in range(len(command)):
        out[k] = psi
        drive = gain * command[k]
        for _ in range(substeps):
            if w == 0.0 and abs(drive) <= coulomb:
                break
            direction = np.sign(w) if w != 0.0 else np.sign(drive)
            n = (drive - direction * coulomb) / inertia
            end = E * w + P * n
            if w * end >= 0.0:
                psi += P * w + Q * n
                w = end
                continue
            # the rate over the step is taken as a parabola through both ends and the first slope
            slope = h * (n - rate * w)
            bend = end - w - slope
            share = 2.0 * w / (direction * np.sqrt(slope**2 - 4.0 * bend * w) - slope)
            psi += share * h * (w + share * (slope / 2.0 + share * bend / 3.0))
            at_stop = drive - viscous * (w + share * (end - w))
            mean = 0.5 * (at_stop + drive - viscous * end)
            left = (1.0 - share) * h
            w = 0.0
            if abs(at_stop) > coulomb:
                w = left * np.sign(mean) * max(abs(mean) - coulomb, 0.0) / inertia
            psi += 0.5 * left * w
    return out


WIDTH = 6e-4
"""Width of the smoothed sign [rad/s] at which a stuck axis creeps by less than half a count in 13 s."""
STABLE = 1.0
"""Largest product of a Runge-Kutta step and the rate at which the smoothed sign pulls a body to rest."""


@njit(cache=True)
def simulate_smooth(command, inertia, viscous, coulomb, gain, psi, w, dt):
    """Angles at the samples by classical Runge-Kutta steps with the sign smoothed over `WIDTH`, as short as it asks."""
    steps = int(np.ceil(dt * coulomb / (inertia * WIDTH) / STABLE)) + 1
    h = dt / steps
    out = np.empty(len(command))
    for k in range(len(command)):
        out[k] = psi
        drive = gain * command[k]
        for _ in range(steps):
            k1 = (drive - viscous * w - coulomb * np.tanh(w / WIDTH)) / inertia
            w2 = w + 0.5 * h * k1
            k2 = (drive - viscous * w2 - coulomb * np.tanh(w2 / WIDTH)) / inertia
            w3 = w + 0.5 * h * k2
            k3 = (drive - viscous * w3 - coulomb * np.tanh(w3 / WIDTH)) / inertia
            w4 = w + h * k3
            k4 = (drive - viscous * w4 - coulomb * np.tanh(w4 / WIDTH)) / inertia
            psi += h / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4)
            w += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return out


def residual(a: Arrays, numbers: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Weighted residual of the free run in the library's step."""
    inertia, viscous, coulomb = numbers
    angle = simulate(a.command, inertia, viscous, coulomb, TRUTH.gain, first[0], first[1], a.step, a.substeps)
    return a.weight * (angle - a.reading)


def smooth_residual(a: Arrays, numbers: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Weighted residual of the free run in Runge-Kutta steps."""
    inertia, viscous, coulomb = numbers
    angle = simulate_smooth(a.command, inertia, viscous, coulomb, TRUTH.gain, first[0], first[1], a.step * a.substeps)
    return a.weight * (angle - a.reading)


def fit(a: Arrays, residual: Callable = residual) -> Found:
    """Optimum over logarithms of the numbers and the initial state; `evaluations` counts simulations."""
    count = 0

    def misfit(z: np.ndarray) -> np.ndarray:
        nonlocal count
        count += 1
        return residual(a, np.exp(z[:3]), z[3:])

    z0 = np.concatenate([np.log(a.believed), a.first])
    r = least_squares(misfit, z0, x_scale="jac", ftol=1e-9, xtol=1e-12, gtol=1e-12, max_nfev=100)
    return Found(np.exp(r.x[:3]), r.x[3:], float(r.cost), count)
