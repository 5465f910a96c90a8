"""Every identification method on the same logs, judged by the free run on the same held-out data."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import NamedTuple

import numpy as np

from rwjax.errors import InputError
from rwjax.fitting.fit import to_fit
from rwjax.fitting.prediction import errors, floor_variance, predict_logs
from rwjax.fitting.problem import pose
from rwjax.logs.held_out import folds
from rwjax.logs.log import Log
from rwjax.methods.identified import Identified
from rwjax.methods.kalman import prediction_error
from rwjax.methods.output_error import end_to_end, finite_differences
from rwjax.methods.regression import equation_error, weak_form
from rwjax.methods.two_stage import two_stage
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig


class Method(NamedTuple):
    """`needs`: what the logs must offer, in words."""

    name: str
    identify: Callable[[Rig, Sequence[Log]], Identified]
    needs: str


METHODS = (
    Method("end-to-end", end_to_end, "any logs"),
    Method("finite differences", finite_differences, "a start near the optimum"),
    Method("prediction error", prediction_error, "a noise model; regular sampling"),
    Method("weak form", weak_form, "angles or rates of every body, well above their noise"),
    Method("equation error", equation_error, "the same, and accelerations worth the name"),
    Method("two-stage", two_stage, "a coast-down at 0 V; the inertia; friction of the axis only"),
)


@dataclass(frozen=True)
class Row:
    """One method. `rig`: with estimates from all logs that may be fitted, None where the method could not be used;
    `rms`: of the free run on held-out data by output [SI]; `seconds`: of the first fit, compiling included."""

    method: Method
    rig: Rig | None
    rms: dict[str, float]
    seconds: float
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Comparison:
    """`floor`: RMS by output that a perfect model would leave on the held-out data [SI]."""

    rig: Rig
    rows: tuple[Row, ...]
    floor: dict[str, float]
    held_out: str

    def json(self) -> dict:
        """`comparison.json` as plain objects."""
        return {
            "schema": "rwjax.comparison/1",
            "held_out": self.held_out,
            "floor": self.floor,
            "methods": [
                {
                    "method": row.method.name,
                    "needs": row.method.needs,
                    "rms": {name: value if np.isfinite(value) else None for name, value in row.rms.items()},
                    "seconds": row.seconds,
                    "numbers": None
                    if row.rig is None
                    else {
                        name: {"value": row.rig.values[name], "standard_error": row.rig.standard_error.get(name)}
                        for name in self.rig.free
                    },
                    "notes": list(row.notes),
                }
                for row in self.rows
            ],
        }


def _judged(rig: Rig, logs: Sequence[Log]) -> list[tuple[dict[str, np.ndarray], dict[str, np.ndarray]]]:
    """Squared free-run errors and squared floors of each log by output."""
    structure = structure_of(rig)
    problem = pose(structure, logs)
    predictions = predict_logs(problem, theta_of(rig, structure))
    floor = floor_variance(problem, predictions)
    with np.errstate(over="ignore"):
        square = [{name: e**2 for name, e in one.items()} for one in errors(problem, predictions)]
    return list(zip(square, floor, strict=True))


def _rms(parts: list[dict[str, np.ndarray]]) -> dict[str, float]:
    names = dict.fromkeys(name for part in parts for name in part)
    return {
        name: float(np.sqrt(np.nanmean(np.concatenate([part[name] for part in parts if name in part]))))
        for name in names
    }


def compare(rig: Rig, logs: Sequence[Log], progress: Callable[[str], None] = lambda text: None) -> Comparison:
    """Fits `rig` by every method and judges each by the held-out rule; a fold's fit begins at the fit to all logs.

    A method that cannot be used on these logs has a row that says why. Raises `RigError` where nothing is free and
    `LogError` where no log may be fitted.
    """
    train = to_fit(rig, logs)
    rule, splits = folds(logs)
    rows, floor = [], {}
    for method in METHODS:
        progress(method.name)
        begin = perf_counter()
        try:
            found = method.identify(rig, train)
            seconds = perf_counter() - begin
            judged = []
            for split in splits:
                whole = len(split.train) == len(train) and all(a is b for a, b in zip(split.train, train, strict=True))
                fitted = found.rig if whole else method.identify(found.rig, split.train).rig
                judged += _judged(fitted, split.test)
        except InputError as error:
            rows.append(Row(method, None, {}, perf_counter() - begin, (str(error),)))
            continue
        rows.append(Row(method, found.rig, _rms([square for square, _ in judged]), seconds, found.notes))
        floor = floor or _rms([f for _, f in judged])
    return Comparison(rig, tuple(rows), floor, rule)
