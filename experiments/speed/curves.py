"""Cost over effects, log length and number of logs, many fits, scattered starts."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from experiments.speed import c_limit, scipy_numba
from experiments.speed.lowering import XLA, by_xla
from experiments.speed.problem import BELIEVED, EFFECTS, arrays, log, posed, rig, with_effects
from experiments.speed.table import Raced, race, seconds, show, timed
from rwjax.fitting.fit import fit
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.shooting_nodes import measured_nodes

OURS, NUMBA = "rwjax", "scipy + numba"
LENGTHS = (10.0, 30.0, 60.0, 300.0, 1800.0, 10800.0)
NUMBA_UP_TO = 1800.0  # s: its dense Jacobian of a longer log takes minutes
COUNTS = (1, 3, 10, 30, 100, 200)
EACH = 10.0  # s
FEW = 30  # logs, up to which a fit takes part in every round
FITS = 32
STARTS = 256
SCATTER = 0.25
REACHED = 1e-3


def one_start(believed: np.ndarray = BELIEVED) -> Fit:
    """The library's fit from one start alone, to the last digit and without standard errors."""
    problem, moves, theta = posed(log(), rig(believed))
    return least_squares(problem, moves, theta, nodes=measured_nodes(problem, theta))


def against_xla(raced: Raced) -> str:
    """How many times the time with XLA's programs the library takes; and the costs, where they differ."""
    ours, other = (raced.results[name].fit.cost for name in (OURS, XLA))
    return f"{raced.ratio(OURS, XLA):.2f}" + (
        "" if _same(ours, other) == "yes" else f", cost {ours:.6g}, not {other:.6g}"
    )


def effects(counts: Sequence[int] = range(len(EFFECTS) + 1), rounds: int = 7) -> list[tuple[int, float]]:
    """Time of a fit over the number of added effects; returns (free numbers, seconds)."""
    rows, points = [], []
    for count in counts:
        believed, truth = with_effects(*EFFECTS[:count])
        call = partial(fit, believed, [log(truth=truth)])
        first, _ = timed(call)
        raced = race({OURS: call, XLA: by_xla(call)}, rounds)
        found = raced.results[OURS]
        numbers, readings = len(believed.free), found.fit.problem.batch.readings
        points.append((numbers, raced.median(OURS)))
        rows.append(
            [
                f"+ {EFFECTS[count - 1].name}" if count else "none",
                str(numbers),
                seconds(points[-1][1]),
                against_xla(raced),
                seconds(first),
                f"{2.0 * found.fit.cost / readings:.3f}",
            ]
        )
    head = ["effects, one more a row", "free numbers", "`fit`", f"times {XLA}", "first call"]
    show("Over the number of effects", [*head, "mean square in units of noise"], rows)
    return points


def length(lengths: Sequence[float] = LENGTHS, rounds: int = 5) -> list[tuple[float, float, float]]:
    """Time of a fit over the log's length; returns (seconds of log, rwjax, C)."""
    rows, points = [], []
    scipy_numba.fit(arrays(log()))  # compiles
    for duration in lengths:
        call, a = partial(fit, rig(), [log(duration)]), arrays(log(duration))
        contenders = {OURS: call, XLA: by_xla(call), "C": partial(c_limit.Fitter(a).fit, BELIEVED)}
        if duration <= NUMBA_UP_TO:
            contenders[NUMBA] = partial(scipy_numba.fit, a)
        first, _ = timed(call)
        contenders[XLA]()
        raced = race(contenders, rounds, slow=() if duration <= 300.0 else (OURS, XLA, NUMBA))
        ours, limit, other = raced.results[OURS].fit, raced.results["C"], raced.results.get(NUMBA)
        points.append((duration, raced.median(OURS), raced.median("C")))
        batch = ours.problem.batch
        rows.append(
            [
                f"{duration:g} s",
                f"{batch.windows} x {len(batch.step_index)}",
                seconds(raced.median(OURS)),
                against_xla(raced),
                seconds(first),
                _same(ours.cost, limit.cost),
                seconds(raced.median("C")),
                f"{raced.ratio(OURS, 'C'):.3g}",
                seconds(raced.median(NUMBA)) if other else "-",
                f"{raced.ratio(OURS, NUMBA):.3g}" if other else "-",
                _same(other.cost, limit.cost) if other else "-",
            ]
        )
    rows += [_slopes("slope", points), _slopes("slope from 60 s on", [p for p in points if p[0] >= 60.0])]
    head = ["log", "windows x steps", "`fit`", f"times {XLA}", "first call", "C's optimum", "C", "times C"]
    show("Over the log's length", [*head, NUMBA, f"times {NUMBA}", "C's optimum"], rows)
    return points


