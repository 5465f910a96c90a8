"""Whether free runs can follow whole runs, or segments of them alone: unstable, over the top, or hours long.

A free run is followed as long as a small change of its state stays small. How far one grows is told by the state
sensitivities along the measured motion, window by window.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from rwjax.effects.library import BY_NAME
from rwjax.errors import in_two_digits
from rwjax.fitting.initial_guess import START_S
from rwjax.fitting.problem import pose
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.kinds import half_column, of_half
from rwjax.logs.driven import driven
from rwjax.logs.log import Log, Segments
from rwjax.logs.segments import cut_up
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import transitions

FOLLOWED = 1000.0
"""Growth of a change of an axis's angle [rad] and rate [rad/s] over a run from which no free run follows it [1]."""
WITHIN, MOST_OF = 100.0, 0.9
"""Growth of such a change within a segment [1], and the share of the segments that keep to it [1]."""
SWINGS = 2.0
"""Small swings that a segment of a run over the top holds at most [1]."""
LONGEST_RUN_S = 1800.0
"""Length of a run from which it is cut in any case [s]: what no model holds adds up."""
PIECE_S = 60.0
"""Length of the pieces in which the growth is worked out [s]."""
PLACES = 500
"""Places of a run, spread evenly, where a stretch is let begin to see how far it can be followed [1]."""
LONGEST_S, SHORTEST_S = 300.0, 2.0 * START_S
"""Length of a segment at most and at least [s]; the start takes `START_S` of it."""


def with_segments(rig: Rig, logs: Sequence[Log], seconds: float | None = None) -> tuple[Log, ...]:
    """Logs with the decision how free runs follow them, the same for all.

    Args:
        rig: The rig.
        logs: Whole runs.
        seconds: Length of a segment [s], infinite for whole runs; chosen by the rig and the logs without it. Logs for
            which it was decided before are left as they are then.

    Returns:
        The same runs, not cut yet; `cut_up` does that.
    """
    if seconds is None and all(log.segments is not None for log in logs):
        return tuple(logs)
    decided = _chosen(rig, logs) if seconds is None else Segments(seconds, "as asked for")
    return tuple(replace(log, segments=decided) for log in logs)


def said(logs: Sequence[Log]) -> list[str]:
    """How free runs follow the logs, where that is not run by run.

    Args:
        logs: The logs, for which it is decided.

    Returns:
        One sentence, none for whole runs.
    """
    how = logs[0].segments if logs else None
    if how is None or not math.isfinite(how.seconds):
        return []
    return [
        f"runs are followed in segments of at most {how.seconds:.3g} s, each started from its first {START_S} s ({how.why}); "
        "`--segments SECONDS` takes another length, `--segments inf` whole runs"
    ]


def segment_s(logs: Sequence[Log]) -> float | None:
    """Length of the segments in which logs are followed.

    Args:
        logs: The logs, for which it is decided.

    Returns:
        The length [s], None for whole runs.
    """
    how = logs[0].segments if logs else None
    return None if how is None or not math.isfinite(how.seconds) else how.seconds


def _chosen(rig: Rig, logs: Sequence[Log]) -> Segments:
    """Whole runs where free runs can follow them, else segments as long as they can."""
    rig, logs = driven(rig, logs)
    structure = structure_of(rig)
    read = [log for log in logs if log.outputs]
    longest = max((float(np.ptp(log.time)) for log in read), default=0.0)
    if longest < SHORTEST_S or not (_pushed(rig, structure, read) or longest > FOLLOWED):
        return Segments()  # a change of the rate grows to as many radians as there are seconds, and no further
    moved = [_moved(rig, structure, log) for log in read] if structure.has_axis else []
    growth = max(map(_growth, moved), default=1.0)
    swings = SWINGS * _swing_s(rig, read)
    if growth <= FOLLOWED and longest <= LONGEST_RUN_S and not math.isfinite(swings):
        return Segments()
    seconds = max(min([swings, *map(_followed_s, moved)], default=LONGEST_S), SHORTEST_S)
    why = "the runs are long"
    if math.isfinite(swings):
        why = "the axis goes over the top, and how often depends on every number"
    if growth > FOLLOWED:
        why = f"a change of the state grows {in_two_digits(growth)} times over a run"
    return Segments(float(f"{min(seconds, LONGEST_S):.2g}"), why)


