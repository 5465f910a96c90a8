"""Layout: how much of the logs a diagnosis takes, which it fits and which it holds out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rwjax.diagnosis.gap import Split
from rwjax.diagnosis.hypothesis import logged_outputs
from rwjax.diagnosis.settings import LengthSettings
from rwjax.logs import coverage
from rwjax.logs.held_out import folds
from rwjax.logs.log import Log
from rwjax.logs.segments import cut_up, runs_of
from rwjax.logs.thin import some_of, thinned
from rwjax.plant.from_rig import structure_of
from rwjax.rig.model import Rig


@dataclass(frozen=True)
class Layout:
    """Logs by number, with what is fitted and what is held out.

    Attributes:
        rule: the held-out rule in words.
        runs: all runs, or the parts of a single one.
        logs: the same, or the segments in which free runs follow them.
        train: numbers of the logs on which the hypothesis is chosen.
        folds: numbers of the logs that each fold fits, and of those on which it is judged.
        split: whether held-out runs leave what the fitted ones cover.
    """

    rule: str
    runs: tuple[Log, ...]
    logs: tuple[Log, ...]
    train: tuple[int, ...]
    folds: tuple[Split, ...]
    split: coverage.Split

    @property
    def train_runs(self) -> tuple[int, ...]:
        """Numbers of the training runs."""
        return tuple(map(int, np.unique(runs_of(self.logs)[list(self.train)])))


def brief(rig: Rig, logs: Sequence[Log], limits: LengthSettings) -> tuple[tuple[Log, ...], list[str]]:
    """Logs of which a search can hold the derivatives: with fewer samples, and where that is not enough fewer of them.

    Args:
        rig: the rig.
        logs: its logs.
        limits: how much a search holds.

    Returns:
        The logs, and what was done in sentences.
    """
    columns = len(structure_of(rig).states) + len(rig.free) + limits.of_effect
    most = max(limits.derivatives // (columns * max(len(logged_outputs(logs)), 1)), 1)
    fewer, thinner = thinned(logs, most, limits.coarsest_s)
    fewer, some = some_of(fewer, most, limits.fewest_runs)
    return fewer, [told for told in (thinner, some) if told]


def laid_out(rig: Rig, logs: Sequence[Log]) -> Layout:
    """Logs numbered, with the folds by number.

    Args:
        rig: the rig.
        logs: its logs, cut into segments or whole.

    Returns:
        The layout.

    Raises:
        LogError: no log may be fitted.
    """
    rule, splits = folds(logs)
    runs: list[Log] = []
    for log in (log for split in splits for log in (*split.train, *split.test)):
        if not any(other is log for other in runs):
            runs.append(log)
    segments = [cut_up([log]) for log in runs]
    first = np.cumsum([0, *map(len, segments)])

    def numbers(part: Sequence[Log]) -> tuple[int, ...]:
        found = [next(k for k, other in enumerate(runs) if other is log) for log in part]
        return tuple(n for k in found for n in range(int(first[k]), int(first[k + 1])))

    numbered = tuple((numbers(split.train), numbers(split.test)) for split in splits)
    train = tuple(sorted({k for fitted_to, _ in numbered for k in fitted_to}))
    pieces = tuple(part for parts in segments for part in parts)
    return Layout(rule, tuple(runs), pieces, train, numbered, coverage.split_of(rig, logs))
