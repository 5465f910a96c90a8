"""The split of momentum, against what was planted and against nothing."""

import numpy as np
import pytest
from scipy.stats import binom, kstest

from rwjax.diagnosis.localise.momentum import Momentum
from rwjax.diagnosis.settings import MomentumSettings
from rwjax.rig.model import Rig
from tests.diagnosis.localise.measured import COASTS, COMMAND, located, measured
from tests.systems import platform, reaction

FULL = ("yaw_rad", "wheel_rad_s", "current_A")
COUPLED = "viscous = 0.0026\ncoulomb = 0.004"
LEVEL = MomentumSettings().level


def momentum(rig: Rig, seed: int, names: tuple[str, ...], **effects: dict) -> Momentum:
    logs = [measured(rig, c, c, names, 100 * seed + k, **effects) for k, c in enumerate((8.0 * COMMAND, 8.0 * COASTS))]
    found = located(rig, *logs).momentum
    assert found is not None
    return found


@pytest.mark.parametrize("names", [pytest.param(FULL, marks=pytest.mark.slow), FULL[:2]])
def test_the_side_that_lacks_a_torque(names: tuple[str, ...]) -> None:
    rig = reaction(COUPLED)
    assert momentum(rig, 1, names, **{"axis.bias_torque": {"T": 0.002}}).side == "external"
    assert momentum(rig, 2, names, **{"wheel.coulomb": {"M_c": 5e-4}}).side == "internal"
    assert momentum(rig, 3, names, **{"drive.deadzone": {"u_0": 0.4}}).side == "internal"


@pytest.mark.slow
def test_neither_side_where_nothing_is_missing() -> None:
    rig, seeds = reaction(COUPLED), 40
    found = [momentum(rig, seed, FULL) for seed in range(seeds)]
    for alarms in (sum(m.external < LEVEL for m in found), sum(m.internal < LEVEL for m in found)):
        assert alarms <= binom.ppf(0.999, seeds, LEVEL)
    p = np.array([m.external for m in found])
    assert kstest(p, "uniform").pvalue > 1e-3


def test_a_rig_of_which_one_body_alone_is_read_has_no_split() -> None:
    rig = platform("viscous = 0.05")
    assert located(rig, measured(rig, COMMAND, COMMAND, ("yaw_rad",), 0)).momentum is None
    both = reaction(COUPLED)
    assert located(both, measured(both, 8.0 * COMMAND, 8.0 * COMMAND, ("yaw_rad", "current_A"), 0)).momentum is None
