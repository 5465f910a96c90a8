"""What the smooth solver costs beside the exact one: on measured and regenerated logs, and on simulated rigs of every kind.

`python -m experiments.smooth.run campaign [-o PATH] [--rigs 25] [--group EMPS …] [--processes 1 | --scheduler ADDRESS]` appends one JSON line for each
rig that the file does not hold yet. `python -m experiments.smooth.run table [-o PATH]` prints the tables.

The widths are multiples of the library's own. With that a body that friction holds creeps by about one count of its encoder in ten
seconds. A tenth of it cannot be seen in a run; ten times it, a count a second, is what a script may begin with.
"""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

import rwjax
from experiments.blind.campaign import run
from experiments.blind.draw import read
from experiments.smooth.creep import LASTS, creep
from experiments.smooth.gradients import gradients
from experiments.smooth.rigs import KINDS, Trial, electro_mechanical, geared_motor, simulated, thesis
from experiments.speed.table import show
from experiments.workers import Workers
from rwjax.fitting.prediction import floor_variance, predict_logs
from rwjax.fitting.problem import pose
from rwjax.kinds import is_angle
from rwjax.logs.noise import pooled_noise
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.smooth import default_width
from rwjax.simulation.solver import Solver

RESULTS = Path(__file__).with_name("results") / "costs.jsonl"
FACTORS = (1.0, 10.0, 0.1)
CHECKED = 2  # rigs of a kind whose derivatives are checked
MEASURED: dict[str, Callable[[Path], Trial]] = {
    "EMPS": electro_mechanical,
    "thesis": lambda _: thesis(),
    "geared motor": geared_motor,
}
SOLVERS = ("exact", *(f"{factor:g}" for factor in sorted(FACTORS)))


def solvers(trial: Trial) -> dict[str, Solver]:
    """The exact solver, and the smooth one with every width."""
    width = default_width(trial.rig, trial.train)
    return {"exact": rwjax.Exact()} | {f"{factor:g}": rwjax.Smooth(width=factor * width) for factor in FACTORS}


def floors(rig: rwjax.Rig, logs: Sequence[rwjax.Log]) -> dict[str, float]:
    """RMS error [SI] that a perfect model would leave of each output."""
    structure = structure_of(rig)
    problem = pose(structure, logs)
    parts = floor_variance(problem, predict_logs(problem, theta_of(rig, structure)))
    return {name: float(np.sqrt(np.nanmean(np.concatenate([p[name] for p in parts])))) for name in parts[0]}


def over_floor(rig: rwjax.Rig, logs: Sequence[rwjax.Log], solver: Solver, floor: dict[str, float]) -> float:
    """RMS error of free runs in units of the floor, of the output where it is largest."""
    runs = [rwjax.predict(rig, log, solver=solver) for log in logs]
    missed = {y: [log.outputs[y] - run[y] for log, run in zip(logs, runs, strict=True)] for y in floor}
    return max(float(np.sqrt(np.nanmean(np.concatenate(e) ** 2))) / floor[y] for y, e in missed.items())


def count(logs: Sequence[rwjax.Log]) -> float | None:
    """Smallest angle [rad] that the readings resolve, None where no angle is read."""
    angles = [sd for name, sd in pooled_noise(tuple(logs)).items() if is_angle(name)]
    return float(np.sqrt(12.0) * min(angles)) if angles else None


def outcome(trial: Trial, solver: Solver, floor: dict[str, float], checked: rwjax.Rig | None) -> dict:
    """What one solver makes of one rig; its derivatives are checked about a rig that is given."""
    begin = perf_counter()
    found = rwjax.fit(trial.rig, trial.train, solver=solver)
    seconds = perf_counter() - begin
    errors = found.rig.standard_error
    refused, off = (None, None) if checked is None else gradients(checked, trial.train, solver)
    return {
        "width": None if isinstance(solver, rwjax.Exact) else solver.width,
        "numbers": {name: [found.rig.values[name], errors.get(name)] for name in trial.rig.free},
        "held_out": over_floor(found.rig, trial.held_out, solver, floor),
        "creep": creep(found.rig, solver),
        "seconds": round(seconds, 3),
        "refused": refused,
        "off": off,
    }


def answer(row: dict) -> dict:
    """One rig's line: what every solver makes of it, or how it failed."""
    group = row["group"]
    if group in MEASURED:
        trial = MEASURED[group](Path("build") / group.replace(" ", "_").lower())
    else:
        trial = simulated(group, row["number"])
    line = row | {"truth": trial.truth, "count": count(trial.train), "solvers": {}}
    best = rwjax.fit(trial.rig, trial.train).rig  # and compiles
    floor = floors(best, trial.held_out)
    checked = best.with_values(trial.truth) if row["number"] < CHECKED else None
    for name, solver in solvers(trial).items():
        try:
            if name == "1":
                rwjax.fit(trial.rig, trial.train, solver=solver)  # compiles; the width is an argument of the program
            line["solvers"][name] = outcome(trial, solver, floor, checked)
        except Exception as error:  # whatever it is, it belongs to this solver and this rig
            line["solvers"][name] = {"error": f"{type(error).__name__}: {error}"}
    return line


