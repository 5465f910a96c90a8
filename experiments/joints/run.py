"""How often the 95 % intervals of `rwjax fit` hold the truth on joints of another simulator, for each sort of command.

`python -m experiments.joints.run [--rigs 50] [--processes 2 | --scheduler ADDRESS] [--sorts voltage duty goal torque_off] [-o build/joints.jsonl]` fits
what the file does not hold yet, one JSON line each, and prints the table of all that it holds then. `--table` prints it alone.
A row is called off if its coverage differs from 95 % at the 5 % level after Holm's correction for all rows of the table.
"""

import argparse
import tempfile
import traceback
from pathlib import Path
from time import perf_counter

import numpy as np
from scipy.stats import binomtest

from experiments.blind.campaign import run
from experiments.blind.cases import write_case
from experiments.blind.draw import read
from experiments.coverage.run import holm
from experiments.joints.draw import SORTS, draw, make_case
from experiments.workers import Workers
from rwjax import read_logs, read_rig
from rwjax.fitting.fit import fit

FIRST_SEED = 260_000
ASKED = (0.90, 0.98)  # coverage


def answer(row: dict) -> dict:
    """The line of one joint: every free number with its truth and its interval, what the fit said, what it leaves of the angle."""
    begin = perf_counter()
    try:
        with tempfile.TemporaryDirectory() as folder:
            case = make_case(row["sort"], row["seed"])
            write_case(case, Path(folder))
            rig = read_rig(Path(folder) / "rig.toml")
            logs = read_logs(sorted(Path(folder).glob("*.csv")), rig)
        row = row | {"acts_on": case.truth["acts_on"]}
        found = fit(rig, logs)
        value, error = found.fit.numbers(), found.uncertainty.standard_error
        seconds = perf_counter() - begin
        numbers = {
            name: {"true": true, "value": float(value[name]), "error": float(error[name])}
            | {"interval": [float(end) for end in found.interval[name]]}
            for name, true in case.truth["true_numbers"].items()
        }
        return row | {
            "seconds": round(seconds, 1),
            "numbers": numbers,
            "converged": bool(found.fit.converged),
            "misfit": found.rms["yaw_rad"] / noise(row),
            "notes": list(found.notes),
        }
    except Exception as failed:
        lines = traceback.format_exc().splitlines()
        return row | {"seconds": round(perf_counter() - begin, 1), "failed": repr(failed), "trace": lines[-8:]}


def noise(row: dict) -> float:
    """Noise and rounding of the angle [rad]."""
    drawn = draw(row["sort"], row["seed"])
    rounding = 2 * np.pi / drawn.counts / np.sqrt(12.0) if drawn.counts else 0.0
    return float(np.hypot(next(iter(drawn.noise.values())), rounding))


def holds(number: dict) -> bool:
    """Whether the truth lies within the interval."""
    low, high = number["interval"]
    return low <= number["true"] <= high


def table(lines: list[dict]) -> str:
    """Coverage by sort and number with its binomial interval, seconds of a fit, and what failed."""
    fitted = [line for line in lines if "numbers" in line]
    rows: dict[tuple[str, str], list[dict]] = {}
    for line in fitted:
        for name, number in line["numbers"].items():
            if np.all(np.isfinite(number["interval"])):
                rows.setdefault((line["sort"], name), []).append(number)
                rows.setdefault((line["sort"], "all"), []).append(number)
                rows.setdefault(("all", name), []).append(number)
                rows.setdefault(("all", "all"), []).append(number)
    text = [
        "| command | number | intervals | hold the truth | p, corrected | standard error by size | off, in standard errors |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    keys = sorted(rows, key=lambda key: ([*SORTS, "all"].index(key[0]), key[1]))
    tests = [binomtest(sum(map(holds, rows[key])), len(rows[key]), 0.95) for key in keys]
    corrected = holm(np.array([t.pvalue for t in tests])) if tests else []
    for key, t, p in zip(keys, tests, corrected, strict=True):
        low, high = t.proportion_ci(method="exact")
        size = np.median([abs(n["error"] / n["true"]) for n in rows[key]])
        off = np.array([(n["value"] - n["true"]) / n["error"] for n in rows[key]])
        text.append(
            f"| {' | '.join(key)} | {len(rows[key])} | {100 * t.statistic:.1f} % ({100 * low:.1f} to {100 * high:.1f}) "
            f"| {p:.2g}{' **off**' if p < 0.05 else ''} | {100 * size:.2g} % | {np.median(off):+.2f}, 1σ {_spread(off):.2f} |"
        )
    text.append("")
    for sort in SORTS:
        of_sort = [line for line in fitted if line["sort"] == sort]
        if of_sort:
            seconds, off = ([line[key] for line in of_sort] for key in ("seconds", "misfit"))
            text.append(
                f"{sort}: {len(of_sort)} fits, {np.median(seconds):.1f} s each (most {max(seconds):.0f}); "
                f"the angle misses by {np.median(off):.2f} of its noise (most {max(off):.2f})"
            )
    text += [f"{line['sort']} {line['seed']} failed: {line['failed']}" for line in lines if "failed" in line]
    return "\n".join(text)


def _spread(off: np.ndarray) -> float:
    """Half the range of the middle 68 %."""
    return float(np.ptp(np.quantile(off, (0.16, 0.84)))) / 2.0


def rigs(count: int, sorts: list[str]) -> list[dict]:
    """The joints of a campaign, their sorts in turn."""
    every = [(SORTS.index(sort) * 100_000 + k, sort, k) for k in range(count) for sort in sorts]
    return [{"index": index, "sort": sort, "seed": FIRST_SEED + k} for index, sort, k in every]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rigs", type=int, default=50, help="of each sort")
    Workers.options(parser)
    parser.add_argument("--sorts", nargs="+", choices=SORTS, default=SORTS)
    parser.add_argument("--table", action="store_true", help="only print what the file holds")
    parser.add_argument("-o", dest="path", type=Path, default=Path("build/joints.jsonl"))
    a = parser.parse_args()
    if not a.table:
        run(rigs(a.rigs, a.sorts), a.path, Workers.of(a), answer)
    print(table(read(a.path)))


if __name__ == "__main__":
    main()
