"""The way of most users: scipy's least squares and `solve_ivp`, friction with a smoothed sign."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from experiments.speed.c_limit import Found
from experiments.speed.problem import TICK, TRUTH, Arrays

WIDTH = 0.03  # rad/s, of the smoothed sign


def residual(a: Arrays, numbers: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Weighted residual with the solver's default tolerances tightened to 1e-6."""
    inertia, viscous, coulomb = numbers
    last = len(a.command) - 1
    t = np.arange(last + 1) * TICK

    def rates(time: float, x: np.ndarray) -> list[float]:
        u = a.command[min(int(time / TICK), last)]
        return [x[1], (TRUTH.gain * u - viscous * x[1] - coulomb * np.tanh(x[1] / WIDTH)) / inertia]

    found = solve_ivp(rates, (0.0, t[-1]), first, t_eval=t, rtol=1e-6, atol=1e-8)
    return a.weight * (found.y[0] - a.reading)


def fit(a: Arrays) -> Found:
    """Where scipy's defaults end from the common start; `evaluations` counts simulations."""
    count = 0

    def misfit(z: np.ndarray) -> np.ndarray:
        nonlocal count
        count += 1
        return residual(a, np.exp(z[:3]), z[3:])

    r = least_squares(misfit, np.concatenate([np.log(a.believed), a.first]), x_scale="jac", max_nfev=60)
    return Found(np.exp(r.x[:3]), r.x[3:], float(r.cost), count)
