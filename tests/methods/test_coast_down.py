"""Coast-downs: the filter, and which stretches are taken."""

import numpy as np
import pytest

from rwjax.methods.coast_down import coast_downs, filtered_speed
from tests.joints import joint, logged
from tests.systems import platform, record, run


def test_the_filter_is_exact_for_a_straight_angle() -> None:
    t = np.arange(400) * 0.01
    assert filtered_speed(t, 1.0 + 3.0 * t)[200:] == pytest.approx(3.0, rel=1e-12)


def test_only_stretches_without_input_are_taken() -> None:
    rig = platform()
    t = np.arange(1501) * 0.01
    u = np.where((t > 0.5) & (t < 3.0), 1.0, 0.0)
    log = record(t, u, {"yaw_rad": run(rig, record(t, u), {})["yaw_rad"]})
    (stretch,) = coast_downs(rig, log)
    assert np.all(stretch.speed > 0.0) and np.all(np.diff(stretch.speed) < 0.0)
    assert stretch.time[-1] < 12.0


@pytest.mark.parametrize("off", [True, False])
def test_a_joint_coasts_with_torque_off_or_braked_by_its_back_emf(off: bool) -> None:
    """Friction 0.02 N m s/rad on 0.02 kg m2; the motor brakes by 0.02 N m s/rad unless its circuit is open."""
    rig = joint(motor__torque_constant=2e-3)
    K, t = rig.numbers["motor.torque_constant"], np.arange(601) * 0.01
    volts = np.where((t > 0.5) & (t < 1.5), 5.0, 0.0)
    on = ((t < 1.5) | ~np.array(off)).astype(float)
    log = logged(rig, t, voltage_V=np.where(t < 1.5, volts, 5.0 * off), enabled=on)
    (stretch,) = coast_downs(rig, log)
    braking = 0.0 if off else (100.0 * K) ** 2 / 2.0
    np.testing.assert_allclose(stretch.pushed, -braking / 0.02 * stretch.speed, rtol=1e-9)
    slowing = np.diff(np.log(stretch.speed)) / np.diff(stretch.time)
    assert np.median(slowing) == pytest.approx(-(0.02 + braking) / 0.02, rel=0.05)
