"""Coverage of the 95 % intervals of `rwjax fit` on simulated rigs that lack nothing, and what each kind of interval costs.

`python -m experiments.coverage.run [RIGS] [KIND …] [--processes 2 | --scheduler ADDRESS]` (334 rigs of each kind by default: 1002 in all). Every twentieth rig also
gets intervals by the profile and by the bootstrap. A row is called off if its coverage differs from 95 % at the 5 % level
after Holm's correction for all rows of the table.
"""

import argparse
import tempfile
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest

from experiments.blind.cases import KINDS, make_case, write_case
from experiments.workers import Workers, pool
from rwjax import read_logs, read_rig
from rwjax.fitting.bootstrap import bootstrap
from rwjax.fitting.fit import fit
from rwjax.fitting.profile import interval

FIRST_SEED = 50_000
EVERY = 20
DRAWS = 200


class Hit(NamedTuple):
    """One interval: of which number, by which method, does it hold the truth, its length against the standard error."""

    number: str
    method: str
    holds: bool
    length: float
    seconds: float


def hits(kind: str, seed: int) -> list[Hit]:
    """Intervals of every free number of one rig that has a standard error."""
    with tempfile.TemporaryDirectory() as folder:
        case = make_case(kind, None, seed)
        write_case(case, Path(folder))
        rig = read_rig(Path(folder) / "rig.toml")
        logs = read_logs(sorted(Path(folder).glob("*.csv")), rig)
    begin = perf_counter()
    found = fit(rig, logs)
    took = perf_counter() - begin
    errors, truth = found.uncertainty.standard_error, case.truth["true_numbers"]
    names = [name for name in truth if np.isfinite(errors[name])]
    value = found.fit.numbers()
    ends = {("sandwich", n): ((value[n] - 1.96 * errors[n], value[n] + 1.96 * errors[n]), took) for n in names}
    if seed % EVERY == 0:
        begin = perf_counter()
        drawn = np.percentile(bootstrap(found.fit, DRAWS), (2.5, 97.5), axis=0).T
        took = perf_counter() - begin
        ends |= {("bootstrap", n): (pair, took) for n, pair in zip(found.fit.free, drawn, strict=True) if n in names}
        for name in names:
            begin = perf_counter()
            k = found.fit.free.index(name)
            number = int(found.fit.coordinates.index[k])
            pair = interval(found.fit, number, float(found.uncertainty.inflation[k]), errors[name])
            ends["profile", name] = pair, perf_counter() - begin
    return [
        Hit(name, method, bool(low <= truth[name] <= high), (high - low) / (3.92 * errors[name]), seconds)
        for (method, name), ((low, high), seconds) in ends.items()
    ]


def holm(p: np.ndarray) -> np.ndarray:
    """P values of several tests corrected for their number (Holm, Scandinavian Journal of Statistics 6, 1979)."""
    order = np.argsort(p)
    corrected = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    return np.minimum(corrected, 1.0)[np.argsort(order)]


def main(rigs: int, kinds: list[str], workers: Workers) -> None:
    """Prints the coverage of each number with its binomial interval."""
    rows: dict[tuple[str, str, str], list[Hit]] = {}
    with pool(workers) as executor:
        for kind in kinds:
            for one in executor.map(partial(hits, kind), range(FIRST_SEED, FIRST_SEED + rigs)):
                for hit in one:
                    rows.setdefault((kind, hit.method, hit.number), []).append(hit)
    for kind in kinds:
        for method in ("sandwich", "bootstrap", "profile"):
            every = [hit for key, found in rows.items() if key[:2] == (kind, method) for hit in found]
            if every:
                rows[kind, method, "all"] = every
    tests = {key: binomtest(sum(hit.holds for hit in found), len(found), 0.95) for key, found in rows.items()}
    corrected = dict(zip(tests, holm(np.array([t.pvalue for t in tests.values()])), strict=True))
    print("| kind | interval | number | intervals | hold the truth | p, corrected | length/sandwich | seconds |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for key in sorted(rows):
        found, t = rows[key], tests[key]
        low, high = t.proportion_ci(method="exact")
        print(
            f"| {' | '.join(key)} | {len(found)} | {100 * t.statistic:.1f} % ({100 * low:.1f} to {100 * high:.1f}) "
            f"| {corrected[key]:.2g}{' **off**' if corrected[key] < 0.05 else ''} "
            f"| {np.median([hit.length for hit in found]):.2f} | {np.median([hit.seconds for hit in found]):.2f} |"
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rigs", type=int, nargs="?", default=334)
    parser.add_argument("kinds", nargs="*", default=[*KINDS])
    Workers.options(parser)
    a = parser.parse_args()
    main(a.rigs, a.kinds, Workers.of(a))