def _swing_s(rig: Rig, logs: Sequence[Log]) -> float:
    """Longest time of a small swing of an axis that goes over the top of its gravity in some log [s]; infinite where none does."""
    found = []
    for name, torque in rig.numbers.items():
        if not name.endswith("gravity.torque") or not torque:
            continue
        half = of_half(name)
        output = "yaw_rad" if half is None else half_column("yaw_rad", half[0])
        angle = rig.numbers.get(name.replace("torque", "angle"), 0.0) + (math.pi if torque < 0.0 else 0.0)
        runs = [log.outputs[output] for log in logs if output in log.outputs]
        turns = [np.floor((y[np.isfinite(y)] + angle + math.pi) / (2.0 * math.pi)) for y in runs]
        if any(np.ptp(turn) > 0.0 for turn in turns if len(turn)):
            inertia = rig.numbers[name.replace("gravity.torque", "inertia")]
            inertia += rig.numbers.get("gear.ratio", 1.0) ** 2 * rig.numbers.get("motor.inertia", 0.0)
            found.append(2.0 * math.pi * math.sqrt(inertia / abs(torque)))
    return max(found, default=math.inf)


def _pushed(rig: Rig, structure: Structure, logs: Sequence[Log]) -> bool:
    """Whether anything in the rig may push an axis away from where it stands: gravity above half height, or an effect of the angle."""
    for name, torque in rig.numbers.items():
        if name.endswith("gravity.torque") and torque:
            half = of_half(name)
            output = "yaw_rad" if half is None else half_column("yaw_rad", half[0])
            angle = rig.numbers.get(name.replace("torque", "angle"), 0.0)
            if not all(output in log.outputs for log in logs):
                return True
            if any(np.any(torque * np.cos(log.outputs[output] + angle) < 0.0) for log in logs):
                return True
    return structure.has_axis and any(BY_NAME[effect].at_angle for effect in structure.effects)


class _Moved(NamedTuple):
    """Windows of a run.

    `by_first`: derivatives of the states at a window's end by those at its start `(w, n, n)`; `begin`: start of every
    window after the run's first sample `(w,)` [s]; `axes`: the axes' angles and rates among the states.
    """

    by_first: np.ndarray
    begin: np.ndarray
    axes: np.ndarray


def _moved(rig: Rig, structure: Structure, log: Log) -> _Moved:
    """The windows of a run, each from the state that was measured at its start."""
    theta = theta_of(rig, structure)
    found, begin = [], []
    for piece in cut_up([replace(log, segments=Segments(PIECE_S))]):  # windows of a short log are short
        problem = pose(structure, (piece,))
        batch, nodes = problem.batch, measured_nodes(problem, theta)
        count = int(batch.windows_of[0])
        found.append(np.asarray(transitions(structure, theta, nodes, batch))[0, :count])
        begin.append(piece.time[0] - log.time[0] + batch.h[0] * len(batch.step_index) * np.arange(count))
    axes = [structure.states.index(x) for a, w, y, _ in structure.turning if not y.startswith("wheel") for x in (a, w)]
    return _Moved(np.concatenate(found), np.concatenate(begin), np.array(axes))


def _sizes(products: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Growth of a change of the axes' states by products of windows `(…, n, n)`: `(…,)` [1]."""
    part = products[..., axes[:, None], axes]
    finite = np.asarray(np.isfinite(part).all(axis=(-2, -1)))
    return np.where(finite, np.linalg.norm(np.where(finite[..., None, None], part, 0.0), 2, axis=(-2, -1)), math.inf)


@np.errstate(over="ignore", invalid="ignore")  # what grows beyond the range of numbers has grown enough
def _growth(moved: _Moved) -> float:
    """Growth of a change of the first state until any later window's end [1]."""
    products = np.array(list(accumulate(moved.by_first, lambda before, window: window @ before)))
    return max(1.0, float(np.max(_sizes(products, moved.axes))))


@np.errstate(over="ignore", invalid="ignore")
def _followed_s(moved: _Moved) -> float:
    """Longest stretch [s] within which a change grows to `WITHIN` at most, for `MOST_OF` the places where it may begin."""
    by_first, begin = moved.by_first, moved.begin
    first = np.unique(np.linspace(0, len(by_first) - 1, PLACES).astype(int))
    product, length = by_first[first], 1
    while length < len(by_first) and begin[length] < LONGEST_S:
        first = first[first + length < len(by_first)]
        product = by_first[first + length] @ product[: len(first)]
        if np.quantile(_sizes(product, moved.axes), MOST_OF) > WITHIN:
            break
        length += 1
    return float(begin[length]) if length < len(begin) else LONGEST_S
