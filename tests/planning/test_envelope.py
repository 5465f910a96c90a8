"""Limits of a rig: what the neutral pulse, the rig file and the options say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax import InputError, read_rig
from rwjax.planning.envelope import Envelope, commanded_volts, envelope, rad_and_degrees
from rwjax.rig.model import Pwm
from tests.joints import joint, servo
from tests.planning.campaign_rigs import RIGS
from tests.systems import platform

TESTBED = Path(__file__).parents[2] / "data" / "testbed" / "rig.toml"


@pytest.mark.parametrize(
    ("neutral", "said"),
    [
        (2000.0, "is 2000, and boards give no pulses above 2000 us: too few are left"),
        (1960.0, "is 1960, and boards give no pulses above 2000 us: too few are left"),
        (900.0, "is 900, and boards give no pulses below 1000 us: too few are left"),
    ],
)
def test_a_neutral_pulse_beyond_which_there_is_little_is_refused(neutral: float, said: str) -> None:
    with pytest.raises(InputError, match=f"`drive.pwm.neutral_us` {said}"):
        envelope(replace(RIGS["reaction"], pwm=Pwm(neutral, 0.01)))


def test_what_the_rig_file_knows_is_a_limit() -> None:
    testbed = read_rig(TESTBED)
    assert envelope(testbed).volts == 10.0 and envelope(testbed, 4.0).volts == 4.0
    supplied = replace(RIGS["wheel"], pwm=None, numbers=RIGS["wheel"].numbers | {"drive.supply": 12.0})
    assert [envelope(supplied, volts).volts for volts in (None, 24.0, 5.0)] == [12.0, 12.0, 5.0]
    stop = {"high": 1.5, "low": -0.8, "k": 40.0, "d": 0.1}
    limited = replace(testbed, effects={"axis.end_stop": stop, "drive.saturation": {"u_m": 6.0, "n": 5000.0}})
    assert envelope(limited).known == {"voltage_V": 6.0, "yaw_rad": 0.8}
    assert envelope(limited, most={"yaw_rad": 0.5}).limits["yaw_rad"] == 0.5


def test_a_limit_of_what_the_rig_does_not_have_or_no_limit_at_all_is_one_line() -> None:
    with pytest.raises(
        InputError, match="nothing says how many volts the drive gives; add --volts, such as --volts 12"
    ):
        envelope(platform())
    with pytest.raises(InputError, match="--rpm: a `platform` rig has no rate of the wheel; leave the option out"):
        envelope(platform(), 10.0, {"wheel_rad_s": 100.0})


def test_the_largest_share_is_that_of_the_limit_that_is_used_most() -> None:
    within = Envelope(10.0, {"yaw_rad": 2.0, "yaw_rad_s": 4.0, "current_A": np.inf})
    peaks = {"yaw_rad": np.array([1.0, 0.2]), "yaw_rad_s": np.array([1.0, 3.0]), "current_A": np.array([50.0, 50.0])}
    assert within.largest_share(peaks) == pytest.approx([0.5, 0.75])
    assert within.limits_travel and not Envelope(10.0, {"yaw_rad": np.inf}).limits_travel


@pytest.mark.parametrize(
    ("neutral", "per_us", "forward", "backward"),
    [(1500.0, 0.02, 10.0, 10.0), (1000.0, 0.01, 10.0, 0.0), (1000.0, -0.01, 0.0, 10.0), (1200.0, 0.02, 16.0, 4.0)],
)
def test_pulses_tell_what_lies_between_the_neutral_one_and_their_ends(
    neutral: float, per_us: float, forward: float, backward: float
) -> None:
    assert commanded_volts(Pwm(neutral, per_us)) == pytest.approx({1.0: forward, -1.0: backward})


def test_a_travel_is_said_in_rad_and_in_degrees() -> None:
    assert rad_and_degrees(np.pi / 4.0) == "0.785398 rad (45°; a linear axis: 0.785398 m)"


def test_goals_have_limits_of_their_own() -> None:
    rig = servo(joint(), "current")
    assert envelope(rig, goal=0.8).known == {"goal_rad": 0.8} and envelope(rig, goal=0.8).input == "goal_rad"
    with pytest.raises(InputError, match=r"`goal_rad` needs the loop that follows it; write \[drive.servo\]"):
        envelope(joint(), goal=0.8)
    with pytest.raises(
        InputError, match="add --volts, such as --volts 12; for goals of its servo --goal, such as --goal 45deg"
    ):
        envelope(rig)
    with pytest.raises(InputError) as said:
        envelope(servo(joint(), "duty"), goal=0.8)
    assert (
        str(said.value)
        == "a duty needs the supply's voltage; write [drive] supply = 12 (volts; logs do not count here)"
    )
    assert envelope(servo(joint(drive__supply=12.0), "duty"), goal=0.8).volts == 0.8
