"""The held-out rule: which logs a model is fitted on, and which it is judged on."""

from collections.abc import Sequence
from dataclasses import dataclass

from rwjax.errors import LogError, refuses_other_types
from rwjax.logs.log import Log
from rwjax.logs.sheet import FEWEST


@dataclass(frozen=True)
class Fold:
    """One split of the logs.

    Attributes:
        train: Logs that a model is fitted and selected on.
        test: Logs that it is judged on, and that nothing looks at before.
    """

    train: tuple[Log, ...]
    test: tuple[Log, ...]


@refuses_other_types
def folds(logs: Sequence[Log]) -> tuple[str, tuple[Fold, ...]]:
    """The splits of a set of logs.

    Logs marked `# role: validate` are held out. Where none is marked, each log is held out once; of a single
    log, the last third.

    Args:
        logs: The logs of one rig.

    Returns:
        Name of the rule that applies, as in `diagnosis.json`, and its splits.

    Raises:
        LogError: Without a log to fit on, and where the only log is too short to be split.
        InputError: The argument is no list of logs.
    """
    train = tuple(log for log in logs if not log.validate)
    test = tuple(log for log in logs if log.validate)
    if not train:
        names = ", ".join(log.name for log in logs) or "no log"
        raise LogError(f"{names}: no log to fit on; give at least one without `# role: validate`")
    if test:
        return "marked", (Fold(train, test),)
    if len(train) == 1:
        return "last-third", (_last_third(train[0]),)
    rule = "each-on-the-other" if len(train) == 2 else "leave-one-run-out"
    return rule, tuple(Fold(train[:i] + train[i + 1 :], (log,)) for i, log in enumerate(train))


def _last_third(log: Log) -> Fold:
    """The first two thirds of a log to fit on, the last to judge on."""
    n = len(log.time)
    first = n - n // 3
    if n - first < FEWEST:
        raise LogError(f"{log.name}: {n} samples; a single log needs at least {3 * FEWEST}, or give a second log")
    fold = Fold((log.cut(0, first),), (log.cut(first, n),))
    for part in (*fold.train, *fold.test):
        if silent := next((name for name, y in part.outputs.items() if not (y == y).any()), None):
            raise LogError(f"{part.name}: no reading of `{silent}`; give a second log, or leave the column out")
    return fold
