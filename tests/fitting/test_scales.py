"""Typical sizes of a log whose sizes are known."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.scales import SIZE_OF, scales, scales_for, sizes_of
from rwjax.kinds import NUMBERS, SERVO
from rwjax.logs.log import Segments
from rwjax.logs.segments import cut_up
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, record, wheel

TIME = np.arange(1001) * 0.01
LOG = record(TIME, np.where(np.arange(1001) % 2 == 0, 2.0, -2.0), {"yaw_rad": 3.0 * TIME - 1.0})


def test_sizes_of_a_steady_turn() -> None:
    found = scales(platform(), [LOG])
    assert found["command"] == pytest.approx(2.0) and found["peak"] == 2.0
    assert found["torque"] == pytest.approx(0.8)  # 0.4 N m/V
    assert found["rate"] == pytest.approx(3.0)
    assert found["torque_per_rate"] == pytest.approx(0.8 / 3.0)
    assert found["per_rate"] == pytest.approx(1.0 / 3.0) and found["turn_per_run"] == pytest.approx(2.0 * np.pi / 10.0)
    assert (found["lowest"], found["highest"], found["span"]) == pytest.approx((-1.0, 29.0, 30.0))


def test_a_run_in_segments_is_as_long_as_the_run() -> None:
    pieces = cut_up([replace(LOG, segments=Segments(2.0))])
    assert len(pieces) == 5 and scales(platform(), pieces)["turn_per_run"] == pytest.approx(
        2.0 * np.pi / 10.0, rel=0.01
    )


def test_the_faster_log_gives_the_rate() -> None:
    slow = record(TIME, LOG.command, {"yaw_rad_s": 0.0 * TIME + 0.5})
    assert scales(platform(), [slow, LOG])["rate"] == pytest.approx(3.0)


def test_a_number_has_its_own_size_or_a_tenth_of_its_kind() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.0")
    structure = structure_of(rig)
    size = dict(zip(structure.names, sizes_of(rig, structure, theta_of(rig, structure), [LOG]), strict=True))
    assert size["axis.inertia"] == 0.1
    assert size["axis.friction.coulomb"] == pytest.approx(0.08)
    assert size["axis.friction.viscous"] == pytest.approx(0.1 * 0.8 / 3.0)


def test_numbers_that_are_zero_have_the_size_of_their_kind() -> None:
    rig = wheel(inductance=1e-6)
    rig = replace(rig, numbers=rig.numbers | {"motor.friction": 0.0})
    log = record(TIME, LOG.command, {"wheel_rad": TIME})
    structure = structure_of(rig)
    size = dict(zip(structure.names, sizes_of(rig, structure, theta_of(rig, structure), [log]), strict=True))
    assert size["motor.friction"] == pytest.approx(0.01 * 0.0182**2 / 0.83)  # a hundredth of what the back-EMF does
    assert size["motor.inductance"] == pytest.approx(0.01 * 0.83 * 0.01)  # a hundredth of R times the step


@pytest.mark.parametrize(
    "name", [name for name, number in NUMBERS.items() if number.sign in ("any", "zero or positive")]
)
def test_whatever_may_be_zero_has_a_scale(name: str) -> None:
    scale = SIZE_OF.get(name) or SIZE_OF.get(name.rpartition(".")[2])
    assert name.startswith(SERVO) or scales(platform(), [LOG])[scale or ""] > 0.0


def test_a_rig_with_one_axis_has_one_set_of_scales() -> None:
    of = scales_for(platform(), [LOG])
    assert of("axis.inertia") == of("drive.deadzone") == scales(platform(), [LOG])
