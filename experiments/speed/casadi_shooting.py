"""The expert's way: CasADi, multiple shooting with a node at every sample, Gauss-Newton Hessian, IPOPT.

RK4 with a smoothed sign (no stick): IPOPT needs a smooth model. `python -m experiments.speed.casadi_shooting SECONDS ROUNDS`
prints times and the optimum as JSON; it runs in a process of its own.
"""

import json
import sys
import time

import casadi as ca
import numpy as np

from experiments.speed.problem import TICK, TRUTH, Arrays, arrays, first_states, log

WIDTH = 0.003  # rad/s, of the smoothed sign
SUBSTEPS = 2  # RK4 steps of each sample, as the library's grid has


def _step() -> ca.Function:
    x, u, z = ca.MX.sym("x", 2), ca.MX.sym("u"), ca.MX.sym("z", 3)
    p, h = ca.exp(z), TICK / SUBSTEPS

    def rates(x: ca.MX) -> ca.MX:
        return ca.vertcat(x[1], (TRUTH.gain * u - p[1] * x[1] - p[2] * ca.tanh(x[1] / WIDTH)) / p[0])

    end = x
    for _ in range(SUBSTEPS):
        k1 = rates(end)
        k2 = rates(end + h / 2 * k1)
        k3 = rates(end + h / 2 * k2)
        k4 = rates(end + h * k3)
        end = end + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return ca.Function("step", [x, u, z], [end]).expand()


class Fitter:
    """The program of a log, built once; `fit` solves it."""

    def __init__(self, a: Arrays) -> None:
        n = len(a.command)
        X, z = ca.MX.sym("X", 2, n), ca.MX.sym("z", 3)
        ends = _step().map(n - 1)(X[:, :-1], ca.DM(a.command[:-1]).T, ca.repmat(z, 1, n - 1))
        residual = ca.DM(a.weight) * (X[0, :].T - ca.DM(a.reading))
        unknowns, gaps = ca.vertcat(z, ca.vec(X)), ca.vec(ends - X[:, 1:])
        J = ca.jacobian(residual, unknowns)
        scale, multipliers = ca.MX.sym("scale"), ca.MX.sym("multipliers", gaps.shape[0])
        gauss_newton = ca.Function(
            "hessian",
            [unknowns, ca.MX(0, 1), scale, multipliers],
            [scale * ca.triu(J.T @ J)],
            ["x", "p", "lam_f", "lam_g"],
            ["hess_gamma_x_x"],
        )
        options = {
            "hess_lag": gauss_newton,
            "print_time": False,
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "ipopt.tol": 1e-6,
            "ipopt.max_iter": 200,
        }
        program = {"x": unknowns, "f": 0.5 * ca.dot(residual, residual), "g": gaps}
        self.solver = ca.nlpsol("fit", "ipopt", program, options)
        self.begin = np.concatenate([np.log(a.believed), first_states(a.reading, np.arange(n)).ravel()])

    def fit(self) -> tuple[np.ndarray, float, int, str]:
        """Numbers, cost, iterations and IPOPT's own verdict."""
        r = self.solver(x0=self.begin, lbg=0.0, ubg=0.0)
        stats = self.solver.stats()
        return np.exp(np.array(r["x"])[:3, 0]), float(r["f"]), int(stats["iter_count"]), str(stats["return_status"])


def main(seconds: float, rounds: int) -> None:
    """Prints one JSON line for the build and one for each round; a round begins when a line arrives on stdin."""
    a = arrays(log(seconds))
    begin = time.perf_counter()
    fitter = Fitter(a)
    print(json.dumps({"build": time.perf_counter() - begin}), flush=True)
    for _ in range(rounds):
        if not sys.stdin.readline():
            return
        begin = time.perf_counter()
        numbers, cost, iterations, status = fitter.fit()
        spent = time.perf_counter() - begin
        print(
            json.dumps(
                {"time": spent, "numbers": list(numbers), "cost": cost, "iterations": iterations, "status": status}
            ),
            flush=True,
        )


if __name__ == "__main__":
    main(float(sys.argv[1]), int(sys.argv[2]))
