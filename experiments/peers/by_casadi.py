"""CasADi: multiple shooting with RK4 and IPOPT, as an expert writes it, with the four terms that the authors published."""

import casadi as ca
import numpy as np

from experiments.peers.logs import coarser

GAIN, WIDTH = 35.15065, 2e-3  # N/V, m/s of the smoothed sign
SCALE = ca.DM([80.0, 250.0, 10.0, 3.0])
SAYS = "nothing: the four terms were put in by hand"


def step(h: float) -> ca.Function:
    """One step of RK4; the numbers in units of their scale."""
    s, u, z = ca.MX.sym("s", 2), ca.MX.sym("u"), ca.MX.sym("z", 4)
    p = z * SCALE

    def rates(s: ca.MX) -> ca.MX:
        return ca.vertcat(s[1], (GAIN * u - p[1] * s[1] - p[2] * ca.tanh(s[1] / WIDTH) - p[3]) / p[0])

    k1 = rates(s)
    k2 = rates(s + h / 2 * k1)
    k3 = rates(s + h / 2 * k2)
    k4 = rates(s + h * k3)
    return ca.Function("step", [s, u, z], [s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)]).expand()


def run(numbers: np.ndarray, t: np.ndarray, u: np.ndarray, first: float) -> np.ndarray:
    """A free run."""
    states = step(t[1] - t[0]).mapaccum(len(t) - 1)(ca.DM([first, 0.0]), ca.DM(u[:-1]).T, ca.DM(numbers) / SCALE)
    return np.concatenate([[first], np.asarray(states)[0]])


def fit(t: np.ndarray, u: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The four terms, in steps of five samples, each of which is a node."""
    t, u, x = coarser(5, t, u, x)
    n = len(t)
    z, X = ca.MX.sym("z", 4), ca.MX.sym("X", 2, n)
    ends = step(t[1] - t[0]).map(n - 1)(X[:, :-1], ca.DM(u[:-1]).T, ca.repmat(z, 1, n - 1))
    problem = {"x": ca.vertcat(z, ca.vec(X)), "f": 1e6 * ca.sumsqr(X[0, :].T - x), "g": ca.vec(ends - X[:, 1:])}
    solver = ca.nlpsol("fit", "ipopt", problem, {"ipopt.print_level": 0, "print_time": False, "ipopt.max_iter": 200})
    begin = np.concatenate([[1.0, 1.0, 1.0, 0.0], np.stack([x, np.gradient(x, t)]).T.ravel()])
    found = solver(x0=begin, lbg=0.0, ubg=0.0)["x"]
    return np.asarray(found[:4] * SCALE).ravel()
