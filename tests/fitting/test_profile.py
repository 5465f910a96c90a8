"""The profile against the cost computed by hand."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting import profile
from rwjax.fitting.fit import fit
from rwjax.fitting.multiple_shooting import Fit, least_squares
from tests.fitting.logs import ALL, FREE, log_of
from tests.systems import platform


def test_a_number_at_its_bound_has_a_one_sided_interval_that_the_profile_gives() -> None:
    truth = platform("viscous = 0.02\ncoulomb = 0.0", free=FREE)
    log = log_of(truth, noise=1e-3)
    found = fit(truth.with_values({"axis.friction.coulomb": 0.01}), [log])
    low, high = found.interval["axis.friction.coulomb"]
    assert low == 0.0 < high
    # the upper end by hand: hold the friction there, fit the rest, and see the cost grow by half of 3.84
    held = replace(truth.with_values({"axis.friction.coulomb": high}), free=truth.free[:2])
    k = found.fit.free.index("axis.friction.coulomb")
    grown = 2.0 * (fit(held, [log]).fit.cost - found.fit.cost) / found.uncertainty.inflation[k]
    assert grown == pytest.approx(3.84, rel=0.05)
    assert any("by its profile" in note for note in found.notes)


def test_a_side_that_the_logs_leave_open_has_no_end_and_takes_few_refits(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = platform(free=ALL)
    found = fit(truth, [log_of(truth, noise=1e-3)])
    refits = []

    def counted(*given, **more) -> Fit:
        refits.append(least_squares(*given, **more))
        return refits[-1]

    monkeypatch.setattr(profile, "least_squares", counted)
    number = entry_of(found.fit, "axis.inertia")
    _, high = profile.interval(found.fit, number, 1.0, 0.1 * float(found.fit.theta[number]))
    assert high == np.inf
    assert sum(one.steps for one in refits) < 4 * len(refits)  # each begins on the line through the last two


def entry_of(found: Fit, name: str) -> int:
    """Entry of the parameter vector of a free number."""
    return int(found.coordinates.index[found.free.index(name)])
