"""Do gains that hold for every plant which a fit allows hold for the rig? `python -m experiments.control.holds [RIGS] [KIND …]`.

RIGS simulated rigs that lack nothing (`experiments/blind`, 100 of each kind by default) are fitted. At one K_d, the smallest K_p that puts
a real pole left of -sigma is then worked out three times: for the fitted rig alone, for 1000 plants drawn from the fit's covariance
(the largest of theirs), and for the rig's true numbers, which neither of the others knows.

The largest of 1000 draws lies three standard deviations out. It would hide a standard error that is 1.5 times too small. The rank of the
true limit among the draws does not: in 5 % of the rigs it has to lie among the outer 5 %. A map of pairs would hide the question, since
the fits are so sharp that all three regions hold the same pairs of a grid of 101 by 101.
"""

import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest

from experiments.blind.cases import make_case, write_case
from experiments.speed.table import show
from rwjax import Rig, read_logs, read_rig
from rwjax.control.boundary import real_boundary
from rwjax.control.fit_estimate import FitEstimate, draw_plants
from rwjax.control.linear import linearised
from rwjax.control.transfer import transfer
from rwjax.errors import InputError
from rwjax.fitting.fit import fit

FIRST_SEED = 90_000
PLANTS = 1000
SIGMA, DAMPED = 2.0, 16.0
"""Every pole left of minus this [1/s]; damping that K_d gives the bare inertia [1/s]."""


OUTER = 0.05
"""Share of the draws, half of it at either end, in which the true limit lies by chance as often."""


class Limits(NamedTuple):
    """Smallest K_p [V/rad] for the fitted rig, for all plants drawn, for the true rig, and the `rank` of that one among the plants'
    own, 0 to 1."""

    fitted: float
    drawn: float
    true: float
    rank: float

    @property
    def outer(self) -> bool:
        return not 0.5 * OUTER <= self.rank <= 1.0 - 0.5 * OUTER


def derivative_gain(rig: Rig) -> float:
    """K_d [V s/rad] at which the bare inertia is damped by `DAMPED`."""
    n = rig.values
    per_volt = n["drive.gain"] if rig.kind == "platform" else n["motor.torque_constant"] / n["motor.resistance"]
    return DAMPED * n["axis.inertia"] / abs(per_volt)


def limits(kind: str, seed: int) -> Limits:
    """The three limits of one rig. Raises `InputError` where its fit cannot be drawn from."""
    with tempfile.TemporaryDirectory() as folder:
        case = make_case(kind, None, seed)
        write_case(case, Path(folder))
        believed = read_rig(Path(folder) / "rig.toml")
        logs = read_logs(sorted(Path(folder).glob("*.csv")), believed)
    found = fit(believed, logs)
    names, numbers = found.uncertainty.names, found.fit.numbers()
    spread = FitEstimate(names, np.array([numbers[name] for name in names]), found.uncertainty.covariance)
    kd = np.array([derivative_gain(believed)])
    plants = transfer(linearised(found.rig, thetas=draw_plants(found.rig, spread, PLANTS, seed))).each()
    true = believed.with_values(case.truth["true_numbers"])
    one, other = (float(real_boundary(transfer(linearised(rig)), kd, SIGMA)[0]) for rig in (found.rig, true))
    drawn = np.array([float(real_boundary(plant, kd, SIGMA)[0]) for plant in plants])
    return Limits(one, float(drawn.max()), other, rank(drawn, other))


def rank(drawn: np.ndarray, true: float) -> float:
    """Share of the draws that lie below the true limit."""
    return float(np.mean(drawn < true))


def main(rigs: int, kinds: list[str]) -> None:
    """Prints a line for each kind."""
    rows = []
    for kind in kinds:
        found, refused = [], 0
        for seed in range(FIRST_SEED, FIRST_SEED + rigs):
            try:
                found.append(limits(kind, seed))
            except InputError:
                refused += 1
        cells = [kind, str(len(found)), str(refused)]
        counts = (
            sum(x.fitted < x.true for x in found),
            sum(x.drawn < x.true for x in found),
            sum(x.outer for x in found),
        )
        for some in counts:
            low, high = binomtest(some, len(found)).proportion_ci(method="exact")
            cells.append(f"{some} ({100 * low:.1f} to {100 * high:.1f} %)")
        more = [100.0 * (x.drawn / x.fitted - 1.0) for x in found]
        rows.append([*cells, f"{np.median(more):.2g} %, {max(more):.2g} %"])
    head = (
        "kind",
        "rigs",
        "refused",
        "fitted rig's too small",
        "that of all plants drawn too small",
        f"true one in the outer {100 * OUTER:g} % of them",
        "larger by (median, most)",
    )
    show(f"smallest K_p with every real pole left of -{SIGMA:g} 1/s", head, rows)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100, sys.argv[2:] or ["platform", "reaction"])
