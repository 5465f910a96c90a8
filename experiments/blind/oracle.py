"""What the best possible diagnosis could know of a case: the simulator itself, refitted to the logs that it made.

The refit begins at the true numbers and the true form of the effect. Where it does not close the gap, or leaves an effect's number
open, the logs do not carry the effect. `judge` answers for a case, `refit` fits any effect to it.
`python -m experiments.blind.oracle --kind platform --effect axis.stribeck --seed 3`
"""

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from experiments.blind.cases import KINDS, Case, Prepared, make_case, prepare, settled, split, strength
from experiments.blind.draws import EFFECTS, Numbers, put
from experiments.blind.outside import OUTSIDE
from experiments.blind.rigs import number, with_number
from experiments.blind.sensors import Recorded, readings
from experiments.blind.simulator import STEP
from experiments.blind.truth import PSI, THETA, Truth

FIRST = 0.5  # s, part of a run that its start is taken from
DISTINCT = 3.5  # standard errors above which a rate is no longer zero
ROUNDING = 1e-9  # rad/s
MOVES = np.array([1e-3, 1e-2, 1e-2, 0.1, 0.01])  # by which initial states are moved: rad, rad/s, rad, rad/s, A
REST = 1e-7  # rad, shift of the start that shows whether a run can be repeated
SIGNED = (
    *("asymmetry", "bias_torque", "bias_command", "gain_asymmetry", "curvature", "scale", "clock", "jump"),
    *("imbalance_2", "spring_zero", "stop_low", "stop_high", "gravity_angle"),
    *("angle_phase", "imbalance_phase", "imbalance_2_phase", "periodic_phase", "cogging_phase"),
    *("eccentricity_phase", "angle_gain_phase"),
)
FORM = ("exponent", "quadratic_power", "coupling", "angle_order", "cogging_order", "curvature_volts")


@dataclass(frozen=True)
class Run:
    """One log: its inputs as written, and what was read, in SI."""

    record: Recorded
    read: dict[str, np.ndarray]
    validate: bool


@dataclass(frozen=True)
class Fit:
    """A refit: numbers of the rig and of the effect, their standard errors, gaps in SI."""

    truth: Truth
    numbers: dict[str, float]
    relative_error: dict[str, float]  # standard error by size (of an angle: in rad)
    misfit: float  # RMS of the weighted residual of the runs that were fitted
    gap: dict[str, float]  # RMS of the free runs held out, by column


def parse(case: Case, prepared: Prepared) -> list[Run]:
    """The logs of a case. Without any mark the last one is held out."""
    found = []
    for name, text in case.logs.items():
        lines = [line for line in text.splitlines() if not line.startswith("#")]
        table = np.array([[float(v) for v in line.split(",")] for line in lines[1:]]).T
        column = dict(zip(lines[0].split(","), table, strict=True))
        time, command = column.pop("time_s"), column.pop("voltage_V")
        step = {c: 2 * np.pi / n for c, n in prepared.rig.sensors.counts.items()}
        read = {c: y * step.get(c, 1.0) for c, y in column.items()}
        salt = prepared.runs[name][0].salt
        record = Recorded(time, command, time, np.zeros(5), salt)
        found.append(Run(record, read, text.startswith("# role: validate")))
    if not any(run.validate for run in found):
        found[-1] = replace(found[-1], validate=True)
    return found


def floor(prepared: Prepared) -> dict[str, float]:
    """What the true rig leaves of each column: noise, quantisation, jitter, and the start of a count that rests."""
    step = {c: 2 * np.pi / n for c, n in prepared.rig.sensors.counts.items()}
    return {c: float(np.hypot(f, step.get(c, 0.0) / np.sqrt(12.0))) for c, f in prepared.scene.floor.items()}


Start = Callable[[Truth, Run, float], np.ndarray]
"""First state of a run."""


def _first(run: Run) -> tuple[np.ndarray, Recorded]:
    """Which samples a start is taken from, and the run as far as these."""
    first = run.record.time < run.record.time[0] + FIRST
    return first, replace(run.record, at=run.record.at[first])


def at_rest(truth: Truth, run: Run, step: float) -> np.ndarray:
    """Rest, where a run's first readings say it stood: every run of the simulator begins so."""
    first, early = _first(run)
    start, wheel = np.zeros(5), truth.kind == 0
    for _ in range(2):
        clean = readings(truth, replace(early, start=start), run.read, step)
        for state, names, own in ((PSI, ("yaw_counts", "yaw_rad"), not wheel), (THETA, ("wheel_counts",), wheel)):
            for name in set(names) & set(run.read):
                gain = np.exp(truth.scale) if own else 1.0  # of the encoder that may be off
                start[state] += float(np.mean(run.read[name][first] - clean[name])) / gain
        if truth.cogging != 0.0 and "wheel_counts" not in run.read:
            start[THETA] = settled(truth, start)[THETA]
    return start


