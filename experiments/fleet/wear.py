"""How many changed rigs of a simulated fleet are found, and how many alarms are false: `python -m experiments.fleet.wear FOLDER`

FOLDER is what `experiments.fleet.draw` wrote, with the results of `rwjax fleet FOLDER/fit.toml -o FOLDER/fitted`. A worn rig counts as found
where an alarm names its number, alone or beside others; a rig with a new effect where any alarm is on it. With the results of the diagnoses
of those rigs (`rwjax fleet FOLDER/diagnose.toml -o FOLDER/diagnosed`) it also says how often the effect is named.
"""

import argparse
import json
from pathlib import Path

import polars as pl
from scipy.stats import binomtest

from experiments.commit import commit
from experiments.fleet.draw import WEARS
from experiments.speed.table import machine, show
from rwjax.fleet.changes import changes
from rwjax.fleet.store import RESULTS

LEVELS = (0.01, 0.05)
"""Shares of false alarms that are allowed [1]."""
NUMBER = f"axis.friction.{WEARS}"


def counted(label: dict[str, str], alarms: pl.DataFrame, rigs: int) -> dict[str, tuple[int, int]]:
    """Of each kind of rig how many are found, and how many there are."""
    on: dict[str, set[str]] = {}
    for one in alarms.iter_rows(named=True):
        on.setdefault(one["rig"], set()).update([one["number"], *one["or"].split(", ")])
    worn = [rig for rig, kind in label.items() if kind == "worn"]
    new = [rig for rig, kind in label.items() if kind == "appears"]
    return {
        "worn rigs, their number named": (sum(NUMBER in on.get(rig, ()) for rig in worn), len(worn)),
        "rigs with a new effect, any alarm": (sum(rig in on for rig in new), len(new)),
        "sound rigs, any alarm": (len(on.keys() - label.keys()), rigs - len(label)),
        "alarms that are false": (len(on.keys() - label.keys()), len(on)),
    }


def interval(found: int, of: int) -> str:
    """A share with its 95 % interval (Clopper and Pearson)."""
    if not of:
        return "-"
    low, high = binomtest(found, of).proportion_ci(method="exact")
    return f"{found} of {of}: {100 * found / of:.1f} % ({100 * low:.1f} to {100 * high:.1f})"


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    a = parser.parse_args()
    label = json.loads((a.folder / "label.json").read_text())
    rows = pl.read_parquet(a.folder / "fitted" / RESULTS)
    table = []
    for false in LEVELS:
        counts = counted(label, changes(rows, false).alarms, rows["rig"].n_unique())
        table += [[f"{false:g}", what, interval(*n)] for what, n in counts.items()]
    if (path := a.folder / "diagnosed" / RESULTS).exists():
        last = pl.read_parquet(path).sort("when").unique("rig", keep="last").filter(status="done")
        table += [
            ["-", f"{kind or 'sound'} rigs diagnosed as {verdict} {names}".strip(), str(n)]
            for kind, verdict, names, n in named(last, label)
        ]
    show(f"commit {commit()}; {machine()}", ["--false-alarms", "what", "how many"], table)


def named(rows: pl.DataFrame, label: dict[str, str]) -> list[tuple[str, str, str, int]]:
    """Verdicts and names of diagnoses by kind of rig, each with its count."""
    kinds = rows.with_columns(
        kind=pl.col("rig").replace_strict(label, default=""), names=pl.col("effects").list.join("; or ")
    )
    return kinds.group_by("kind", "verdict", "names").len().sort("kind", "len", descending=[False, True]).rows()


if __name__ == "__main__":
    main()
