"""Log files read: counts become radians, what is missing is NaN, and readings that cannot be are refused."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.errors import InputError, LogError
from rwjax.logs.read import read_log, read_logs
from rwjax.logs.write import write_log
from rwjax.rig.columns_section import sources
from tests.logs.texts import HEADER, PLATFORM, REACTION, ROWS, changed
from tests.two_axes import two_axis

two = "time_s,voltage_V"
MALFORMED = [
    (
        [two, *(row.rpartition(",")[0] for row in ROWS)],
        "no measured output; a `platform` rig needs at least one of `yaw_counts`, `yaw_rad`, `position_m`",
    ),
    (changed(3, "0.03,1,1.5"), ":5: `yaw_counts` is 1.5; counts have to be whole numbers"),
    (changed(3, "0.03,1,inf"), ":5: `yaw_counts` is infinite; leave the cell empty"),
    (
        [HEADER, *(f"{k},1," for k in range(12))],
        ":1: `yaw_counts` holds 0 readings; give at least 10, or leave",
    ),
    ([HEADER, *(f"{k},1,{'' if k > 8 else k}" for k in range(12))], "`yaw_counts` holds 9 readings"),
]


@pytest.mark.parametrize(("lines", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_readings_that_cannot_be_are_refused_in_one_line(refused, lines: list[str], message: str) -> None:
    refused(lines, message)


def test_counts_become_radians(log):
    run = log(["# role: validate", "# Rig: yaw testbed", "", HEADER, *ROWS])
    assert run.name == "run.csv" and run.validate and run.notes == {"role": "validate", "rig": "yaw testbed"}
    assert np.array_equal(run.time, np.arange(12) / 100) and np.array_equal(run.command, np.arange(12) % 3)
    assert run.outputs["yaw_rad"] == pytest.approx(7 * np.arange(12) * math.tau / 256, rel=1e-15)
    assert run.resolution == {"yaw_rad": math.tau / 256} and run.supply is None and run.origin == 0.0


@pytest.mark.parametrize(
    ("lines", "ending"),
    [
        ([HEADER, *ROWS], "\r\n"),
        (["\ufeff" + HEADER, *ROWS], "\n"),
        ([HEADER, *ROWS, "", "  ", ""], "\n"),
        ([HEADER.replace(",", ", "), *(row.replace(",", " ,\t") for row in ROWS)], "\n"),
    ],
    ids=["CRLF", "byte order mark", "blank last lines", "blanks"],
)
def test_the_same_log_written_otherwise(log, lines, ending):
    plain, other = log([HEADER, *ROWS]), log(lines, ending=ending)
    assert not plain.validate
    assert np.array_equal(plain.time, other.time) and np.array_equal(plain.command, other.command)
    assert np.array_equal(plain.outputs["yaw_rad"], other.outputs["yaw_rad"])


def test_missing_readings_are_nan(log):
    lines = [
        "supply_V,voltage_V,yaw_rad,time_s",
        *(f"12,1,{k},{k}" for k in range(12)),
        "12,1,,12",
        "12,1,NaN,13",
        "12,1, ,14",
    ]
    run = log(lines)
    assert np.isnan(run.outputs["yaw_rad"][12:]).all() and np.array_equal(run.outputs["yaw_rad"][:12], np.arange(12))
    assert run.resolution == {"yaw_rad": 0.0} and run.supply is not None and (run.supply == 12.0).all()


def test_all_that_a_file_says_is_in_the_log(log) -> None:
    header = "supply_V,current_A,voltage_V,wheel_rad_s,wheel_counts,yaw_rad,time_s"
    rows = [f"{12 - k / 8},{0.1 * k},{k % 3},{2 * k},{3 * k},{0.5 * k},{7 + k / 4}" for k in range(10)]
    rig = replace(REACTION, counts_per_rev={"wheel": 100.0})
    run = log(["# role: validate", "# add axis.inertia: 0.5", "# who: me", header, *rows], rig)
    k = np.arange(10)
    assert np.array_equal(run.time, 7 + k / 4) and run.origin == 7.0 and np.array_equal(run.command, k % 3)
    expected = {"yaw_rad": 0.5 * k, "wheel_rad": 3 * k * math.tau / 100, "wheel_rad_s": 2 * k, "current_A": 0.1 * k}
    assert {*run.outputs} == {*expected} == {*run.resolution}
    for name, value in expected.items():
        assert run.outputs[name] == pytest.approx(value, rel=1e-15)
        assert run.resolution[name] == (math.tau / 100 if name == "wheel_rad" else 0.0)
    assert run.added == {"axis.inertia": 0.5} and run.validate and run.notes["who"] == "me"
    assert run.supply is not None and np.array_equal(run.supply, 12 - k / 8) and run.left_out == {}


def test_linear_axis_and_no_outputs(log):
    run = log(["time_s,voltage_V,position_m", *ROWS])
    assert list(run.outputs) == ["yaw_rad"] and run.resolution == {"yaw_rad": 0.0}
    assert log(["time_s,voltage_V", *(row.rpartition(",")[0] for row in ROWS)], outputs_required=False).outputs == {}


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("0.03,0,1e15", ":5: `yaw_counts` is 1e+15, 2.454e+13 rad; an angle lies between -1e+09 and 1e+09 rad"),
        ("0.03,0,-1e300", ":5: `yaw_counts` is -1e+300, -2.454e+298 rad; an angle lies between"),
        ("0.03,1e300,0", ":5: `voltage_V` is 1e+300; a voltage lies between -1e+06 and 1e+06 V"),
    ],
)
def test_a_reading_beyond_all_rigs_is_refused(log, row, message):
    with pytest.raises(LogError, match=re.escape(message)):
        log(changed(3, row))


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("yaw_rad", "2e9", "`yaw_rad` is 2e+09; an angle lies between -1e+09 and 1e+09 rad"),
        ("yaw_rad_s", "-2e6", "`yaw_rad_s` is -2e+06; a rate lies between -1e+06 and 1e+06 rad/s"),
        ("current_A", "1e7", "`current_A` is 1e+07; a current lies between -1e+06 and 1e+06 A"),
    ],
)
def test_a_reading_is_no_larger_than_its_unit_allows(refused, column: str, value: str, message: str) -> None:
    lines = [f"time_s,voltage_V,{column}", *(f"{k / 100},1,{value if k == 7 else 0.1 * k}" for k in range(12))]
    refused(lines, ":9: " + message, REACTION)


def test_unreadable_files(tmp_path):
    with pytest.raises(LogError, match="none.csv: cannot be read: No such file or directory"):
        read_log(tmp_path / "none.csv", PLATFORM)
    (tmp_path / "latin.csv").write_bytes("\n".join([HEADER, *ROWS, ""]).encode() + b"0.5,1,\xb5\n")
    with pytest.raises(LogError, match="latin.csv:14: `yaw_counts` is 'µ'; it has to be a number"):
        read_log(tmp_path / "latin.csv", PLATFORM)


def test_several_logs(tmp_path):
    for name in ("a/run.csv", "b/run.csv", "c.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("\n".join([HEADER, *ROWS]))
    paths = [tmp_path / "a/run.csv", tmp_path / "c.csv", tmp_path / "b/run.csv"]
    assert [log.name for log in read_logs(paths, PLATFORM)] == [str(paths[0]), "c.csv", str(paths[2])]
    assert [log.name for log in read_logs(str(paths[1]), PLATFORM)] == ["c.csv"]
    with pytest.raises(LogError, match="c.csv: named 2 times; name each log once"):
        read_logs([tmp_path / "c.csv", tmp_path / "a/../c.csv"], PLATFORM)


def test_paths_may_be_generated_and_what_is_no_path_is_said(tmp_path) -> None:
    (tmp_path / "run.csv").write_text("\n".join([HEADER, *ROWS]))
    (log,) = read_logs((path for path in [tmp_path / "run.csv"]), PLATFORM)
    assert log.name == "run.csv"
    right = "it has to be a path, as a text or a `pathlib.Path`"
    for given, said in (
        (5, "`paths` is a `int`"),
        (b"run.csv", "`paths` is a `bytes`"),
        ({"run": "run.csv"}, "`paths` is a `dict`"),
        (None, "`paths` is a `NoneType`"),
    ):
        with pytest.raises(InputError, match=f"^read_logs: {re.escape(f'{said}; {right}')}, or several in a list$"):
            read_logs(given, PLATFORM)  # pyright: ignore[reportArgumentType]
    for given, kind in (([None], "NoneType"), ([0], "int"), ([()], "tuple"), ([tmp_path / "run.csv", 0], "int")):
        with pytest.raises(InputError, match=f"^read_logs: `paths` holds a `{kind}`; {re.escape(right)}, or several"):
            read_logs(given, PLATFORM)  # pyright: ignore[reportArgumentType]
    with (
        open(tmp_path / "run.csv") as file,
        pytest.raises(InputError, match="^read_logs: `paths` is a `TextIOWrapper`; "),
    ):
        read_logs(file, PLATFORM)
    with pytest.raises(InputError, match=f"^read_log: `path` is a `list`; {re.escape(right)}$"):
        read_log([tmp_path / "run.csv"], PLATFORM)  # pyright: ignore[reportArgumentType]


def test_names_of_files_are_printed_and_stay_different(tmp_path) -> None:
    names = ["a\x1b[31m.csv", "a\udcff.csv", r"a\udcff.csv", "b\nc.csv"]
    for name in names:
        (tmp_path / name).write_text("\n".join([HEADER, *ROWS]))
    found = [log.name for log in read_logs([tmp_path / name for name in names], PLATFORM)]
    assert found[0] == r"a\x1b[31m.csv" and found[3] == r"b\nc.csv"
    assert found[1:3] == [rf"{tmp_path}/a\udcff.csv", rf"{tmp_path}/a\udcff.csv (2)"]
    with pytest.raises(LogError, match=r"none\\udcff.csv: cannot be read: No such file"):
        read_log(tmp_path / "none\udcff.csv", PLATFORM)


def test_outliers_are_left_out_and_their_times_kept(log) -> None:
    rows = [f"{k / 100},0,{1000 if k == 7 else k}" for k in range(30)]
    run = log([HEADER, *rows])
    assert np.flatnonzero(np.isnan(run.outputs["yaw_rad"])).tolist() == [7]
    assert run.left_out["yaw_rad"].tolist() == [0.07]


def test_counts_of_a_second_axis_need_their_own_encoder(tmp_path) -> None:
    t = 0.01 * np.arange(60)
    read = {"time_s": t, "voltage_1_V": np.sin(t), "voltage_2_V": np.cos(t), "yaw_rad": t, "pitch_counts": np.zeros(60)}
    write_log(tmp_path / "log.csv", read)
    with pytest.raises(LogError, match=re.escape("`pitch_counts` needs [pitch_encoder] counts_per_rev")):
        read_log(tmp_path / "log.csv", two_axis())


def test_a_link_to_itself_is_a_file_that_cannot_be_read(tmp_path) -> None:
    (tmp_path / "loop.csv").symlink_to(tmp_path / "loop.csv")
    with pytest.raises(LogError, match=r"loop\.csv: cannot be read"):
        read_logs([tmp_path / "loop.csv"], PLATFORM)


def test_of_an_empty_file_the_columns_that_the_rig_file_names_are_said(tmp_path: Path) -> None:
    rig = parse_rig('kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n')
    mapped = replace(rig, sources=sources({"time_s.column": "ms", "time_s.unit": "ms", "voltage_V": "pwm"}, "platform"))
    (tmp_path / "empty.csv").write_text("")
    for one, row in ((rig, "has to be `time_s,voltage_V,…`"), (mapped, "the columns that [columns] names: `ms,pwm`")):
        with pytest.raises(LogError, match="empty.csv: holds no header and no samples; the first row ") as said:
            read_log(tmp_path / "empty.csv", one)
        assert row in str(said.value)
