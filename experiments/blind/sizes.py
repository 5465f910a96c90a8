"""The amplitude at which a case has a wanted size: what the best-fitted rig without the effect leaves of held-out logs.

`python -m experiments.blind.sizes --kind platform --effect axis.stribeck --seed 3 --size 10`
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.blind.cases import KINDS, Case, make_case
from experiments.blind.oracle import Fit, perfect, refit, size

LOW, HIGH = 1e-4, 30.0  # amplitudes that are tried
WITHIN = 1.3  # factor of the wanted size that will do
SMALLEST, LARGEST = 3.0, 30.0  # sizes that count as seen and not yet as gross
STEPS = 16
COARSE = 1e-3  # s, step of the fits that only measure a size
EVALUATIONS = 8
WIDTH = 0.02  # of a bracket of log-amplitudes that holds a jump


@dataclass(frozen=True)
class Sized:
    """A case at its size, with the refit of the rig without the effect that measured it."""

    case: Case
    size: float
    base: Fit


class OutOfReach(ValueError):
    """No amplitude gives the wanted size; says why."""


def reach(measure: Callable[[float], float], wanted: float, first: float, allowed: tuple[float, float]) -> float:
    """Amplitude at which `measure(amplitude)` has a size near the one wanted and within what is allowed.

    By bisection on the amplitude's logarithm, which begins at `first`.
    """
    low, high = np.log(LOW), np.log(HIGH)
    below: tuple[float, float] | None = None  # logarithms of amplitude and size
    above: tuple[float, float] | None = None
    goal, x = np.log(wanted), first
    for _ in range(STEPS):
        amplitude = float(f"{np.exp(x):.4g}")
        found = measure(amplitude)
        if max(wanted / WITHIN, allowed[0]) <= found <= min(wanted * WITHIN, allowed[1]):
            return amplitude
        y = np.log(max(found, 0.1))
        if found < wanted:
            below = (x, y)
        else:
            above = (x, y)
        if below and above:
            if abs(above[0] - below[0]) < WIDTH:
                raise OutOfReach(f"size jumps from {np.exp(below[1]):.3g} to {np.exp(above[1]):.3g}")
            share = (goal - below[1]) / (above[1] - below[1])
            x = below[0] + float(np.clip(share, 0.15, 0.85)) * (above[0] - below[0])
        elif x in (low, high):
            raise OutOfReach(f"size {found:.3g} at amplitude {np.exp(x):.4g}")
        else:
            x = float(np.clip(x + np.sign(goal - y) * np.clip(1.2 * abs(goal - y), 0.3, 2.5), low, high))
    raise OutOfReach(f"no amplitude found in {STEPS} steps")


def sized(kind: str, effect: str, seed: int, wanted: float) -> Sized:
    """The case of a seed at the wanted size; all its causes have one amplitude."""
    return sized_by(lambda amplitude, raw: make_case(kind, effect, seed, amplitude, raw), wanted)


def sized_by(make: Callable[[float, bool], Case], wanted: float) -> Sized:
    """The case `make(amplitude, raw)` at the wanted size, each time by a refit of the rig without effects."""
    first: dict[str, float] | None = None
    tried: dict[float, Sized] = {}

    def measure(amplitude: float) -> float:
        nonlocal first
        case = make(amplitude, False)
        base = refit(case, None, evaluations=EVALUATIONS, step=COARSE, first=first)
        found = size(base.gap, perfect(case, COARSE))
        first = base.numbers if found < wanted else first
        tried[amplitude] = Sized(case, found, base)
        return found

    raw = make(1.0, True).truth["raw_size"]
    x = float(np.clip(np.log(wanted) - np.log(raw), np.log(0.02), np.log(10.0))) if 0.0 < raw < np.inf else 0.0
    return tried[reach(measure, wanted, x, (SMALLEST, LARGEST))]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--effect", required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--size", type=float, default=10.0)
    a = parser.parse_args()
    found = sized(a.kind, a.effect, a.seed, a.size)
    print(f"amplitude {found.case.truth['amplitude']:.4g}, size {found.size:.3g}")


if __name__ == "__main__":
    main()
