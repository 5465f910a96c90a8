"""The free run of a rig under a command."""

import numpy as np
import pytest

from rwjax.errors import InputError
from rwjax.fitting.predict import predict
from rwjax.simulation.simulate import simulate
from tests.systems import platform, reaction, record
from tests.two_axes import two_axis

T = np.arange(51) * 0.01
U = np.full_like(T, 0.5)


def test_a_sliding_platform_follows_the_closed_form() -> None:
    I, b, M_c, k = 0.1, 0.02, 0.05, 0.4
    found = simulate(platform(), T, U, start={"w": 2.0})
    steady = (k * 0.5 - M_c) / b  # rad/s
    assert found["yaw_rad_s"] == pytest.approx(steady + (2.0 - steady) * np.exp(-b / I * T), rel=1e-9)
    assert [*found] == ["yaw_rad", "yaw_rad_s"] and np.array_equal(found.time, T)


def test_from_rest_it_is_what_predict_gives_for_a_log_without_readings() -> None:
    rig = reaction()
    found, predicted = simulate(rig, T + 3.0, 4.0 * U), predict(rig, record(T + 3.0, 4.0 * U, {}))
    for name in (*found, *predicted):
        assert found[name] == pytest.approx(predicted[name], rel=1e-12, abs=1e-15), name


def test_a_rig_with_two_axes_takes_two_commands() -> None:
    found = simulate(two_axis(), T, np.stack([U, -U], axis=1))
    assert found["wheel_1_rad_s"][-1] > 0.1 and found["wheel_2_rad_s"][-1] < -0.1


@pytest.mark.parametrize(
    ("time", "command", "start", "message"),
    [
        (T[:1], U[:1], {}, "give the times of at least two samples"),
        (T, U[:-1], {}, r"`command` has the shape \(50,\); a `platform` rig takes \(51,\) here, in volts"),
        (T, np.where(T > 0.2, np.nan, U), {}, "have to be finite numbers"),
        (np.where(T == T[7], 0.0, T), U, {}, "`time` does not increase: 0 s follows 0.06 s at sample 7"),
        (T, U, {"omega": 1.0}, "no state `omega`, nearest `.*`; this rig has psi, w"),
        (T, U, {"w": np.inf}, "state `w` inf: has to be a finite number"),
    ],
)
def test_what_cannot_be_simulated_is_said(time: np.ndarray, command: np.ndarray, start: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        simulate(platform(), time, command, start=start)
