"""Coverage of the 95 % intervals of `rwjax fit` on simulated rigs that lack nothing.

`python -m experiments.coverage.run [RIGS] [KIND …]` (200 rigs of each kind by default)
"""

import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
from scipy.stats import binomtest

from experiments.blind.cases import KINDS, make_case, write_case
from rwjax import read_logs, read_rig
from rwjax.fit.rig_fit import fit_rig

FIRST_SEED = 50_000


def hits(kind: str, seed: int) -> list[tuple[str, float]]:
    """(number, error in standard errors) for every free number of one rig that has a standard error."""
    with tempfile.TemporaryDirectory() as folder:
        case = make_case(kind, None, seed)
        write_case(case, Path(folder))
        rig = read_rig(Path(folder) / "rig.toml")
        result = fit_rig(rig, read_logs(sorted(Path(folder).glob("*.csv")), rig))
    error = result.uncertainty.standard_error
    truth = case.truth["true_numbers"]
    return [(n, (result.rig.values[n] - truth[n]) / error[n]) for n in truth if np.isfinite(error[n])]


def main(rigs: int, kinds: list[str]) -> None:
    """Prints the coverage of each number with its binomial interval."""
    for kind in kinds:
        with ThreadPoolExecutor(2) as pool:
            found = [
                pair for one in pool.map(partial(hits, kind), range(FIRST_SEED, FIRST_SEED + rigs)) for pair in one
            ]
        for name in [*dict.fromkeys(name for name, _ in found), "all"]:
            z = np.array([value for other, value in found if name in (other, "all")])
            inside = int(np.sum(np.abs(z) <= 1.96))
            low, high = binomtest(inside, len(z)).proportion_ci(method="exact")
            spread = 1.4826 * np.median(np.abs(z))
            print(
                f"{kind:9s} {name:24s} {len(z):4d} intervals, {100 * inside / len(z):5.1f} % hold the truth "
                f"({100 * low:.1f} to {100 * high:.1f}), median error {np.median(z):+.2f}, spread {spread:.2f} standard errors",
                flush=True,
            )


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    main(count, sys.argv[2:] or list(KINDS))
