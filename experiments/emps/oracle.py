"""EMPS without this library: the four-term model solved exactly, its least-squares optimum found globally.

Stick and slip by events, the speed between them in closed form, the start by the same rule as every free run, the
optimum by differential evolution: no step size, no smoothing and no local minimum stand between the model and what is
printed. The profile shows how little DATA_EMPS says about the split between viscous and dry friction.

`python -m experiments.emps.oracle [FOLDER]`
"""

import sys
from pathlib import Path

import numpy as np
from numba import njit
from scipy.optimize import differential_evolution

from experiments.emps.run import PUBLISHED, SKIPPED
from experiments.realdata import emps

GAIN = 35.15065  # N/V
STEP = 1e-3  # s
FIRST = 501  # samples of the first 0.5 s
BOUNDS = [(80.0, 105.0), (180.0, 215.0), (18.0, 24.0), (2.8, 3.8)]
NAMES = ("M [kg]", "Fv [N s/m]", "Fc [N]", "offset [N]")


@njit
def run(numbers, force, x, v):
    """Position at every sample under a held force, `numbers` = mass, viscous, dry, offset."""
    mass, viscous, dry, offset = numbers
    out = np.empty(len(force))
    for k in range(len(force)):
        out[k] = x
        push, left = force[k] + offset, STEP
        while left > 0.0:
            if v == 0.0 and abs(push) <= dry:
                break
            way = np.sign(v) if v != 0.0 else np.sign(push)
            settled, rate = (push - way * dry) / viscous, viscous / mass
            end = settled + (v - settled) * np.exp(-rate * left)
            time = left if end * way > 0.0 else np.log((settled - v) / settled) / rate
            x += settled * time + (v - settled) * (1.0 - np.exp(-rate * time)) / rate
            v = end if time == left else 0.0
            left -= time
    return out


def rmse(numbers, log) -> float:
    """Free-run RMSE [mm] from the start that fits the first 0.5 s best."""
    force, measured = log
    numbers = np.asarray(numbers, float)
    x, v = measured[0], (measured[4] - measured[0]) / (4.0 * STEP)
    for _ in range(6):
        simulated = run(numbers, force[:FIRST], x, v)
        by_v = (run(numbers, force[:FIRST], x, v + 1e-6) - simulated) / 1e-6
        move = np.linalg.lstsq(np.stack([np.ones(FIRST), by_v], axis=1), measured[:FIRST] - simulated, rcond=None)[0]
        x, v = x + move[0], v + move[1]
    return 1e3 * float(np.sqrt(np.mean((run(numbers, force, x, v) - measured)[SKIPPED:] ** 2)))


def optimum(log, viscous: float | None = None) -> np.ndarray:
    """Numbers of least RMSE, the viscous friction held where it is given."""
    bounds = BOUNDS if viscous is None else [b if k != 1 else (viscous, viscous) for k, b in enumerate(BOUNDS)]
    return differential_evolution(rmse, bounds, args=(log,), rng=0, maxiter=120, tol=1e-10).x


def main(folder: Path) -> None:
    """Prints the optimum and the profile over the viscous friction."""
    logs = [np.loadtxt(path, delimiter=",", skiprows=1).T for path in emps(folder)]
    fit, pulses = [(GAIN * u, x) for _, u, x in logs]
    print(f"{'':24s}" + "".join(f"{name:>12s}" for name in NAMES) + "   DATA_EMPS    PULSES  [mm]")

    def row(title: str, numbers) -> None:
        print(
            f"{title:24s}"
            + "".join(f"{v:12.3f}" for v in numbers)
            + f"{rmse(numbers, fit):12.3f}{rmse(numbers, pulses):10.3f}",
            flush=True,
        )

    row("published", list(PUBLISHED.values()))
    row("global optimum", optimum(fit))
    for viscous in range(184, 212, 4):
        row(f"optimum for Fv = {viscous}", optimum(fit, float(viscous)))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/emps"))
