"""The two layouts of a log file: their columns, and what does not fit the rig."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.logs.layouts import read_columns
from rwjax.logs.read import read_log
from rwjax.logs.read_sheet import read_sheet
from rwjax.logs.text_sheet import TextSheet
from rwjax.logs.write import write_log
from rwjax.rig.columns import COLUMNS, COMMANDS, commands_of
from tests.logs.texts import HEADER, PLATFORM, REACTION, ROWS, THESIS_HEADER, THESIS_ROWS, WHEEL, changed
from tests.two_axes import GIMBAL, GRAVITY, TILTING, two_axis

two = "time_s,voltage_V"
MALFORMED = [
    (["volt,yaw_counts", *ROWS], ":1: no column `time_s`, which every log needs; found `volt`, `yaw_counts`"),
    (
        ["time_s,volts,yaw_counts", *ROWS],
        "no column `voltage_V`, which every log needs; found `time_s`, `volts`, ",
    ),
    (
        ["time_s,voltage_mV,yaw_counts", *ROWS],
        "nearest `voltage_mV` (`rwjax import FILE` proposes [columns] that read the file as it is); in its place",
    ),
    (
        [two + ",yaw_count", *ROWS],
        ":1: unknown column `yaw_count`; did you mean `yaw_counts`? Else, if it is a reading, ",
    ),
    (
        [HEADER + ",temperature_C", *(row + ",20" for row in ROWS)],
        ":1: unknown column `temperature_C`; if it is a reading, say which by [columns] of the rig file (`rwjax import FILE` proposes "
        "it); else write `# ignore: temperature_C` above the header to leave it out",
    ),
    ([HEADER + ",", *(row + "," for row in ROWS)], ":1: column 4 has no name; name it, or take it out"),
    (["# ignore: time_s", HEADER, *ROWS], "no column `time_s`, which every log needs; found `voltage_V`, `yaw_counts`"),
    (
        [HEADER + ",current_A", *ROWS],
        "a `platform` rig has no `current_A`; its columns are time_s, voltage_V, duty, goal_rad, supply_V",
    ),
    ([HEADER + ",yaw_rad", *ROWS], "`yaw_counts` and `yaw_rad` are the same reading; keep one of them"),
    ([HEADER + ",voltage_V", *ROWS], "`voltage_V` and `voltage_V` are the same reading"),
    (
        changed(3, "0.02,1,1"),
        ":5: `time_s` is 0.02 after 0.02; time has to increase from row to row: log microseconds, or keep one row of each time stamp",
    ),
    (
        changed(3, "0,1,1"),
        ":5: `time_s` is 0.0 after 0.02; time has to increase from row to row: split the log there where a new run begins",
    ),
    (
        changed(11, "1e308,1,1"),
        ":13: `time_s` is 1e+308; a clock shows 1e+10 s at most (1.8e+09 since 1970): in seconds? say a unit under [columns]",
    ),
    (
        [HEADER, *(f"{k}e-300,0,{k}" for k in range(12))],
        ":3: `time_s` is 1e-300 s after the row before; samples lie 1e-07 s apart at least",
    ),
    (
        [HEADER, *(f"{k}e-7,0,{k}" for k in range(0, 36, 3))],
        ":1: `time_s` has a sample every 3e-07 s; a rig needs one ",
    ),
    (
        changed(11, "1e6,1,1"),
        ":13: `time_s` is 1e+06 s after the row before, and nothing is known of 600 s without a sample: split the log there",
    ),
    (
        [HEADER, *(f"{k},0,{k}" for k in (*range(60), *range(600, 30_000, 590)))],
        "the run takes 29510 s; a log has 25000 s at most: split it into several",
    ),
    (
        [HEADER + ",supply_V", *(row + f",{12 * (k != 4)}" for k, row in enumerate(ROWS))],
        ":6: `supply_V` is 0; a supply gives more than 0 V: leave the rows or the column out",
    ),
    ([HEADER + ",supply_V", *(row + ",-12" for row in ROWS)], ":2: `supply_V` is -12; a supply gives more than 0 V"),
    (
        [THESIS_HEADER, *THESIS_ROWS],
        ':1: the thesis layout needs [columns] position = "pos1" or "pos2" in the rig',
    ),
]


@pytest.mark.parametrize(("lines", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_columns_that_cannot_be_are_refused_in_one_line(refused, lines: list[str], message: str) -> None:
    refused(lines, message)


@pytest.mark.parametrize(
    ("lines", "rig", "message"),
    [
        (
            ["time_s,voltage_V,wheel_counts", *ROWS],
            REACTION,
            "`wheel_counts` needs [wheel_encoder] counts_per_rev = …",
        ),
        (["time_s,voltage_V,position_m", *ROWS], REACTION, "a `reaction` rig has no `position_m`"),
        ([HEADER, *ROWS], WHEEL, "a `wheel` rig has no `yaw_counts`"),
    ],
)
def test_log_that_does_not_fit_the_rig(log, lines, rig, message):
    with pytest.raises(LogError) as error:
        log(lines, rig)
    assert message in str(error.value)


def test_columns_keep_the_units_of_their_names(tmp_path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("\n".join([HEADER, *ROWS]))
    _, found = read_columns(read_sheet(path), PLATFORM)
    assert [*found] == HEADER.split(",") and np.array_equal(found["yaw_counts"], 7.0 * np.arange(12))


@pytest.mark.parametrize(("rig", "output", "counts"), [(WHEEL, "wheel_rad", 100), (REACTION, "yaw_rad", 2048)])
def test_thesis_layout(log, rig, output, counts):
    run = log(["# role: validate", THESIS_HEADER, *THESIS_ROWS], rig)
    assert run.validate and run.time == pytest.approx(0.01 * np.arange(12))
    assert run.command == pytest.approx(0.02 * np.arange(12))
    assert run.outputs[output] == pytest.approx(2 * np.arange(12) * math.tau / counts)


def test_pulses_of_the_thesis_need_a_map_to_volts(refused) -> None:
    message = ":1: the thesis layout needs [drive] pwm = { neutral_us = …, volts_per_us = … } in the rig file"
    refused([THESIS_HEADER, *THESIS_ROWS], message, replace(WHEEL, pwm=None))


def test_milliseconds_are_noticed(log):
    with pytest.raises(LogError, match="a sample every 10 s; a rig needs one every 2 s at least"):
        log([HEADER, *(f"{10 * k},{k % 3},{7 * k}" for k in range(12))])


@pytest.mark.parametrize("start", [0.0, 1.7e9, -5.0])
def test_a_clock_may_begin_at_any_time(log, start: float) -> None:
    """At 1.7e9 s, seconds since 1970, it still resolves a thousandth of a sample."""
    run = log([HEADER, *(f"{start + k / 1000!r},{k % 3},{k}" for k in range(12))])
    assert run.time - run.origin == pytest.approx(np.arange(12) / 1000, abs=1e-6)


def test_a_pulse_that_gives_more_volts_than_any_drive_is_refused(log, refused) -> None:
    assert log([THESIS_HEADER, *THESIS_ROWS, "0;1;2;3;50001500;5"], WHEEL).command[-1] == 1e6
    lines = [THESIS_HEADER, *THESIS_ROWS, "0;1;2;3;1e300;5"]
    refused(lines, "run.csv:14: `pwm_1` is 1e+300, 2e+298 V by `drive.pwm`; no drive gives as much", WHEEL)


@pytest.mark.parametrize(
    ("seconds", "read"),
    [
        (2.0 * np.arange(12), True),  # a sample every 2 s at least
        (2.05 * np.arange(12), False),
        (1e-6 * np.arange(12), True),  # and every microsecond at most
        (0.97e-6 * np.arange(12), False),
        (
            np.append(1.01e-6 * np.arange(12), 11.11e-6 + 1.01e-7),
            True,
        ),  # two that are nearer, but no nearer than 1e-7 s
        (np.append(1.01e-6 * np.arange(12), 11.11e-6 + 0.97e-7), False),
        (np.append(np.arange(12), 611.0), True),  # ten minutes without a sample
        (np.append(np.arange(12), 612.0), False),
        (np.append(np.arange(12), np.arange(100.0, 25_001.0, 100.0)), False),  # the middle interval is too long
        (np.concatenate([np.arange(300.0), np.arange(300.0, 25_001.0, 100.0)]), True),  # seven hours
        (np.concatenate([np.arange(300.0), np.arange(300.0, 25_201.0, 100.0)]), False),
        (1e10 - np.arange(12.0)[::-1], True),  # the year 2286
        (1.05e10 - np.arange(12.0)[::-1], False),
        (np.append(np.arange(11.0), 10.0), False),
    ],
)
def test_the_time_of_a_run_has_limits(log, seconds: np.ndarray, read: bool) -> None:
    lines = [HEADER, *(f"{t!r},{k % 3},{k}" for k, t in enumerate(seconds.tolist()))]
    if read:
        assert np.array_equal(log(lines).time, seconds)
    else:
        with pytest.raises(LogError, match="time_s|the run takes"):
            log(lines)


def test_a_supply_may_be_weak_but_not_off(log, refused) -> None:
    header, rows = HEADER + ",supply_V", [f"{row},0.001" for row in ROWS]
    assert np.all(log([header, *rows]).supply == 0.001)
    refused([header, *rows[:-1], ROWS[-1] + ",0"], f":{len(ROWS) + 1}: `supply_V` is 0; a supply gives")


@pytest.mark.parametrize(
    ("name", "said"), [("yaw_RPM", "rates are in rad/s (1/min times π/30); if it is a reading, say"), ("x", "")]
)
def test_a_rate_in_turns_a_minute_is_known(refused, name: str, said: str) -> None:
    lines = [f"{HEADER},{name}", *(f"{row},1" for row in ROWS)]
    refused(lines, f"unknown column `{name}`; {said or 'if it is a reading, say'}")


def test_a_reading_of_another_name_in_rwjaxs_own_layout_is_to_be_named_by_rwjax(refused) -> None:
    """For [columns] does not count there."""
    lines = ["# layout: rwjax", f"{HEADER},speed", *(f"{row},1" for row in ROWS)]
    refused(lines, "unknown column `speed`; if it is a reading, give it a name of rwjax's (time_s, voltage_V, duty, ")


def test_every_column_of_a_kind_may_stand_in_a_log_and_those_of_others_may_not() -> None:
    for rig in (WHEEL, PLATFORM, REACTION, WHOLE):
        commands = commands_of(rig.kind)[: 2 if rig is WHOLE else 1]
        for name, kinds in (COMMANDS | {n: c.kinds for n, c in COLUMNS.items()}).items():
            given = (name,) if name in COMMANDS and rig is not WHOLE else commands
            names = [*dict.fromkeys(("time_s", *given, "supply_V", name))]
            rows = [",".join([f"{k / 100}", *(["1"] * (len(names) - 1))]) for k in range(12)]
            sheet = TextSheet("run.csv", {}, names, 1, ",", rows)
            if rig.kind in kinds:
                assert [*read_columns(sheet, rig)[1]] == names
            else:
                with pytest.raises(LogError, match=f"a `{rig.kind}` rig has no `{name}`|no column `voltage"):
                    read_columns(sheet, rig)


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        (
            "time_s,duty,yaw_rad",
            "{t},{k},1",
            ":4: `duty` is 2; a duty lies between -1 and 1: divide it, or write duty = {",
        ),
        ("time_s,voltage_V,duty,yaw_rad", "{t},1,1,1", "`voltage_V` and `duty` are both commands, and a log holds one"),
        ("time_s,voltage_V,enabled,wheel_rad_s", "{t},1,2,1", ":2: `enabled` is 2; it has to be 1 where torque is on"),
        ("time_s,command_Nm,wheel_rad_s", "{t},1,1", "no column `voltage_V`, which every log needs"),
    ],
)
def test_a_log_has_one_command_of_its_size(refused, header: str, row: str, message: str) -> None:
    rig = REACTION if "wheel" in header else PLATFORM
    refused([header, *(row.format(t=k / 100, k=k) for k in range(12))], message, rig)


WHOLE = two_axis(GIMBAL + GRAVITY + TILTING)
T = 0.01 * np.arange(60)
READ = {"time_s": T, "voltage_1_V": np.sin(T), "voltage_2_V": np.cos(T), "yaw_rad": T, "pitch_counts": np.zeros(60)}


@pytest.mark.parametrize(
    "columns, said",
    [
        ({"voltage_V": T}, "no column `voltage_1_V`, which every log needs"),
        (READ | {"voltage_V": T}, "a `two_axis` rig has no `voltage_V`"),
        (READ | {"wheel_rad_s": T}, "a `two_axis` rig has no `wheel_rad_s`"),
    ],
)
def test_an_unusable_log_is_refused_in_one_line(columns: dict, said: str, tmp_path: Path) -> None:
    write_log(tmp_path / "log.csv", {"time_s": T} | columns)
    with pytest.raises(LogError) as error:
        read_log(tmp_path / "log.csv", WHOLE)
    assert said in str(error.value) and "\n" not in str(error.value)


def test_a_log_of_the_thesis_holds_one_axis(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t;pos1;pos2;speed2;pwm_1;pwm_2\n" + 20 * "0;0;0;0;1500;1500\n")
    with pytest.raises(LogError, match="holds one axis; a `two_axis` rig needs `time_s`, `voltage_1_V`"):
        read_log(tmp_path / "log.csv", WHOLE)
