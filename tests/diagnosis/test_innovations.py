"""Innovations of a residual, and which of two explanations they speak for."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.innovations import innovations, log_likelihood
from rwjax.fitting.multiple_shooting import Fit
from tests.diagnosis.several_runs import TIME, run_of, searched

DRY = Hypothesis(("axis.coulomb",))


def test_innovations_of_an_autoregression_are_its_noise() -> None:
    noise = np.random.default_rng(0).normal(size=(2, 20_000))
    series = [np.asarray(lfilter([1.0], [1.0, -1.5, 0.7], e)) for e in noise]
    found = innovations(series, 8)
    wanted = np.concatenate([e[8:] for e in noise])
    assert len(found) == len(wanted) and np.max(np.abs(found - wanted)) < 0.1
    assert np.var(found) == pytest.approx(np.var(wanted), rel=1e-3)


def test_a_line_has_none_and_short_stretches_neither() -> None:
    assert np.allclose(innovations([np.arange(50.0)], 8), 0.0, atol=1e-9)
    assert len(innovations([np.ones(8)], 8)) == 0


def test_what_left_the_range_of_numbers_has_infinite_innovations() -> None:
    assert np.isinf(innovations([np.array([*range(20), np.inf])], 8)).all()


def test_readings_that_lack_cut_a_log_into_stretches() -> None:
    """A drift that goes on behind a gap of readings is no leap."""
    logs = [run_of(k, {}, disturbed=0.1) for k in range(2)]
    holes = np.zeros(len(logs[0].time), bool)
    holes[300:400] = True
    broken = [replace(log, outputs={"yaw_rad": np.where(holes, np.nan, log.outputs["yaw_rad"])}) for log in logs]
    whole, cut = (log_likelihood(searched(each, DRY).fits.known(NOTHING), [0, 1], 8)[1] for each in (logs, broken))
    assert cut == pytest.approx(whole, abs=0.2)


def test_the_likelihood_is_that_of_white_noise_where_nothing_is_missing() -> None:
    search = searched([run_of(k, {}) for k in range(2)], DRY)
    fitted = search.fits.known(NOTHING)
    count, mean = log_likelihood(fitted, [0, 1], 8)
    assert count == 2 * (len(TIME) - 8) and mean == pytest.approx(0.0, abs=0.1)  # in units of the noise


def test_it_tells_a_drive_that_lags_from_one_that_is_late_beside_a_slow_motion() -> None:
    """Both leave about as much of a slow motion that nothing explains, of which all squares are."""
    lag, late = Hypothesis(("drive.lag",)), Hypothesis(("drive.delay",))
    truth = {"drive.lag": {"T": 0.2}}
    search = searched([run_of(k, truth, disturbed=0.1) for k in range(3)], lag, late)
    excess = search.comparison.excess
    assert excess(late) < 2.0 * excess(lag)

    def likelihood(e: Hypothesis) -> float:
        fitted: Fit = search.fits.known(e)
        return log_likelihood(fitted, [0, 1, 2], 8)[1]

    assert likelihood(lag) > likelihood(late) + 0.02 and likelihood(lag) > likelihood(NOTHING) + 0.02
