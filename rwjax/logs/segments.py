"""Runs cut into segments, each of which a free run follows from a start of its own, and put together again."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rwjax.logs.log import Log
from rwjax.logs.sheet import FEWEST

EARLIER_S = 10.0
"""How much of the command before a segment it keeps [s]: more than any drive delays."""


def cut_up(logs: Sequence[Log]) -> tuple[Log, ...]:
    """Runs in the segments that were decided on, each under its run's name.

    Args:
        logs: Runs; one for which nothing is decided stays whole.

    Returns:
        The segments, those of a run one after the other.
    """
    return tuple(part for log in logs for part in (_parts(log) if log.segments else [log]))


def _parts(log: Log) -> list[Log]:
    """A run in equal segments no longer than decided; one with too few readings belongs to the one before it."""
    how = log.segments
    t = log.time - log.time[0]
    count = max(1, int(np.ceil(t[-1] / how.seconds - 1e-9))) if how else 1
    if how is None or count == 1 or how.number:
        return [log]
    edges = [0, *map(int, np.searchsorted(t, t[-1] * np.arange(1, count) / count)), len(t)]
    seen = [np.append(0, np.cumsum(np.isfinite(y))) for y in log.outputs.values()]

    def enough(first: int, last: int) -> bool:
        return last - first >= FEWEST and all(int(n[last] - n[first]) >= FEWEST for n in seen)

    first = [0]
    for a, b in zip(edges[1:-1], edges[2:], strict=True):
        if enough(first[-1], a) and enough(a, b):
            first.append(a)
    found = []
    for k, (a, b) in enumerate(zip(first, [*first[1:], len(t)], strict=True)):
        part = log.cut(a, b)
        late = part.earlier[0] > part.time[0] - EARLIER_S
        earlier = part.earlier[0][late], part.earlier[1][late]
        found.append(replace(part, name=log.name, segments=how._replace(number=k), earlier=earlier))
    return found


def runs_of(logs: Sequence[Log]) -> np.ndarray:
    """To which run each log belongs.

    Args:
        logs: Runs and segments of runs, those of a run one after the other.

    Returns:
        Number of the run of each log `(l,)`, counted from 0 [index].
    """
    return np.cumsum([k == 0 or not log.goes_on for k, log in enumerate(logs)]) - 1


def put_together(segments: Sequence[Log]) -> Log:
    """The run that consecutive segments were cut from.

    Args:
        segments: The segments, at least one.

    Returns:
        The run, or the stretch of it that they cover.
    """
    first = segments[0]
    if len(segments) == 1:
        return first
    found: dict[str, list[np.ndarray]] = {}
    for part in segments:
        for name, times in part.left_out.items():
            found.setdefault(name, []).append(times)
    return replace(
        first,
        time=np.concatenate([part.time for part in segments]),
        command=np.concatenate([part.command for part in segments]),
        outputs={name: np.concatenate([part.outputs[name] for part in segments]) for name in first.outputs},
        **{name: _joined([getattr(part, name) for part in segments]) for name in ("supply", "enabled", "acting")},
        left_out={name: np.concatenate(times) for name, times in found.items()},
    )


def whole_runs(logs: Sequence[Log]) -> tuple[Log, ...]:
    """The runs that logs belong to.

    Args:
        logs: Runs and segments of runs, those of a run one after the other.

    Returns:
        Each run, put together from its segments.
    """
    run = runs_of(logs)
    return tuple(put_together([logs[int(k)] for k in np.flatnonzero(run == r)]) for r in np.unique(run))


def _joined(parts: Sequence[np.ndarray | None]) -> np.ndarray | None:
    """What all segments hold as one array, None where it was not logged."""
    held = [part for part in parts if part is not None]
    return np.concatenate(held) if held else None
