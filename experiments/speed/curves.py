"""Fresh processes, cost over effects and log length, many fits, scattered starts."""

import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.speed import c_limit, scipy_numba
from experiments.speed.problem import BELIEVED, COUNT, EFFECTS, arrays, log, posed, rig, with_effects
from experiments.speed.table import seconds, show, timed
from rwjax import write_log
from rwjax.fitting.fit import fit
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.rig.write import write_rig

LENGTHS = (10.0, 30.0, 60.0, 300.0, 1800.0, 10800.0)
NUMBA_UP_TO = 1800.0  # s: its dense Jacobian of a longer log takes minutes
FITS = 32
STARTS = 256
SCATTER = 0.25
REACHED = 1e-3


def one_start(believed: np.ndarray = BELIEVED) -> Fit:
    """The library's fit from one start alone, to the last digit and without standard errors."""
    problem, moves, theta = posed(log(), believed)
    return least_squares(problem, moves, theta, nodes=measured_nodes(problem, theta))


def fresh(rounds: int = 3) -> None:
    """From a process's start to the fitted numbers, by stages, with a cold and a warm cache of compiled programs."""
    with tempfile.TemporaryDirectory() as folder:
        record = log()
        counts = np.rint(record.outputs["yaw_rad"] / COUNT).astype(int)
        write_log(Path(folder) / "log.csv", {"time_s": record.time, "voltage_V": record.command, "yaw_counts": counts})
        (Path(folder) / "rig.toml").write_text(write_rig(rig()))
        environment = os.environ | {"JAX_COMPILATION_CACHE_DIR": f"{folder}/cache"}
        command = [sys.executable, "-m", "experiments.speed.fresh", folder]

        def once() -> dict:
            spent, done = timed(lambda: subprocess.run(command, env=environment, capture_output=True, check=True))
            return json.loads(done.stdout) | {"process": spent}

        cold = once()
        warm = [once() for _ in range(rounds)]
    stages = [name for name in cold if name != "cost"]
    middle = {name: float(np.median([w[name] for w in warm])) for name in stages}
    rows = [[kind, *(seconds(s[name]) for name in stages)] for kind, s in (("cold", cold), ("warm", middle))]
    show("Fresh process (the process's time holds a second fit)", ["cache", *stages], rows)


def effects(rounds: int = 7) -> list[tuple[int, float]]:
    """Time of a fit over the number of added effects; returns (free numbers, seconds)."""
    rows, points = [], []
    for count in range(len(EFFECTS) + 1):
        believed, truth = with_effects(count)
        record = log(truth=truth)
        first, _ = timed(fit, believed, [record])
        times = []
        for _ in range(rounds):
            spent, found = timed(fit, believed, [record])
            times.append(spent)
        numbers, readings = len(believed.free), found.fit.problem.batch.readings
        points.append((numbers, float(np.median(times))))
        added = EFFECTS[count - 1].name if count else "none"
        mean_square = f"{2.0 * found.fit.cost / readings:.3f}"
        rows.append(
            [f"+ {added}" if count else "none", str(numbers), seconds(points[-1][1]), seconds(first), mean_square]
        )
    head = ["effects, one more a row", "free numbers", "`fit`", "first call", "mean square in units of noise"]
    show("Over the number of effects", head, rows)
    return points


def length() -> list[tuple[float, float, float]]:
    """Time of a fit over the log's length; returns (seconds of log, rwjax, C)."""
    rows, points = [], []
    scipy_numba.fit(arrays(log()))  # compiles
    for duration in LENGTHS:
        record, believed = log(duration), rig()
        a = arrays(record)
        fitter = c_limit.Fitter(a)
        first, _ = timed(fit, believed, [record])
        runs = [timed(fit, believed, [record]) for _ in range(5 if duration <= 300.0 else 1)]
        fits = [timed(fitter.fit, BELIEVED) for _ in range(5)]
        ours, limit = (float(np.median([spent for spent, _ in found])) for found in (runs, fits))
        points.append((duration, ours, limit))
        found, best = runs[0][1].fit, fits[0][1]
        numba, other = timed(scipy_numba.fit, a) if duration <= NUMBA_UP_TO else (np.nan, None)
        batch = found.problem.batch
        rows.append(
            [
                f"{duration:g} s",
                f"{batch.windows} x {len(batch.step_index)}",
                seconds(ours),
                seconds(first),
                _same(found.cost, best.cost),
                seconds(limit),
                seconds(numba) if other else "-",
                _same(other.cost, best.cost) if other else "-",
            ]
        )
    rows += [_slopes("slope", points), _slopes("slope from 60 s on", [p for p in points if p[0] >= 60.0])]
    head = ["log", "windows x steps", "`fit`", "first call", "C's optimum", "C", "scipy + numba", "C's optimum"]
    show("Over the log's length", head, rows)
    return points


def _same(cost: float, best: float) -> str:
    return "yes" if abs(cost - best) <= REACHED * best else "no"


def _slopes(name: str, points: list[tuple[float, float, float]]) -> list[str]:
    """Row with the exponents of time over length of the library and of C."""
    ours, limit = np.polyfit(np.log([p[0] for p in points]), np.log([p[1:] for p in points]), 1)[0]
    return [name, "", f"{ours:.2f}", "", "", f"{limit:.2f}", "", ""]


def threads() -> None:
    """Many fits one at a time and on two threads over one compiled program."""
    starts = BELIEVED * np.exp(SCATTER * np.random.default_rng(1).normal(size=(FITS, 3)))
    record = log()

    def one(believed: np.ndarray) -> None:
        fit(rig(believed), [record])

    one(BELIEVED)
    alone, both = [], []
    for _ in range(3):
        alone.append(timed(lambda: [one(s) for s in starts])[0])
        with ThreadPoolExecutor(2) as pool:
            both.append(timed(lambda: list(pool.map(one, starts)))[0])
    gain = float(np.median(np.array(alone) / np.array(both)))
    show(
        f"{FITS} fits from different starts",
        ["way", "fits a second"],
        [
            ["one at a time", f"{FITS / np.median(alone):.3g}"],
            ["two threads", f"{FITS / np.median(both):.3g} ({gain:.2f} times)"],
        ],
    )


def starts() -> None:
    """Share of scattered starts from which the optimum is reached."""
    record, rng = log(), np.random.default_rng(0)
    scattered = BELIEVED * np.exp(SCATTER * rng.normal(size=(STARTS, 3)))
    a = arrays(record)
    fitter = c_limit.Fitter(a)
    limit = np.array([fitter.fit(s).cost for s in scattered])
    numba = np.array([scipy_numba.fit(replace(a, believed=s)).cost for s in scattered])
    ours = np.array([fit(rig(s), [record]).fit.cost for s in scattered])
    single = np.array([one_start(s).cost for s in scattered])
    best = min(limit.min(), ours.min())
    rows = [
        [name, f"{np.sum(cost <= (1.0 + REACHED) * best)} of {STARTS}"]
        for name, cost in (
            ("`fit`", ours),
            ("rwjax from one start", single),
            ("C", limit),
            ("scipy + numba", numba),
        )
    ]
    show(f"Starts scattered by {SCATTER:g} in the logarithm about the common one", ["way", "reach the optimum"], rows)
