"""Identification methods side by side on simulated rigs that lack nothing: error, bias, coverage, held-out gap and time.

`python -m experiments.methods.run [RIGS] [KIND …]` (5 rigs of each kind by default; the Kalman filter takes most of the time)
"""

import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from time import perf_counter

import numpy as np

from experiments.blind.cases import KINDS, make_case, write_case
from rwjax import read_logs, read_rig
from rwjax.methods.comparison import METHODS, compare

FIRST_SEED = 70_000


def main(rigs: int, kinds: list[str]) -> None:
    """Prints one table for each kind of rig."""
    for kind in kinds:
        error, inside, gap, seconds = (defaultdict(list) for _ in range(4))
        begin = perf_counter()
        for seed in range(FIRST_SEED, FIRST_SEED + rigs):
            with tempfile.TemporaryDirectory() as folder:
                case = make_case(kind, None, seed)
                write_case(case, Path(folder))
                rig = read_rig(Path(folder) / "rig.toml")
                found = compare(rig, read_logs(sorted(Path(folder).glob("*.csv")), rig))
            truth = case.truth["true_numbers"]
            for row in found.rows:
                if row.rig is None:
                    continue
                name = row.method.name
                seconds[name].append(row.seconds)
                worst = max(found.floor, key=lambda y: row.rms[y] / found.floor[y])
                gap[name].append(row.rms[worst] / found.floor[worst])
                for number, value in truth.items():
                    if number in row.rig.standard_error:  # the method estimates it
                        off = row.rig.values[number] - value
                        error[name].append(off / value)
                        inside[name].append(abs(off) < 1.96 * row.rig.standard_error[number])
        print(f"{kind}, {rigs} rigs, {perf_counter() - begin:.0f} s")
        print(
            f"  {'method':20s} {'used':>5s} {'median |error|':>15s} {'median error':>13s} {'95 % hold':>10s} {'gap/floor':>10s} {'time [s]':>9s}"
        )
        for name in (method.name for method in METHODS):
            e = 100.0 * np.array(error[name])
            if len(e):
                print(
                    f"  {name:20s} {len(seconds[name]):5d} {np.median(np.abs(e)):13.4f} % {np.median(e):+11.4f} % "
                    f"{100 * np.mean(inside[name]):8.0f} % {np.median(gap[name]):10.3g} {np.median(seconds[name]):9.2f}",
                    flush=True,
                )
            else:
                print(f"  {name:20s}     0   (these logs do not suit it)", flush=True)


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    main(count, sys.argv[2:] or list(KINDS))
