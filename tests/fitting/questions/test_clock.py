"""A clock is asked about where another time explains the readings and the log's does not."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.questions.clock import about_clock
from rwjax.fitting.questions.likeness import Run
from tests.fitting.questions.runs import LOGS, RIG
from tests.systems import run


def wrong(factor: float) -> list[Run]:
    """The logs with their time divided by a factor, beside free runs in that time."""
    logs = [replace(log, time=log.time / factor, origin=log.origin / factor) for log in LOGS]
    return [Run(log, run(RIG, log, {})) for log in logs]


def in_true_time(runs: Sequence[Run], factor: float) -> Callable[[float], list[Run]]:
    """Free runs in a time multiplied: with the right factor those of the true logs, else standing still."""
    right = [Run(each.log, run(RIG, log, {})) for each, log in zip(runs, LOGS, strict=True)]
    still = [Run(each.log, {name: 0.0 * y for name, y in each.simulated.items()}) for each in runs]
    return lambda tried: right if np.isclose(tried, factor) else still


@pytest.mark.parametrize(
    ("factor", "says"),
    [
        (0.1, "Divide `time_s` by 10, or write scale = 0.1 for it in [columns]"),
        (10.0, "Multiply `time_s` by 10, or write scale = 10 for it in [columns]"),
    ],
)
def test_a_clock_ten_times_too_fast_or_too_slow_is_asked_about(factor: float, says: str) -> None:
    runs = wrong(factor)
    ((question, logs),) = about_clock(runs, in_true_time(runs, factor)).items()
    assert says in question and question.startswith("square.csv and 2 more: 10 times") and logs == [0, 1, 2]


def test_only_the_log_that_is_wrong_is_named() -> None:
    right, bad = [Run(log, run(RIG, log, {})) for log in LOGS], wrong(0.1)
    runs = [right[0], bad[1], right[2]]
    ((question, logs),) = about_clock(runs, in_true_time(runs, 0.1)).items()
    assert question.startswith("chirp.csv: 10 times slower") and logs == [1]


def test_a_log_that_another_time_explains_better_is_named_with_one_where_it_is_plain() -> None:
    runs = wrong(0.1)
    dull = {name: 0.6 * y for name, y in runs[1].log.outputs.items()}  # as a slow motion hardly tells
    runs = [runs[0], Run(runs[1].log, dull), runs[2]]
    ((question, logs),) = about_clock(runs, in_true_time(runs, 0.1)).items()
    assert question.startswith("square.csv and 2 more: 10 times slower") and logs == [0, 1, 2]


def test_right_clocks_are_not_asked_about_and_no_other_time_is_tried() -> None:
    def never(factor: float) -> list[Run]:
        raise AssertionError("simulated in vain")

    assert about_clock([Run(log, run(RIG, log, {})) for log in LOGS], never) == {}


@pytest.mark.parametrize("longer", [0.01, 100.0])
def test_a_time_in_which_nobody_records_is_not_asked_about(longer: float) -> None:
    """A run of a tenth of a second, and samples a second apart and more."""
    runs = [
        Run(
            replace(log, time=longer * log.time, origin=longer * log.origin),
            {n: 0.0 * y for n, y in log.outputs.items()},
        )
        for log in LOGS
    ]
    true = [Run(each.log, each.log.outputs) for each in runs]
    assert about_clock(runs, lambda factor: true if (factor > 1.0) == (longer > 1.0) else runs) == {}
