"""What the commands for manoeuvres read off the drive's options."""

import math

import pytest

from rwjax.cli.manoeuvre import delay_note, limits_of
from rwjax.errors import InputError


def test_limits_are_in_si_units() -> None:
    assert tuple(limits_of(10.0, 3.0, 4000.0)) == pytest.approx((10.0, 3.0, 4000.0 * math.pi / 30.0))
    with pytest.raises(InputError, match="^--volts inf: has to be a finite number$"):
        limits_of(math.inf, 3.0, 4000.0)


def test_a_delay_is_said_where_there_is_one() -> None:
    assert delay_note(0.0) == []
    (line,) = delay_note(0.02)
    assert line.startswith("the drive's delay of 0.02 s is in this time")