def logs(counts: Sequence[int] = COUNTS, rounds: int = 5) -> list[tuple[float, float]]:
    """Time of a fit over the number of logs of `EACH` seconds; returns (logs, seconds)."""
    rows, points = [], []
    for count in counts:
        records = [replace(log(EACH, seed), name=f"{seed}.csv") for seed in range(count)]
        call = partial(fit, rig(), records)
        contenders = {OURS: call, XLA: by_xla(call)}
        first, _ = timed(call)
        contenders[XLA]()
        raced = race(contenders, rounds, slow=() if count <= FEW else (OURS, XLA))
        ours = raced.results[OURS].fit
        points.append((float(count), raced.median(OURS)))
        shown = [seconds(points[-1][1]), seconds(points[-1][1] / count), against_xla(raced), seconds(first)]
        rows.append([str(count), *shown, f"{2.0 * ours.cost / ours.problem.batch.readings:.3f}"])
    if len(points) > 1:
        rows.append(["slope", f"{np.polyfit(*np.log(points).T, 1)[0]:.2f}", *[""] * 4])
    head = [f"logs of {EACH:g} s", "`fit`", "per log", f"times {XLA}", "first call", "mean square in units of noise"]
    show("Over the number of logs", head, rows)
    return points


def _same(cost: float, best: float) -> str:
    return "yes" if abs(cost - best) <= REACHED * best else "no"


def _slopes(name: str, points: list[tuple[float, float, float]]) -> list[str]:
    """Row with the exponents of time over length of the library and of C."""
    if len(points) < 2:
        return [name, *[""] * 10]
    ours, limit = np.polyfit(np.log([p[0] for p in points]), np.log([p[1:] for p in points]), 1)[0]
    return [name, "", f"{ours:.2f}", "", "", "", f"{limit:.2f}", *[""] * 4]


def threads(fits: int = FITS, rounds: int = 3) -> None:
    """Many fits one at a time and on two threads over one compiled program."""
    starts = BELIEVED * np.exp(SCATTER * np.random.default_rng(1).normal(size=(fits, 3)))
    record = log()

    def one(believed: np.ndarray) -> None:
        fit(rig(believed), [record])

    one(BELIEVED)
    alone, both = [], []
    for _ in range(rounds):
        alone.append(timed(lambda: [one(s) for s in starts])[0])
        with ThreadPoolExecutor(2) as pool:
            both.append(timed(lambda: list(pool.map(one, starts)))[0])
    gain = float(np.median(np.array(alone) / np.array(both)))
    show(
        f"{fits} fits from different starts",
        ["way", "fits a second"],
        [
            ["one at a time", f"{fits / np.median(alone):.3g}"],
            ["two threads", f"{fits / np.median(both):.3g} ({gain:.2f} times)"],
        ],
    )


def starts(count: int = STARTS) -> None:
    """Share of scattered starts from which the optimum is reached."""
    record, rng = log(), np.random.default_rng(0)
    scattered = BELIEVED * np.exp(SCATTER * rng.normal(size=(count, 3)))
    a = arrays(record)
    fitter = c_limit.Fitter(a)
    limit = np.array([fitter.fit(s).cost for s in scattered])
    numba = np.array([scipy_numba.fit(replace(a, believed=s)).cost for s in scattered])
    ours = np.array([fit(rig(s), [record]).fit.cost for s in scattered])
    single = np.array([one_start(s).cost for s in scattered])
    best = min(limit.min(), ours.min())
    rows = [
        [name, f"{np.sum(cost <= (1.0 + REACHED) * best)} of {count}"]
        for name, cost in (
            ("`fit`", ours),
            ("rwjax from one start", single),
            ("C", limit),
            ("scipy + numba", numba),
        )
    ]
    show(f"Starts scattered by {SCATTER:g} in the logarithm about the common one", ["way", "reach the optimum"], rows)
