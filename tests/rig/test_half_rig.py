"""One half of a rig with two axes as a `reaction` rig."""

from dataclasses import replace

from rwjax.rig.half_rig import half_rig
from rwjax.rig.read import parse_rig
from rwjax.rig.write import write_rig
from tests.two_axes import GIMBAL, GRAVITY, TILTING, two_axis

WHOLE = two_axis(GIMBAL + GRAVITY + TILTING)


def test_each_half_has_the_numbers_of_its_axis_and_wheel() -> None:
    yaw, pitch = half_rig(WHOLE, 0), half_rig(WHOLE, 1)
    assert yaw.kind == pitch.kind == "reaction"
    assert yaw.numbers["axis.inertia"] == 0.0495 and pitch.numbers["axis.inertia"] == 0.021
    assert pitch.numbers["axis.gravity.torque"] == 0.15 and "axis.gravity.torque" not in yaw.numbers
    assert "gimbal.difference" not in yaw.numbers and {*yaw.numbers} < {*pitch.numbers}


def test_effects_go_with_their_half() -> None:
    assert half_rig(WHOLE, 0).effects == {"wheel.gyroscopic": {"s": 1.0}} and half_rig(WHOLE, 1).effects == {}


def test_a_half_is_a_rig_that_can_be_written_and_estimates_nothing() -> None:
    half = half_rig(replace(WHOLE, free=("yaw.inertia",), effects={}), 1)
    assert half.free == () and parse_rig(write_rig(half)) == half
