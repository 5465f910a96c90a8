"""Do estimates of rigs pooled tell what one fit of all their logs tells? `python -m experiments.fleet.pooled [--fleets 10] [--rigs 20]`

Rigs of one inertia, whose frictions differ, each measured by one run. The numbers come from the logs of each rig alone; from one fit of the logs
of all rigs, with one inertia and each rig's own friction; and from the estimates alone, pooled. Their errors are counted in standard errors of
the first way.
"""

import argparse
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl

from experiments.blind.commands import TICK, command
from experiments.blind.simulator import simulate
from experiments.blind.truth import OMEGA, PSI, Truth
from experiments.commit import commit
from experiments.fleet.draw import COUNTS, DESIGN, DIFFER, RIG, TOP, name_of
from experiments.speed.table import machine, show
from rwjax import fit, parse_rig, read_logs, write_log
from rwjax.fleet.plan import Job
from rwjax.fleet.pooled import pooled
from rwjax.fleet.sessions import common, latest, sessions_of
from rwjax.fleet.store import schema
from rwjax.fleet.work import carried_out
from rwjax.logs.log import Log

SECONDS = 5.0
SHARED = "axis.inertia"
OWN = ("axis.friction.viscous", "axis.friction.coulomb")
WAYS = ("alone", "one fit of all logs", "pooled")


def drawn(number: int, seed: int) -> Truth:
    """The truth of a rig: the design's inertia, frictions of its own."""
    rng = np.random.default_rng([seed, number])
    own = {name: getattr(DESIGN, name) * (1.0 + DIFFER[name] * rng.normal()) for name in ("viscous", "coulomb")}
    return replace(DESIGN, **own)


def written(truth: Truth, path: Path, rng: np.random.Generator) -> None:
    """Writes the log of a rig."""
    u = command("multisine", SECONDS, TOP, rng)
    t = np.round(TICK * np.arange(len(u)), 3)
    x = simulate(t, u, t, np.zeros(5), truth.array())
    counts = np.floor(x[:, PSI] * COUNTS / (2.0 * np.pi) + 0.5)
    rate = np.round(x[:, OMEGA] + rng.normal(0.0, 0.5, len(u)), 2)
    write_log(path, {"time_s": t, "voltage_V": u, "yaw_counts": counts, "wheel_rad_s": rate}, {})


def estimated(logs: Sequence[Log], folder: Path) -> tuple[dict[str, dict[str, np.ndarray]], list[float]]:
    """Numbers by name and way, with their standard errors, both (2, rigs), and seconds of the one fit and of those of each rig."""
    rig = parse_rig(RIG)
    (folder / "rig.toml").write_text(RIG)
    begin = time.perf_counter()
    jobs = [
        Job(Path(log.name).stem, "", str(folder / "rig.toml"), (str(folder / Path(log.name).name),)) for log in logs
    ]
    rows = pl.DataFrame([carried_out(job, "fit", {}, "") for job in jobs], schema=schema())
    each = time.perf_counter() - begin
    sessions = sessions_of(rows)
    own = pooled(latest(sessions, common(sessions)), [SHARED]).own.sort("rig")
    begin = time.perf_counter()
    whole = fit(replace(rig, per_run=OWN), logs)
    all_at_once = time.perf_counter() - begin
    values, errors = whole.fit.numbers(), whole.uncertainty.standard_error
    found: dict[str, dict[str, np.ndarray]] = {}
    for name in (SHARED, *OWN):
        one = own.filter(number=name)
        keys = [name if name == SHARED else f"{name} in {Path(log.name).name}" for log in logs]
        found[name] = {
            "alone": one.select("alone", "alone_error").to_numpy().T,
            "one fit of all logs": np.array([[values[key] for key in keys], [errors[key] for key in keys]]),
            "pooled": one.select("value", "standard_error").to_numpy().T,
        }
    return found, [all_at_once, each]


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fleets", type=int, default=10)
    parser.add_argument("--rigs", type=int, default=20)
    a = parser.parse_args()
    off: dict[tuple[str, str], list[np.ndarray]] = {}
    held: dict[tuple[str, str], list[np.ndarray]] = {}
    seconds = []
    for seed in range(a.fleets):
        truths = [drawn(number, seed) for number in range(a.rigs)]
        with tempfile.TemporaryDirectory() as place:
            rng, folder = np.random.default_rng([seed, a.rigs, 1]), Path(place)
            for number, truth in enumerate(truths):
                written(truth, folder / f"{name_of(number)}.csv", rng)
            found, took = estimated(read_logs(sorted(folder.glob("*.csv")), parse_rig(RIG)), folder)
        seconds.append(took)
        for name, ways in found.items():
            true = np.array(
                [truth.I if name == SHARED else getattr(truth, name.rpartition(".")[2]) for truth in truths]
            )
            for way, (value, error) in ways.items():
                off.setdefault((name, way), []).append((value - true) / ways["alone"][1])
                held.setdefault((name, way), []).append(np.abs(value - true) < 1.96 * error)
    rows = [
        [
            name,
            way,
            f"{np.sqrt(np.mean(np.square(off[name, way]))):.2f}",
            f"{100.0 * np.mean(held[name, way]):.1f} %",
        ]
        for name in (SHARED, *OWN)
        for way in WAYS
    ]
    all_at_once, each = np.median(seconds, axis=0)
    show(
        f"{a.fleets} fleets of {a.rigs} rigs; one fit of all logs {all_at_once:.1f} s, fits of each {each:.1f} s; "
        f"commit {commit()}; {machine()}",
        ["number", "way", "RMS error, in standard errors of a rig alone", "95 % intervals that hold"],
        rows,
    )


if __name__ == "__main__":
    main()
