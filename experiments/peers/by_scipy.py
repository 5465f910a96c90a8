"""scipy: least squares over `solve_ivp`, as most users write it, with the four terms that the authors published."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from experiments.peers.logs import coarser

GAIN, WIDTH = 35.15065, 2e-3  # N/V, m/s of the smoothed sign
SAYS = "nothing: the four terms were put in by hand"


def run(numbers: np.ndarray, t: np.ndarray, u: np.ndarray, first: float) -> np.ndarray:
    """A free run."""
    M, viscous, dry, offset = numbers

    def rates(time: float, state: np.ndarray) -> list[float]:
        force = GAIN * u[min(int(time / (t[1] - t[0])), len(u) - 1)]
        return [state[1], (force - viscous * state[1] - dry * np.tanh(state[1] / WIDTH) - offset) / M]

    return solve_ivp(rates, (t[0], t[-1]), (first, 0.0), t_eval=t, rtol=1e-6, atol=1e-8, max_step=t[1] - t[0]).y[0]


def fit(t: np.ndarray, u: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Mass, viscous and dry friction, offset, in steps of ten samples."""
    t, u, x = coarser(10, t, u, x)
    begin = np.array([80.0, 250.0, 10.0, 0.0])
    return least_squares(
        lambda z: run(z, t, u, x[0]) - x, begin, x_scale=(80.0, 250.0, 10.0, 3.0), diff_step=1e-3, max_nfev=60
    ).x
