"""The profile against the cost computed by hand."""

from dataclasses import replace

import pytest

from rwjax.fitting.fit import fit
from tests.fitting.logs import FREE, log_of
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
