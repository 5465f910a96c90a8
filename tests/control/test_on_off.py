"""The ideal on-off law against its integrals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.control.on_off import on_off
from tests.control.current_limited_rig import I, J


@given(st.floats(0.02, 20.0), st.floats(1e-3, 0.2), st.floats(20.0, 900.0))
def test_the_ideal_law_turns_the_axis_by_its_angle(angle: float, torque: float, top: float) -> None:
    law = on_off(I, J, angle, torque, top)
    t = np.linspace(0.0, law.time, 20_001)
    wheel = law.wheel(t)
    assert np.max(wheel) <= top * (1.0 + 1e-9) and wheel[-1] == pytest.approx(0.0, abs=1e-9 * top)
    assert np.max(np.abs(np.diff(wheel))) <= torque / J * (t[1] - t[0]) * (
        1.0 + 1e-6
    )  # never more than the motor's torque
    turned = np.sum(0.5 * (wheel[1:] + wheel[:-1])) * (t[1] - t[0])  # trapezoids, exact but where the law bends
    h = t[1] - t[0]
    bends = 4.0 * h * min(torque / J * h, np.max(wheel))  # what trapezoids miss
    assert law.turned(np.array([law.time]))[0] == pytest.approx(turned, rel=1e-9, abs=bends)
    assert J / I * turned == pytest.approx(angle, rel=1e-9, abs=J / I * bends)  # eq. 4.2
    assert law.hold < 1e-9 * law.time or law.top == top
