"""Three kinds of interval."""

import numpy as np
import pytest

from rwjax.fitting.bootstrap import bootstrap
from rwjax.fitting.fit import fit
from rwjax.fitting.intervals import interval_words
from rwjax.fitting.profile import interval
from tests.fitting.logs import ALL, FREE, log_of
from tests.systems import platform


def test_three_kinds_of_interval_agree_where_the_sum_of_squares_is_a_parabola() -> None:
    truth = platform(free=FREE)
    found = fit(truth, [log_of(truth, noise=1e-3)])
    drawn = np.percentile(bootstrap(found.fit, 60), (2.5, 97.5), axis=0).T
    for k, name in enumerate(found.fit.free):
        error = found.uncertainty.standard_error[name]
        low, high = found.interval[name]
        number = int(found.fit.coordinates.index[k])
        assert interval(found.fit, number, float(found.uncertainty.inflation[k]), error) == pytest.approx(
            (low, high), abs=0.05 * error
        )
        assert 0.5 < (drawn[k, 1] - drawn[k, 0]) / (high - low) < 1.6, name  # 60 draws of 24 stretches
        assert low < truth.values[name] < high, name


def test_numbers_that_only_scale_together_have_no_interval() -> None:
    rig = platform(free=ALL)
    found = fit(rig, [log_of(rig, noise=1e-3)])
    assert {ends[1] for ends in found.interval.values()} == {np.inf}


def test_an_open_end_is_said_in_words() -> None:
    said = [interval_words(*ends, 3) for ends in ((1.0, 2.0), (1.0, np.inf), (-np.inf, 2.0), (np.nan, np.nan))]
    assert said == ["95 %: 1 to 2", "95 %: above 1", "95 %: below 2", "95 %: any value"]
