"""How often do fleets in which nothing changed alarm, by their size? `python -m experiments.fleet.few [--tries 1000] [--fleets 12]`

Normal numbers of rigs, three of which a fit estimates, and the misfit, go straight to what decides on alarms: rigs differ by one spread, and from
their mean in each of two sessions by a third of it. In a quarter as many fleets one rig moves in one number, by 5 and by 8 standard deviations of
what sound rigs change by from one session to the other. With `--fleets` so many
sound fleets of 8, 12 and 20 rigs are drawn by `experiments.fleet.draw` and fitted, log by log, as `rwjax fleet` does.
"""

import argparse
import os
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import starmap
from pathlib import Path

import numpy as np
import polars as pl

from experiments.commit import commit
from experiments.fleet.draw import write_fleet
from experiments.fleet.wear import interval
from experiments.speed.table import show
from rwjax.fleet.changes import alarms, changes
from rwjax.fleet.plan import read_plan
from rwjax.fleet.sessions import MISFIT, Estimates
from rwjax.fleet.store import schema
from rwjax.fleet.work import carried_out

SIZES = (8, 12, 20, 50, 200)
DRAWN = (8, 12, 20)
BY = (5.0, 8.0)
"""Standard deviations of a sound rig's change by which one rig moves [1]."""
NAMES = ("axis.inertia", "axis.friction.viscous", "axis.friction.coulomb", MISFIT)
MOVED = 1
"""Index of the number that is moved."""
ERROR, DAYS = np.array([0.05, 0.05, 0.05, 0.0]), np.array([0.3, 0.3, 0.3, 1.0])
"""Standard error of an estimate, and standard deviation from session to session, in spreads over rigs [1]; a misfit has no part that stays."""


def estimates(rigs: int, rng: np.random.Generator, by: float) -> tuple[Estimates, Estimates]:
    """Numbers of the latest of two sessions, and what they have changed by; the first rig has moved in between."""
    shape = (rigs, len(NAMES))
    own = rng.normal(size=shape) * (np.array(NAMES) != MISFIT)
    before, last = (own + DAYS * rng.normal(size=shape) + ERROR * rng.normal(size=shape) for _ in range(2))
    last[0, MOVED] += by * np.sqrt(2.0 * (DAYS[MOVED] ** 2 + ERROR[MOVED] ** 2))
    left = np.broadcast_to(np.diag(ERROR**2), (*shape, len(NAMES)))
    one, none, named = np.ones(shape), np.zeros(shape), tuple(f"rig{k}" for k in range(rigs))
    now = Estimates(NAMES, named, ("2",) * rigs, last, left, one, none)
    return now, now._replace(value=last - before, covariance=2.0 * left, sessions=2.0 * one, before=before)


def alarmed(rigs: int, by: float, seed: int) -> set[str]:
    """Names of the rigs of a fleet that alarm."""
    return set(alarms(*estimates(rigs, np.random.default_rng([rigs, seed]), by))["rig"])


def of_a_size(rigs: int, tries: int) -> list[str]:
    """A line of the table: sound fleets that alarm, moved rigs that are found, and mean share of alarms that are false beside them."""
    line = [str(rigs), interval(sum(bool(alarmed(rigs, 0.0, seed)) for seed in range(tries)), tries)]
    for by in BY:
        found = [alarmed(rigs, by, seed) for seed in range(tries, tries + tries // 4)]
        false = np.mean([len(one - {"rig0"}) / max(len(one), 1) for one in found])
        line += [f"{100.0 * np.mean(['rig0' in one for one in found]):.0f} %", f"{100.0 * false:.1f} %"]
    return line


def fitted(rigs: int, seed: int) -> int:
    """How many rigs alarm of a sound fleet that is drawn and fitted."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_fleet(folder, rigs, seed=seed, processes=1)
        plan = read_plan(folder / "fit.toml")
        rows = [carried_out(job, "fit", {}, "") for job in plan.jobs]
    return changes(pl.DataFrame(rows, schema=schema())).alarms["rig"].n_unique()


def main(arguments: Sequence[str] | None = None) -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tries", type=int, default=1000)
    parser.add_argument("--fleets", type=int, default=0)
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES)
    a = parser.parse_args(arguments)
    os.environ.setdefault("RWJAX_THREADS", "1")
    with ProcessPoolExecutor(2) as pool:
        rows = list(pool.map(partial(of_a_size, tries=a.tries), a.sizes)) if a.tries else []
        jobs = [(rigs, seed) for rigs in DRAWN for seed in range(100, 100 + a.fleets)]
        of_drawn = list(pool.map(fitted, *zip(*jobs, strict=True))) if jobs else []
    if rows:
        head = ["rigs", "sound fleets that alarm (95 %)"]
        for by in BY:
            head += [f"one moved by {by:g}: found", "false alarms, mean share"]
        show(f"{a.tries} sound fleets a line, {a.tries // 4} with a rig that moved; commit {commit()}", head, rows)
    if jobs:
        counts = {n: [k for (rigs, _), k in zip(jobs, of_drawn, strict=True) if rigs == n] for n in DRAWN}
        lines = list(starmap(_line, counts.items()))
        show(
            f"drawn and fitted; commit {commit()}", ["rigs", "sound fleets that alarm", "sound rigs that alarm"], lines
        )


def _line(rigs: int, counts: list[int]) -> list[str]:
    return [str(rigs), interval(sum(map(bool, counts)), len(counts)), interval(sum(counts), rigs * len(counts))]


if __name__ == "__main__":
    main()
