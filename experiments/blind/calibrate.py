"""Limits of the verdict from a campaign over the set `calibrate`, those that `rwjax/diagnosis/settings.py` holds.

`python -m experiments.blind.calibrate RESULTS.jsonl` judges every case again under each combination of limits. It keeps combinations
that name a cause on at most `FALSE` of the rigs that lack nothing, and on at most `CONFIDENT` of the causes outside the list. Of
these it prints the ones that name most of the single causes right. Where these tie, those count that rightly say `unknown` most
often, and then those that lie furthest from the edges of what was tried.
"""

import argparse
from collections.abc import Sequence
from dataclasses import astuple
from itertools import product, starmap
from pathlib import Path
from typing import NamedTuple

from experiments.blind.draw import read
from experiments.blind.score import RIGHT, Judged, judged, outcome
from experiments.speed.table import show
from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.settings import Limits, Settings
from rwjax.diagnosis.verdict import verdict

FALSE, CONFIDENT = 0.01, 0.1
GRID = {
    "nothing": (1.0, 1.25, 1.5),
    "doubt": (1.5, 1.75, 2.0, 2.5),
    "explained": (0.7, 0.75, 0.8, 0.85, 0.9, 0.95),
    "barely": (0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9),
    "several": (0.8, 0.9, 0.95, 0.98),
    "at_floor": (1.1, 1.25, 1.5, 2.0),
}
PRINTED = 8


class Counted(NamedTuple):
    """Shares of a set under some limits."""

    right: float
    unknown: float
    confident: float
    false: float


def again(line: dict, limits: Limits) -> dict:
    """A case's line with the verdict that other limits give; rivals are those that its own verdict listed."""
    if "error" in line:
        return line
    # older lines have the interval on the held-out runs themselves, whose upper end this is
    at_most = line["at_most"] if "at_most" in line else line["ci95"] and line["ci95"][1]
    g = Gap(line["before"], line["after"], line["floor"], line["closed"], None, at_most)
    return line | {"verdict": verdict(len(line["effects"]), bool(line["alternatives"]), g, limits)}


def counted(lines: Sequence[dict], alike: Judged, limits: Limits) -> Counted:
    """How a set comes out under some limits."""
    new = [again(line, limits) for line in lines]

    def share(group: str, hit) -> float:
        members = [line for line in new if line["group"] == group and "error" not in line]
        return sum(map(hit, members)) / max(len(members), 1)

    return Counted(
        share("single", lambda x: outcome(x, alike) in RIGHT),
        share("outside", lambda x: x["verdict"] == "unknown"),
        share("outside", lambda x: x["verdict"] == "effect"),
        share("none", lambda x: x["verdict"] in ("effect", "ambiguous")),
    )


def inner(limits: Limits) -> int:
    """How many of the limits lie on no edge of their grid."""
    return sum(value not in (tried[0], tried[-1]) for value, tried in zip(astuple(limits), GRID.values(), strict=True))


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", type=Path)
    path = parser.parse_args().path
    lines, alike = read(path), judged(path)
    if not lines:
        parser.error(f"{path} holds no results")
    every = {limits: counted(lines, alike, limits) for limits in starmap(Limits, product(*GRID.values()))}
    allowed = [x for x in every if every[x].false <= FALSE and every[x].confident <= CONFIDENT]
    best = sorted(allowed, key=lambda x: (every[x].right, every[x].unknown, inner(x)), reverse=True)[:PRINTED]
    head = [*GRID, "right", "unknown outside", "named outside", "false"]
    rows = [
        [*(f"{v:g}" for v in astuple(x)), *(f"{100 * v:.1f} %" for v in counted(lines, alike, x))]
        for x in (Settings().verdict, *best)
    ]
    rows[0][0] += " (held)"
    show("Limits of the verdict", head, rows)


if __name__ == "__main__":
    main()
