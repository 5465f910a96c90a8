"""What resists an axis: friction, load, and what grows with the drive."""

import numpy as np
import pytest

from rwjax.control.resistance import resisting_torque
from tests.control.sized_rig import LOADED, rig


def test_all_that_resists_is_counted() -> None:
    rates = np.array([0.0, 0.5, 1.0])
    most, least = resisting_torque(rig(0.01, more="viscous = 0.02"), 1.0, rates, 0.03)
    assert most == pytest.approx(0.01 + 0.02 * rates) and least == pytest.approx(np.full(3, 0.01))
    most, least = resisting_torque(rig(0.01, more='[effects."axis.bias_torque"]\nT = 0.004'), 1.0, rates, 0.03)
    assert most == pytest.approx(np.full(3, 0.014)) and least == pytest.approx(np.full(3, 0.006))
    most, _ = resisting_torque(rig(0.01, more='[effects."axis.spring"]\nk = 0.01\nT_0 = 0.0'), 0.7, 1.0, 0.03)
    assert most == pytest.approx(0.017)
    most, least = resisting_torque(rig(0.01, more=LOADED), 1.0, rates, 0.03)  # of the drive's torque, not of a load
    assert most == pytest.approx(np.full(3, 0.01 + 0.3 * 0.03)) and least == pytest.approx(most)
