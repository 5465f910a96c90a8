"""The section `[columns]`: what it means, and what is refused."""

import re
from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import RigError
from rwjax.rig.columns_section import KEYS, Source, entry, sources
from rwjax.rig.read import parse_rig
from rwjax.rig.write import write_rig
from tests.rig.texts import PLATFORM

SECTION = """[columns]
position = "pos1"
time_s = { column = "ms", unit = "ms" }
voltage_V = { column = "pwm", scale = "12 V / 255" }
yaw_rad = { column = "angle", unit = "deg", sign = -1, offset = 3 }
yaw_rad_s = { unit = "rpm", unsigned = true }
supply_V = "battery"
"""


def test_a_column_is_sign_times_scale_times_unit_times_what_lies_above_the_offset() -> None:
    found = parse_rig(PLATFORM + SECTION).sources
    assert [*found] == ["time_s", "voltage_V", "yaw_rad", "yaw_rad_s", "supply_V"]
    x = np.array([-7.0, 0.0, 3.0, 12.5])
    assert found["yaw_rad"].convert(x) == pytest.approx(-np.deg2rad(x - 3.0), rel=1e-14)
    assert found["voltage_V"].convert(x) == pytest.approx(x * 12.0 / 255.0, rel=1e-14)
    assert found["supply_V"].convert(x) is x and found["supply_V"].column == "battery"
    assert found["yaw_rad_s"].column == "yaw_rad_s" and found["yaw_rad_s"].unsigned


def test_milliseconds_are_seconds_to_the_last_digit() -> None:
    k = np.arange(100_000)
    assert np.array_equal(Source("ms", factor=1e-3).convert(k.astype(float)), [float(f"{i}e-3") for i in k])


def test_what_is_written_reads_back() -> None:
    rig = parse_rig(PLATFORM + SECTION)
    text = write_rig(rig)
    assert parse_rig(text) == rig and 'supply_V = "battery"' in text
    assert 'yaw_rad = {column = "angle", unit = "deg", sign = -1, offset = 3.0}' in text
    assert entry("yaw_rad", Source("yaw_rad")) == "yaw_rad" and {*KEYS} == {*Source._fields} - {"factor"}


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            'yaw_rads = "x"',
            "unknown key `columns.yaw_rads`; the nearest valid one of a `platform` rig is `columns.yaw_rad_s`",
        ),
        ('current_A = "x"', "unknown key `columns.current_A`; the nearest"),
        ("yaw_rad = 3", '`columns.yaw_rad` is 3; write yaw_rad = "NAME" or { column = "NAME", unit = "…" }'),
        (
            "yaw_rad.colum = 'x'",
            "unknown key `columns.yaw_rad.colum`; the nearest valid one is `columns.yaw_rad.column`",
        ),
        ("yaw_rad.unit = 3", "`columns.yaw_rad.unit` is 3; it has to be a text in quotes"),
        ("yaw_rad.column = 'a\\u0007b'", "`columns.yaw_rad.column` holds"),
        ("yaw_rad.unit = 'V'", '`columns.yaw_rad.unit` "V" is no unit of this column; write rad, deg or turn'),
        ("voltage_V.scale = '12 A'", "`columns.voltage_V.scale` '12 A' is no unit of this column; write V or mV"),
        ("yaw_rad.scale = 0", "`columns.yaw_rad.scale` is 0.0; it has to be different from zero"),
        ("yaw_rad.scale = true", "`columns.yaw_rad.scale` is True; it has to be a number"),
        ("yaw_rad.sign = 2", "`columns.yaw_rad.sign` is 2; it has to be 1 or -1"),
        ("yaw_rad.offset = 1e300", "`columns.yaw_rad.offset` is 1e+300; it lies between"),
        ("yaw_rad.unsigned = true", "`columns.yaw_rad.unsigned`: only a measured rate or current may lack its sign"),
        ("yaw_rad_s.unsigned = 1", "`columns.yaw_rad_s.unsigned` is 1; it has to be true or false"),
        ("position = 'x'", '`columns.position` is \'x\'; it has to be "pos1" or "pos2"'),
    ],
)
def test_what_no_column_can_be_is_refused_in_one_line(line: str, message: str) -> None:
    with pytest.raises(RigError, match=re.escape(f"rig.toml: {message}")) as error:
        parse_rig(PLATFORM + "[columns]\n" + line.replace("'", '"'))
    assert len(str(error.value).splitlines()) == 1


def test_a_section_that_is_no_table_is_refused() -> None:
    with pytest.raises(RigError, match="`columns` is not a table; write it as a section"):
        parse_rig("columns = 3\n" + PLATFORM)


def test_every_column_of_a_kind_may_be_named() -> None:
    rig = parse_rig(PLATFORM)
    named = sources({"time_s": "t", "enabled.column": "on"} if rig.kind != "platform" else {"time_s": "t"}, rig.kind)
    assert replace(rig, sources=named).sources["time_s"] == Source("t")
