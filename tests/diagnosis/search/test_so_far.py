"""The answer so far: what leads among what was compared, and what was not."""

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.search.so_far import so_far
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from tests.diagnosis.simulated import fits_of, true_log
from tests.systems import platform

RIGHT, WRONG, LATER = (Hypothesis((name,)) for name in ("axis.bias_torque", "sensor.scale", "drive.lag"))


@pytest.mark.slow
def test_what_leads_so_far_is_no_choice() -> None:
    rig = platform("viscous = 0.02")
    fits = fits_of(rig, true_log(rig, **{"axis.bias_torque": {"T": 0.03}}))
    names = [name for e in (WRONG, LATER, RIGHT) for name in e.names]
    fits(NOTHING)
    none = so_far(fits, names)
    assert none.best == NOTHING and not none.complete and none.untried == tuple(names)
    assert none.ranking == ((NOTHING, 1.0),)
    SuccessiveHalving(fits).fit([WRONG, RIGHT], NOTHING)
    some = so_far(fits, names)
    assert some.best == RIGHT and not some.complete and some.untried == LATER.names and not some.alternatives
    assert some.ranking[0][0] == RIGHT and {e for e, _ in some.ranking} == {RIGHT, WRONG, NOTHING}
    fits.headway.compared -= {RIGHT}  # ended before it was fitted from all of its places
    again = so_far(fits, names)
    assert (again.best, again.untried, again.ranking) == (RIGHT, LATER.names, some.ranking)
    assert np.sum([p for _, p in some.ranking]) == pytest.approx(1.0)