def rests(run: Run) -> bool:
    """Whether command and rates are indistinguishable from zero over the first 0.5 s."""
    first, _ = _first(run)
    t = run.record.time[first] - np.mean(run.record.time[first])
    for name in set(run.read) - {"current_A"}:
        y = run.read[name][first]
        rate = name.endswith("rad_s")
        value = np.mean(y) if rate else t @ y / (t @ t)
        error = np.std(y - np.mean(y) - (0.0 if rate else value * t)) / np.sqrt(len(t) if rate else t @ t)
        if abs(value) > max(DISTINCT * error, ROUNDING):
            return False
    return not np.any(run.record.command[first])


def by_rule(truth: Truth, run: Run, step: float) -> np.ndarray:
    """The interface's start: least squares of all initial states over the first 0.5 s, unless the run rests there."""
    start = at_rest(truth, run, step)
    if rests(run):
        return start
    first, early = _first(run)

    def clean(at: np.ndarray) -> np.ndarray:
        found = readings(truth, replace(early, start=at), run.read, step)
        return np.concatenate([found[name] / spread[name] for name in run.read])

    spread = {name: max(float(np.std(np.diff(y[first]))), 1e-6) for name, y in run.read.items()}
    read = np.concatenate([y[first] / spread[name] for name, y in run.read.items()])
    for _ in range(3):
        now = clean(start)
        J = np.stack([clean(start + move) - now for move in np.diag(MOVES)], axis=1)
        change = np.linalg.lstsq(J, read - now, rcond=1e-6)[0] * MOVES
        if not np.all(np.isfinite(change)):
            break
        start = start + change
    return start


def free_run(truth: Truth, run: Run, step: float = STEP, begin: Start = at_rest) -> dict[str, np.ndarray]:
    """What the logged columns would hold under a run's command."""
    return readings(truth, replace(run.record, start=begin(truth, run, step)), run.read, step)


def perfect(case: Case, step: float = STEP, begin: Start = at_rest) -> dict[str, float]:
    """What the true rig leaves of each column of the runs held out: the floor, or more where the start's error grows."""
    label = case.truth
    prepared = prepare(label["kind"], label["effect"], label["seed"])
    held_out = [run for run in parse(case, prepared) if run.validate]
    gap = _gap(Truth(**label["parameters"]), held_out, step, begin)
    return {name: max(noise, gap[name]) for name, noise in floor(prepared).items()}


def _weighted(
    truth: Truth, runs: list[Run], noise: dict[str, float], prepared: Prepared, step: float, begin: Start
) -> np.ndarray:
    """Residuals in units of the floor; a constant that half a count explains is taken off."""
    parts = []
    for run in runs:
        clean = free_run(truth, run, step, begin)
        for name, y in run.read.items():
            residual = y - clean[name]
            if name in prepared.rig.sensors.counts:
                half = np.pi / prepared.rig.sensors.counts[name]
                residual = residual - np.clip(np.mean(residual), -half, half)
            parts.append(residual / noise[name])
    return np.clip(np.nan_to_num(np.concatenate(parts), nan=1e6), -1e6, 1e6)


def _continuous(numbers: Numbers, truth: Truth) -> list[str]:
    """Numbers of an effect that a fit can move."""
    return [k for k in numbers if k not in FORM and not k.endswith("_form") and k != "form" and getattr(truth, k) != 0]


def _with(truth: Truth, name: str, value: float) -> Truth:
    return with_number(truth, name, value) if "." in name else replace(truth, **{name: float(value)})


def _value(truth: Truth, name: str) -> float:
    return number(truth, name) if "." in name else getattr(truth, name)