def places(rigs: int) -> list[dict]:
    """Everything that is to be tried; the first rigs of every kind come first."""
    rows = [{"group": name, "number": 0} for name in MEASURED]
    rows += [{"group": kind, "number": k} for k in range(rigs) for kind in KINDS]
    return [{"index": k} | row for k, row in enumerate(rows)]


def errors(line: dict, name: str) -> tuple[list[float], list[float]]:
    """Errors of a solver's numbers, relative and in its standard errors; of measured rigs against the exact solver's and in its."""
    of, exact = line["solvers"][name]["numbers"], line["solvers"]["exact"]["numbers"]
    relative, standard = [], []
    for number, (value, sd) in of.items():
        right = line["truth"].get(number, exact[number][0])
        sd = sd if line["truth"] else exact[number][1]
        relative.append(abs(value / right - 1.0))
        if sd:
            standard.append(abs(value - right) / sd)
    return relative, standard


def cells(lines: Sequence[dict], name: str) -> list[str]:
    """One row: medians over rigs and numbers of what a solver makes of a group; held-out errors of measured rigs over the exact
    solver's."""
    done = [line for line in lines if "error" not in line["solvers"].get(name, {"error": ""})]
    if not done:
        return ["-"] * 8
    found = [line["solvers"][name] for line in done]
    both = [errors(line, name) for line in done]
    relative, standard = (np.concatenate([one[k] for one in both]) for k in (0, 1))

    def of(key: str) -> np.ndarray:
        return np.array([one[key] for one in found if one[key] is not None], float)

    seconds, refused, off = (of(key) for key in ("seconds", "refused", "off"))
    measured = not done[0]["truth"]
    gap = of("held_out") / [line["solvers"]["exact"]["held_out"] if measured else 1.0 for line in done]
    away = [f"{100 * np.median(relative):.2g} % ({100 * np.max(relative):.2g})"]
    away += [f"{np.median(standard):.2g} ({100 * np.mean(standard < 1.96):.0f} % in 1.96)"]
    return [
        str(len(found)),
        *(("-", "-") if measured and name == "exact" else away),
        f"{np.median(gap):.3g} ({np.max(gap):.3g})",
        in_counts(done, name),
        f"{np.median(seconds):.3g} ({np.max(seconds):.3g})",
        f"{100 * np.mean(refused):.0f} %",
        f"{100 * np.nanmean(off):.0f} %",
    ]


def in_counts(lines: Sequence[dict], name: str) -> str:
    """Median creep of an axis in counts, of a wheel its rate, and of EMPS, which reads finely, the way."""
    if lines[0]["group"] == "EMPS":
        return f"{1e3 * lines[0]['solvers'][name]['creep']:.2g} mm"
    if lines[0]["group"] in ("wheel", "geared motor"):
        return f"{np.median([line['solvers'][name]['creep'] for line in lines]) / LASTS:.2g} rad/s"
    return f"{np.median([line['solvers'][name]['creep'] / line['count'] for line in lines]):.2g}"


HEAD = [
    "rig", "solver", "rigs", "error of a number (worst)", "in standard errors", "held out / floor (worst)", "creep in 10 s [counts]",
    "fit [s] (longest)", "refused", "gradient off",
]  # fmt: skip


def tables(lines: Sequence[dict]) -> None:
    """Prints what the solvers cost, group by group, and the numbers of measured rigs."""
    groups = dict.fromkeys(line["group"] for line in lines)
    rows = []
    for group in groups:
        members = [line for line in lines if line["group"] == group]
        rows += [[group, name if name == "exact" else f"smooth x {name}", *cells(members, name)] for name in SOLVERS]
    show("The smooth solver beside the exact one", HEAD, rows)
    for line in lines:
        if line["group"] in MEASURED:
            found = {n: line["solvers"][n] for n in SOLVERS if "error" not in line["solvers"][n]}
            widths = [f"width {one['width']:.2g}" if one["width"] else "exact" for one in found.values()]
            rows = [
                [number, *(f"{one['numbers'][number][0]:.5g} ± {one['numbers'][number][1] or np.nan:.2g}" for one in found.values())]
                for number in line["solvers"]["exact"]["numbers"]
            ]  # fmt: skip
            show(f"{line['group']}: numbers", ["", *widths], rows)
    for line in lines:
        for name, one in line["solvers"].items():
            if "error" in one:
                print(f"{line['group']} {line['number']}, {name}: {one['error']}")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("campaign", "table"))
    parser.add_argument("-o", dest="path", type=Path, default=RESULTS)
    parser.add_argument("--rigs", type=int, default=25, help="of every simulated kind")
    parser.add_argument("--group", nargs="+", choices=(*MEASURED, *KINDS), default=(*MEASURED, *KINDS))
    Workers.options(parser, processes=1)
    a = parser.parse_args()
    if a.what == "campaign":
        run([row for row in places(a.rigs) if row["group"] in a.group], a.path, Workers.of(a), answer)
    else:
        tables(sorted(read(a.path), key=lambda line: line["index"]))


if __name__ == "__main__":
    main()
