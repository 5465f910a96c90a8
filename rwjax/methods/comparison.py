"""Every identification method on the same logs, judged by the free run on the same held-out data."""

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import NamedTuple

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from rwjax.errors import InputError, refuses_other_types
from rwjax.fitting.fit import to_fit
from rwjax.fitting.prediction import errors, floor_variance, predict_logs
from rwjax.fitting.problem import pose
from rwjax.fitting.segments import said, segment_s, with_segments
from rwjax.logs.coverage import WITHIN, Split, split_of
from rwjax.logs.driven import driven
from rwjax.logs.held_out import folds
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.logs.segments import cut_up
from rwjax.methods.identified import Identified
from rwjax.methods.kalman import prediction_error
from rwjax.methods.output_error import SMOOTH, end_to_end, finite_differences, smooth_end_to_end
from rwjax.methods.regression import equation_error, weak_form
from rwjax.methods.two_stage import two_stage
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Rig
from rwjax.simulation.exact import EXACT
from rwjax.simulation.solver import Solver


class Method(NamedTuple):
    """An identification method.

    Attributes:
        name: Its name in tables.
        identify: From a rig and logs to estimates.
        needs: What the logs must offer, in words.
    """

    name: str
    identify: Callable[[Rig, Sequence[Log]], Identified]
    needs: str


METHODS = (
    Method("end-to-end", end_to_end, "any logs"),
    Method("smooth", smooth_end_to_end, "friction whose sign may be smooth; time"),
    Method("finite differences", finite_differences, "a start near the optimum"),
    Method("prediction error", prediction_error, "a noise model; regular sampling"),
    Method("weak form", weak_form, "angles or rates of every body, well above their noise"),
    Method("equation error", equation_error, "the same, and accelerations worth the name"),
    Method("two-stage", two_stage, "a coast-down at 0 V; the inertia; friction of the axis only"),
)
"""All methods, in the order of the table."""


@dataclass(frozen=True)
class Row:
    """What one method found.

    Attributes:
        method: The method.
        rig: The rig with estimates from all logs that may be fitted; None where the method could not be used.
        rms: RMS error of the free run on held-out data [SI] by output.
        seconds: Time of the first fit, compiling included [s].
        notes: What a user should know, one sentence each.
    """

    method: Method
    rig: Rig | None
    rms: dict[str, float]
    seconds: float
    notes: tuple[str, ...]

    def cells(self, signals: Sequence[str], free: Sequence[str]) -> list[str]:
        """Errors and estimates as text.

        Args:
            signals: Outputs of the table.
            free: Estimated numbers of the table.

        Returns:
            One entry for each, dashes where the method could not be used or its model is not stable.
        """
        if self.rig is None:
            return ["–"] * (len(signals) + len(free))
        values, error = self.rig.values, self.rig.standard_error
        estimates = [f"{values[name]:.5g}" + (f" ± {error[name]:.2g}" if name in error else "") for name in free]
        errors = [self.rms[name] for name in signals]
        return [*(f"{error:.4g}" if np.isfinite(error) else "–" for error in errors), *estimates]


