"""Units in words against their definitions."""

import math

import pytest

from rwjax.rig.units import factor


@pytest.mark.parametrize(
    ("scale", "unit", "to", "value"),
    [
        (1.0, "ms", "s", 1e-3),
        (1.0, "µs", "s", 1e-6),
        (1.0, "min", "s", 60.0),
        (1.0, "deg", "rad", math.pi / 180.0),
        (1.0, "°", "rad", math.pi / 180.0),
        (2.0, "turn", "rad", 4.0 * math.pi),
        (1.0, "rpm", "rad/s", math.pi / 30.0),
        (1.0, "rev/min", "rad/s", math.pi / 30.0),
        (1.0, "deg/s", "rad/s", math.pi / 180.0),
        (1.0, "mA", "A", 1e-3),
        ("12 V / 255", "", "V", 12.0 / 255.0),
        ("5 V / 1023 / (0.185 V/A)", "", "A", 5.0 / 1023.0 / 0.185),
        ("1/255", "", "", 1.0 / 255.0),
        (1.0, "percent", "", 0.01),
        (0.25, "", "rad", 0.25),
        ("360/4096", "deg", "rad", 2.0 * math.pi / 4096.0),
        (1.0, "N cm", "N m", 0.01),
        (1.0, "count", "", 1.0),
    ],
)
def test_factors_are_those_of_the_definitions(scale: float | str, unit: str, to: str, value: float) -> None:
    assert factor(scale, unit, to) == pytest.approx(value, rel=1e-14)


def test_a_length_stands_for_an_angle_on_a_linear_axis_alone() -> None:
    assert factor(1.0, "mm", "rad", linear=True) == pytest.approx(1e-3) == factor(1.0, "mm/s", "rad/s", linear=True)
    with pytest.raises(ValueError, match="is no unit of this column; write rad, deg or turn"):
        factor(1.0, "mm", "rad")


@pytest.mark.parametrize(
    ("scale", "unit", "to", "message"),
    [
        (1.0, "V", "rad", "is no unit of this column; write rad, deg or turn"),
        (1.0, "Hz", "rad/s", "of turns a second write turn/s, of turns a minute rpm"),
        (1.0, "1/min", "rad/s", "of turns a minute rpm"),
        (1.0, "counts", "rad", "is no unit of this column"),
        (1.0, "parsec²", "s", "is no unit; write one such as"),
        (1.0, "9**9**9", "s", "is no unit; write one such as"),
        (1.0, "x" * 61, "s", "is no unit; write one such as"),
        (1.0, "moods", "s", "is no unit that is known"),
        (1.0, "(((", "s", "is no unit that is known"),
        ("12 V / 0", "", "V", "is no unit that is known"),
        ("0 V", "", "V", "makes 0 of 0 V; it has to be a finite number other than 0"),
        ("nan V", "", "V", "makes nan of nan V"),
        ("12 V", "ms", "V", "is no unit of this column; write V or mV"),
    ],
)
def test_what_is_no_unit_of_a_column_is_refused(scale: float | str, unit: str, to: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        factor(scale, unit, to)
