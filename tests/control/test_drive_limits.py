"""What a drive gives within its limits, effect by effect."""

import pytest

from rwjax.control.drive_limits import Limits, torque_at
from tests.control.sized_rig import K, R, rig


@pytest.mark.parametrize(
    ("effect", "torque"),
    [
        ('"motor.current_limit"]\ni_m = 0.6', K * 0.6),
        ('"drive.saturation"]\nu_m = 6.0', K * (6.0 - K * 200.0) / R),
        ('"drive.asymmetric_gain"]\na = 0.5', K * (5.0 - K * 200.0) / R),  # in the weaker direction
        ('"motor.saturation"]\na = 0.04', K * 3.0 / (1.0 + 0.04 * 9.0)),
        ('"motor.saturation"]\na = 0.25', K * 2.0 / (1.0 + 0.25 * 4.0)),  # of 2 A there is more than of 3 A
        ('"wheel.drag"]\nc = 1e-7', K * 3.0 - 1e-7 * 200.0**2),
        ('"wheel.coulomb"]\nM_c = 0.002', K * 3.0 - 0.002),
    ],
)
def test_the_torque_is_what_the_plant_has(effect: str, torque: float) -> None:
    assert torque_at(rig(0.01, more=f"[effects.{effect}"), Limits(10.0, 3.0), 200.0) == pytest.approx(torque, rel=3e-4)