@dataclass(frozen=True)
class Comparison:
    """Methods on the same logs. Prints as a table.

    Attributes:
        rig: The rig as it was given.
        rows: One for each method.
        floor: RMS error by output that a perfect model would leave on the held-out data [SI].
        held_out: How the held-out data were chosen.
        split: Whether held-out runs leave what the fitted ones cover.
        segment_s: Length of the segments in which free runs follow the logs [s]; None for whole runs.
        remarks: What a user should know of the logs, one sentence each.
    """

    rig: Rig
    rows: tuple[Row, ...]
    floor: dict[str, float]
    held_out: str
    split: Split = WITHIN
    segment_s: float | None = None
    remarks: tuple[str, ...] = ()

    def __str__(self) -> str:
        signals, free = list(self.floor), self.rig.free
        sheet = Table(box=box.SIMPLE, pad_edge=False)
        for head in ("method", *(f"{name} [{unit_of(name)}]" for name in signals), *free, "time [s]", "needs"):
            sheet.add_column(
                Text(head), no_wrap=head != "needs", justify="left" if head in ("method", "needs") else "right"
            )
        for row in self.rows:
            sheet.add_row(row.method.name, *row.cells(signals, free), f"{row.seconds:.1f}", row.method.needs)
        sheet.add_row("(floor)", *(f"{self.floor[name]:.4g}" for name in signals), *[""] * (len(free) + 2))
        out = io.StringIO()
        Console(file=out, width=60 + 24 * (len(signals) + len(free))).print(sheet)
        head = f"free-run RMS on held-out data ({self.held_out}); numbers from all logs that may be fitted, ± one standard error as each method has it"
        notes = [f"{row.method.name}: {note}" for row in self.rows for note in row.notes if note not in self.remarks]
        notes = [*self.remarks, *notes]
        return "\n".join([head, *(line.rstrip() for line in [*out.getvalue().rstrip("\n").split("\n"), *notes])])

    def json(self) -> dict:
        """`comparison.json` as plain objects.

        Returns:
            Errors, times and estimates [SI] method by method.
        """
        return {
            "schema": "rwjax.comparison/1",
            "held_out": self.held_out,
            "split": self.split.json(),
            "segment_s": self.segment_s,
            "remarks": list(self.remarks),
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


def _judged(rig: Rig, logs: Sequence[Log], solver: Solver) -> list[tuple[dict[str, np.ndarray], dict[str, np.ndarray]]]:
    """Squared free-run errors and squared floors of each log or segment by output."""
    rig, logs = driven(rig, logs)
    structure = structure_of(rig)
    problem = pose(structure, cut_up(logs), pooled_noise(tuple(logs)), solver=solver)
    predictions = predict_logs(problem, theta_of(rig, structure))
    floor = floor_variance(problem, predictions)
    with np.errstate(over="ignore"):
        square = [{name: e**2 for name, e in one.items()} for one in errors(problem, predictions)]
    return list(zip(square, floor, strict=True))


def _rms(parts: list[dict[str, np.ndarray]]) -> dict[str, float]:
    """Root of the mean over all logs of what is squared already, by output."""
    names = dict.fromkeys(name for part in parts for name in part)
    return {
        name: float(np.sqrt(np.nanmean(np.concatenate([part[name] for part in parts if name in part]))))
        for name in names
    }


@refuses_other_types
def compare(
    rig: Rig,
    logs: Sequence[Log],
    progress: Callable[[str], None] = lambda text: None,
    *,
    solver: Solver = EXACT,
    segments: float | None = None,
) -> Comparison:
    """Fits a rig by every method and judges each on held-out data; a fold's fit begins at the fit to all logs.

    The method `smooth` is judged by the free run of its own solver, the others by that of one solver.

    Args:
        rig: The rig with its free numbers.
        logs: The logs.
        progress: Is told the method that is fitted or judged and, of several, the held-out part.
        solver: Solver whose free runs judge; if it is smooth, the method `smooth` fits through it.
        segments: Length of the segments [s] in which free runs follow the logs, infinite for whole runs; chosen by the
            rig and the logs without it. Methods without a free run take whole runs.

    Returns:
        The comparison; a method that cannot be used on these logs has a row that says why.

    Raises:
        RigError: Nothing is free.
        LogError: No log may be fitted.
        InputError: An argument is of another type.
    """
    rig, logs = driven(rig, logs)
    logs = with_segments(rig, logs, segments)
    train = to_fit(rig, logs)
    rule, splits = folds(logs)
    by = solver.suited(rig, train)  # one width for all
    rows, floor = [], {}
    for turn, method in enumerate(METHODS, start=1):
        identify, told = method.identify, f"method {turn} of {len(METHODS)}, {method.name}"
        progress(told)
        begin = perf_counter()
        try:
            if identify is smooth_end_to_end:
                identify = partial(smooth_end_to_end, solver=by if by.smooth else SMOOTH.suited(rig, train))
            found = identify(rig, train)
            seconds = perf_counter() - begin
            judged = []
            for fold, split in enumerate(splits, start=1):
                if len(splits) > 1:
                    progress(f"{told}: held-out part {fold} of {len(splits)}")
                whole = len(split.train) == len(train) and all(a is b for a, b in zip(split.train, train, strict=True))
                fitted = found.rig if whole else identify(found.rig, split.train).rig
                judged += _judged(fitted, split.test, found.solver or by)
        except InputError as error:
            rows.append(Row(method, None, {}, perf_counter() - begin, (str(error),)))
            continue
        rows.append(Row(method, found.rig, _rms([square for square, _ in judged]), seconds, found.notes))
        floor = floor or _rms([f for _, f in judged])
    parted = split_of(rig, logs)
    return Comparison(rig, tuple(rows), floor, rule, parted, segment_s(logs), (*said(logs), *parted.said()))
