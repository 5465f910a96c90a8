"""The bootstrap: many short logs, and priors."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.bootstrap import bootstrap
from rwjax.fitting.fit import fit
from tests.fitting.logs import ALL, FREE, log_of
from tests.systems import platform


@pytest.mark.slow
def test_a_bootstrap_over_many_short_logs_moves_in_every_draw() -> None:
    truth = platform(free=FREE)
    parts = [log_of(truth, noise=1e-3).cut(k, k + 200) for k in range(0, 1000, 100)]
    found = fit(truth, parts)
    drawn = bootstrap(found.fit, 40)
    assert np.all(np.abs(drawn - found.fit.theta[found.fit.coordinates.index]).max(axis=1) > 0.0)
    for k, name in enumerate(found.fit.free):
        assert 0.5 < np.std(drawn[:, k]) / found.uncertainty.standard_error[name] < 2.0, name


def test_a_bootstrap_draws_the_prior_too_and_leaves_open_what_is_open() -> None:
    rig = platform(free=ALL)
    log = log_of(rig, noise=1e-3)
    low, high = fit(replace(rig, prior={"drive.gain": (0.4, 0.02)}), [log], bootstrap=60).interval["axis.inertia"]
    assert high - low == pytest.approx(3.92 * 0.05 * 0.1, rel=0.35)
    open_ended = fit(rig, [log], bootstrap=5)
    assert open_ended.interval["axis.inertia"][1] == np.inf
    assert not any("refits" in note for note in open_ended.notes)