def fit(
    start: Truth,
    names: list[str],
    runs: list[Run],
    prepared: Prepared,
    evaluations: int = 30,
    step: float = STEP,
    begin: Start = at_rest,
) -> Fit:
    """Least squares over `names` (dotted: of the rig file; others: fields of `Truth`) on the runs not held out."""
    noise = prepared.scene.floor
    train, held_out = ([r for r in runs if r.validate == which] for which in (False, True))
    first = {name: _value(start, name) for name in names}

    def at(x: np.ndarray) -> Truth:
        truth = start
        for name, move in zip(names, x - 1.0, strict=True):
            signed = name.rsplit(".", 1)[-1] in SIGNED or name == "axis.gravity.angle"
            value = (
                first[name] + move * (abs(first[name]) or 1.0) if signed else first[name] * np.exp(np.clip(move, -5, 5))
            )
            truth = _with(truth, name, value)
        return truth

    def residual(x: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore", invalid="ignore"):  # a trial may run away
            return _weighted(at(x), train, noise, prepared, step, begin)

    x, error = np.ones(len(names)), np.zeros(len(names))
    if names:
        found = least_squares(residual, x, diff_step=1e-4, max_nfev=evaluations, x_scale="jac", xtol=1e-6, ftol=1e-5)
        x = found.x
        _, s, v = np.linalg.svd(found.jac, full_matrices=False)
        error = np.sqrt(np.sum((v.T / np.maximum(s, 1e-9)) ** 2, axis=1))
    truth = at(x)
    last = residual(x)
    return Fit(
        truth,
        {name: float(_value(truth, name)) for name in names},
        dict(zip(names, error.tolist(), strict=True)),
        float(np.sqrt(np.mean(last**2))),
        _gap(truth, held_out, step, begin),
    )


def _gap(truth: Truth, runs: list[Run], step: float, begin: Start) -> dict[str, float]:
    """RMS of free runs by column, in SI."""
    found: dict[str, list[np.ndarray]] = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for run in runs:
            clean = free_run(truth, run, step, begin)
            for name, y in run.read.items():
                found.setdefault(name, []).append(np.nan_to_num(y - clean[name], nan=1e6))
        return {name: float(np.sqrt(np.mean(np.concatenate(off) ** 2))) for name, off in found.items()}


def refit(
    case: Case,
    effect: str | None,
    tries: int = 1,
    evaluations: int = 30,
    step: float = STEP,
    first: dict[str, float] | None = None,
    begin: Start = at_rest,
    prepared: Prepared | None = None,
) -> Fit:
    """The rig with `effect` fitted to a case: its own effects from the truth, any other from `tries` random draws.

    `first`: numbers to begin from instead, as another fit of the case found them. `prepared`: the case's rig with its small causes, where
    `effect` holds any of these.
    """
    label = case.truth
    prepared = prepared or prepare(label["kind"], label["effect"], label["seed"])
    runs, free = parse(case, prepared), list(prepared.rig.free)
    base = prepared.rig.truth
    own = {*split(effect)} & {*split(label["effect"]), *label.get("small", ())}
    for name, value in label["wrong_numbers"].items():
        base = base if f"parameter.{name}" in own else with_number(base, name, value)
    fits = []
    for trial in range(1 if own == {*split(effect)} else tries):
        truth, names = base, list(free)
        rng = np.random.default_rng([label["seed"], trial])
        for name in split(effect):
            if name.startswith("parameter."):
                names.append(name.removeprefix("parameter."))
                continue
            numbers = prepared.numbers[name] if name in own else (EFFECTS | OUTSIDE)[name].draw(prepared.scene, rng)
            truth = put(truth, numbers, strength(label["amplitude"], name) if name in own else (1.0, 0.2)[trial % 2])
            names += [k for k in _continuous(numbers, truth) if k not in names]
        names = [n for n in names if n != "coulomb" or "axis.friction.coulomb" not in names]
        for name, value in (first or {}).items():
            truth = _with(truth, name, value) if name in names else truth
        fits.append(fit(truth, names, runs, prepared, evaluations, step, begin))
    return min(fits, key=lambda one: one.misfit)


def size(gap: dict[str, float], noise: dict[str, float]) -> float:
    """Size of what a fit leaves out, as the interface defines it, of the signal where it is largest."""
    return max(float(np.sqrt(max(gap[c] ** 2 - noise[c] ** 2, 0.0)) / noise[c]) for c in noise)


def repeatable(case: Case) -> float:
    """How far runs spread, in floors, whose starts differ by nothing that could be measured; above 1: chaotic."""
    label = case.truth
    prepared = prepare(label["kind"], label["effect"], label["seed"])
    truth, worst = Truth(**label["parameters"]), 0.0
    for record, _ in prepared.runs.values():
        start = settled(truth, record.start)
        one, other = (
            readings(truth, replace(record, start=start + shift), prepared.rig.sensors.noise)
            for shift in (np.zeros(5), np.array([REST, 0.0, REST, 0.0, 0.0]))
        )
        for name, noise in prepared.scene.floor.items():
            worst = max(worst, float(np.sqrt(np.mean((one[name] - other[name]) ** 2))) / noise)
    return worst


def judge(case: Case, without: Fit | None = None, step: float = STEP) -> dict:
    """What the logs of a case carry: size of the gap, what the true effect leaves, how well its numbers are known.

    `without`: the refit without the effect, where it is known already.
    """
    label = case.truth
    prepared = prepare(label["kind"], label["effect"], label["seed"])
    noise = perfect(case, step)
    without = without or refit(case, None, step=step)
    with_it = refit(case, label["effect"], step=step) if split(label["effect"]) else without
    own = [name for name in with_it.numbers if name not in prepared.rig.free]
    return {
        "size": size(without.gap, noise),
        "left": size(with_it.gap, noise),
        "misfit_without": without.misfit,
        "misfit_with": with_it.misfit,
        "relative_error": {name: with_it.relative_error[name] for name in own},
        "repeatable": repeatable(case),
    }


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--effect", default="none")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--amplitude", type=float, default=1.0)
    a = parser.parse_args()
    print(json.dumps(judge(make_case(a.kind, a.effect, a.seed, a.amplitude)), indent=1))


if __name__ == "__main__":
    main()
