"""All ways to fit the 60 s log from one start, in interleaved rounds."""

import json
import statistics
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import IO

import numpy as np

from experiments.speed import c_limit, scipy_ivp, scipy_numba
from experiments.speed.curves import one_start
from experiments.speed.lowering import XLA, by_xla
from experiments.speed.problem import BELIEVED, FREE, arrays, log, rig
from experiments.speed.table import ratio, seconds, show, timed
from rwjax.fitting.fit import fit

ROUNDS = 11
CASADI_ROUNDS = 5
LIMIT = 120.0  # s, for a contender that may not end
REACHED = 1e-3  # relative, of the cost


@dataclass
class Entry:
    """What a contender did. `evaluations` in its own words; `first`: compile or build time in words."""

    name: str
    times: list[float] = field(default_factory=list)
    numbers: Sequence[float] = (np.nan, np.nan, np.nan)
    cost: float = np.nan
    evaluations: str = "-"
    first: str = "-"
    note: str = ""

    def reached(self, best: "Entry") -> bool:
        """Whether the cost is the best one's."""
        return abs(self.cost - best.cost) <= REACHED * best.cost

    def off(self, best: "Entry") -> float:
        """Largest relative distance of a number from the best fit's."""
        return float(np.max(np.abs(np.asarray(self.numbers) / np.asarray(best.numbers) - 1.0)))


class Casadi:
    """The CasADi program in a process of its own, one fit for each line that it is sent."""

    def __init__(self, rounds: int) -> None:
        command = [sys.executable, "-m", "experiments.speed.casadi_shooting", "60", str(rounds + 1)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.build = self._read()["build"]
        self.fit()  # once to warm up

    def _read(self) -> dict:
        stream: IO[str] = self.process.stdout  # type: ignore[assignment]
        return json.loads(stream.readline())

    def fit(self) -> dict:
        """One fit: its time, numbers, cost, iterations and status."""
        stream: IO[str] = self.process.stdin  # type: ignore[assignment]
        stream.write("\n")
        stream.flush()
        return self._read()


def newcomer(adjoint: str) -> Entry:
    """One attempt with diffrax and optimistix under the time limit."""
    entry = Entry(f"diffrax + optimistix, {adjoint} adjoint")
    command = [sys.executable, "-m", "experiments.speed.newcomer", adjoint]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        entry.note = f"not done after {LIMIT:.0f} s"
        return entry
    if done.returncode:
        raised = [
            line for line in done.stderr.splitlines() if line.startswith(("TypeError", "ValueError", "RuntimeError"))
        ]
        entry.note = "raises " + (raised[-1] if raised else done.stderr.strip().splitlines()[-1])[:90]
        return entry
    answer = json.loads(done.stdout.splitlines()[-1])
    entry.times, entry.numbers, entry.cost = [answer["time"]], answer["numbers"], answer["cost"]
    entry.evaluations, entry.first = f"{answer['steps']} steps", "in the time"
    return entry


def measure(quick: bool = False) -> list[Entry]:
    """Runs all contenders, or the fast ones once; the first entry is the C program, the second the library."""
    rounds = 1 if quick else ROUNDS
    a, believed, record = arrays(log()), rig(), log()
    limit, ours, plain = (
        Entry("C, SIMD windows"),
        Entry("rwjax, `fit`"),
        Entry("rwjax, one start without standard errors"),
    )
    xla = Entry(f"rwjax, `fit`, {XLA}")
    numba, smooth, casadi = (
        Entry("scipy least_squares + numba, same step"),
        Entry("scipy least_squares + numba RK4"),
        Entry("CasADi multiple shooting, Gauss-Newton, IPOPT"),
    )
    ivp = Entry("scipy least_squares + solve_ivp")
    fitter = c_limit.Fitter(a)
    spent, _ = timed(fit, believed, [record])
    ours.first = f"first call {seconds(spent)}, programs from disk"
    numba.first = f"first call {seconds(timed(scipy_numba.fit, a)[0])}, from disk"
    smooth.first = f"first call {seconds(timed(scipy_numba.fit, a, scipy_numba.smooth_residual)[0])}, from disk"
    xla.first = f"first call {seconds(timed(by_xla(fit), believed, [record])[0])}, programs from disk"
    one_start(), fitter.fit(BELIEVED)
    shooting = Casadi(CASADI_ROUNDS) if find_spec("casadi") else None
    casadi.first = f"build {seconds(shooting.build)}" if shooting else "not installed"
    for k in range(rounds):
        spent, found = timed(fit, believed, [record])
        ours.times.append(spent)
        ours.numbers, ours.cost = [found.rig.values[name] for name in FREE], found.fit.cost
        spent, found = timed(by_xla(fit), believed, [record])
        xla.times.append(spent)
        xla.numbers, xla.cost = [found.rig.values[name] for name in FREE], found.fit.cost
        spent, single = timed(one_start)
        plain.times.append(spent)
        plain.numbers, plain.cost = [single.numbers()[name] for name in FREE], single.cost
        plain.evaluations = f"{single.steps} steps after the windows'"
        for entry, call in (
            (limit, lambda: fitter.fit(BELIEVED)),
            (numba, lambda: scipy_numba.fit(a)),
            (smooth, lambda: scipy_numba.fit(a, scipy_numba.smooth_residual)),
        ):
            spent, best = timed(call)
            entry.times.append(spent)
            entry.numbers, entry.cost, entry.evaluations = best.numbers, best.cost, str(best.evaluations)
        if shooting and k < CASADI_ROUNDS:
            r = shooting.fit()
            casadi.times.append(r["time"])
            casadi.numbers, casadi.cost, casadi.evaluations = r["numbers"], r["cost"], f"{r['iterations']} iterations"
    numba.evaluations += " simulations"
    smooth.evaluations += " simulations"
    smooth.note = f"sign smoothed over {scipy_numba.WIDTH:g} rad/s"
    limit.evaluations += " with sensitivities"
    casadi.note = "RK4, sign smoothed over 0.003 rad/s"
    if quick:
        return [limit, ours, xla, plain, numba, smooth, casadi]
    spent, best = timed(scipy_ivp.fit, a)
    ivp.times, ivp.numbers, ivp.cost, ivp.evaluations = (
        [spent],
        best.numbers,
        best.cost,
        f"{best.evaluations} simulations",
    )
    ivp.note = "sign smoothed over 0.03 rad/s"
    return [limit, ours, xla, plain, numba, smooth, casadi, ivp, newcomer("default"), newcomer("forward")]


def report(entries: list[Entry]) -> None:
    """Prints the table."""
    limit, ours = entries[:2]
    rows = []
    for e in entries:
        fast = len(e.times) > 1
        reached = not np.isnan(e.cost) and e.reached(limit)
        rows.append(
            [
                e.name,
                seconds(statistics.median(e.times)) if e.times else "-",
                f"{ratio(e.times, limit.times):.3g}" if fast and reached else "-",
                f"{ratio(e.times, ours.times):.3g}" if fast and reached else "-",
                e.evaluations,
                "yes"
                if reached
                else "no"
                if np.isnan(e.cost)
                else f"no: cost {e.cost:.4g}, {100 * e.off(limit):.2g} % off",
                e.first,
                e.note,
            ]
        )
    head = ["contender", "median", "x C", "x rwjax", "evaluations", "same optimum", "compile or build", "remarks"]
    show(f"60 s at 100 Hz, three numbers and two first states; best cost {limit.cost:.4f}", head, rows)
