"""Sizing: rings by integration, the thesis's numbers, and the limit that binds as the one whose relief helps."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rwjax.control.drive_limits import Limits, usable_rate
from rwjax.control.sizing import LIMITS, size_wheels
from rwjax.control.slew import slew
from rwjax.errors import InputError
from tests.control.sized_rig import LOADED, TOP, I, K, rig


@given(st.floats(1e-3, 0.02), st.floats(0.2, 3.0), st.floats(0.5, 20.0))
@pytest.mark.slow
def test_a_motor_of_the_needed_torque_takes_the_wanted_time(friction: float, angle: float, seconds: float) -> None:
    needs = size_wheels(rig(friction), np.array([1.24e-4]), angle, seconds, Limits(1e3, 1.0)).needs_torque
    heavy = np.array([1.0])  # a wheel that never reaches its top
    exactly = size_wheels(rig(friction), heavy, angle, seconds, Limits(1e3, needs / K, 1.0))
    assert exactly.torque == pytest.approx(needs)
    assert exactly.time[0] == pytest.approx(seconds) and LIMITS[exactly.limit[0]] == "current"
    # and a wheel of the needed momentum turns round just at its top
    for share, binds in ((1.001, "current"), (0.999, "wheel rate")):
        just = size_wheels(
            rig(friction), share * exactly.needs_momentum / np.array([TOP]), angle, seconds, Limits(1e3, needs / K, TOP)
        )
        assert LIMITS[just.limit[0]] in (binds, "friction" if binds == "wheel rate" else binds)


@given(st.floats(0.0, 0.02), st.floats(2e-5, 4e-4), st.floats(0.2, 2.0), st.floats(1.0, 6.0), st.floats(8.0, 14.0))
@pytest.mark.slow
def test_relief_of_the_limit_that_binds_helps(
    friction: float, J: float, angle: float, amps: float, volts: float
) -> None:
    limits = Limits(volts, amps, TOP)
    found = size_wheels(rig(friction), np.array([J]), angle, 5.0, limits)
    binds = LIMITS[found.limit[0]]
    assume(np.isfinite(found.time[0]))
    more = {"current": limits._replace(amps=1.01 * amps), "voltage": limits._replace(volts=1.01 * volts)}
    times = {
        name: float(size_wheels(rig(friction), np.array([J]), angle, 5.0, given).time[0])
        for name, given in more.items()
    }
    if binds in more:
        assert times[binds] < float(found.time[0])
        other = "voltage" if binds == "current" else "current"
        top = usable_rate(rig(friction), limits)
        if top == TOP:  # else voltage holds the wheel's rate, and the current may hold its torque
            assert times[other] == pytest.approx(float(found.time[0]), rel=1e-9)
    else:
        faster = size_wheels(
            rig(friction), np.array([1.01 * J]), angle, 5.0, limits
        )  # of more momentum at the same top
        assert float(faster.time[0]) < float(found.time[0])


@pytest.mark.parametrize("J", [1.24e-4, 8e-5])
@pytest.mark.slow
def test_the_plant_does_it_in_the_time_of_the_budget(J: float) -> None:
    limits, angle = Limits(20.0, 3.0, TOP), np.radians(25.0)
    budget = float(size_wheels(rig(0.01, J), np.array([J]), angle, 5.0, limits).time[0])
    assert slew(rig(0.01, J), angle, limits).time == pytest.approx(budget, rel=0.01)


@pytest.mark.slow
def test_friction_that_grows_with_the_drive_s_torque_is_in_the_budget() -> None:
    limits, angle, seconds = Limits(20.0, 3.0, TOP), np.radians(25.0), 2.0
    loaded, J = rig(0.005, more=LOADED), np.array([4e-4])
    found = size_wheels(loaded, J, angle, seconds, limits)
    torque, resists = 3.0 * K, 0.005 + 0.3 * 3.0 * K
    gains, loses = (torque - resists) / I, (torque + resists) / I
    assert found.time[0] == pytest.approx(np.sqrt(2.0 * angle * (1.0 / gains + 1.0 / loses)))
    exactly = size_wheels(loaded, np.array([1.0]), angle, seconds, Limits(1e3, found.needs_torque / K, 1.0))
    assert exactly.time[0] == pytest.approx(seconds)
    assert slew(loaded, angle, limits).time <= 1.01 * float(
        size_wheels(loaded, np.array([1.24e-4]), angle, seconds, limits).time[0]
    )


@pytest.mark.parametrize(
    ("effect", "instead", "binds"),
    [
        ('"motor.current_limit"]\ni_m = 0.6', {"amps": 0.6}, "current"),
        ('"drive.saturation"]\nu_m = 6.0', {"volts": 6.0}, "voltage"),
    ],
)
def test_a_limit_of_the_rig_is_one_of_the_budget(effect: str, instead: dict[str, float], binds: str) -> None:
    limits, J, angle = Limits(10.0, 3.0, TOP), np.array([4e-4]), np.radians(20.0)
    own = size_wheels(rig(0.003, more=f"[effects.{effect}"), J, angle, 5.0, limits)
    given = size_wheels(rig(0.003), J, angle, 5.0, limits._replace(**instead))
    assert own.time[0] == pytest.approx(given.time[0], rel=1e-3) and own.momentum[0] == pytest.approx(
        given.momentum[0], rel=1e-3
    )
    assert own.limit[0] == given.limit[0] and LIMITS[own.limit[0]] == binds


@pytest.mark.parametrize(("top", "binds"), [(300.0, "wheel rate"), (1e4, "voltage"), (np.inf, "voltage")])
def test_a_rate_that_the_voltage_does_not_reach_does_not_bind(top: float, binds: str) -> None:
    limits, J, angle = Limits(10.0, 3.0, top), np.array([4e-5]), np.radians(60.0)
    found = size_wheels(rig(0.0005), J, angle, 5.0, limits)
    assert LIMITS[found.limit[0]] == binds
    relieved = {"wheel rate": limits._replace(top=1.1 * top), "voltage": limits._replace(volts=11.0)}[binds]
    assert size_wheels(rig(0.0005), J, angle, 5.0, relieved).time[0] < found.time[0]


@pytest.mark.slow
def test_no_slew_takes_longer_than_the_budget() -> None:
    limits = Limits(20.0, 3.0, TOP)
    sticky = rig(0.005, more="viscous = 0.03")
    budget = size_wheels(sticky, np.array([1.24e-4]), np.radians(20.0), 5.0, limits)
    assert np.isfinite(budget.time[0])
    assert slew(sticky, np.radians(20.0), limits).time <= 1.01 * float(budget.time[0])


def test_a_wheel_whose_momentum_viscous_friction_takes_never_gets_there() -> None:
    viscous = rig(0.0, more="viscous = 0.082")
    # the wheel's momentum moves the axis by J top/b at most before friction has it: 36 degrees
    found = size_wheels(viscous, np.array([1.24e-4]), 0.5 * np.pi, 5.0, Limits(10.0, np.inf, TOP))
    assert np.isinf(found.time[0])


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(InputError, match=r"^angle -57\.2958° \(-1 rad\): has to be a positive number$"):
        size_wheels(rig(0.01), np.array([1e-4]), -1.0, 1.0, Limits(10.0))
    with pytest.raises(InputError, match="seconds 0"):
        size_wheels(rig(0.01), np.array([1e-4]), 1.0, 0.0, Limits(10.0))
    never = size_wheels(rig(0.1), np.array([1e-4]), 1.0, 5.0, Limits(20.0, 3.0, TOP))
    assert np.isinf(never.time[0]) and LIMITS[never.limit[0]] == "current"
