"""The log file: what is read, what is refused in which words, and what is written reads back equal."""

import math
import os
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.errors import LogError
from rwjax.logs.read import read_log, read_logs
from rwjax.logs.write import write_log
from rwjax.rig.read import parse_rig

PLATFORM = parse_rig('kind = "platform"\ndrive.gain = 1\naxis.inertia = 1\nencoder.counts_per_rev = 256')
MOTOR = "motor = { torque_constant = 1, resistance = 1 }\nwheel.inertia = 1\n"
THESIS = """columns = { position = "pos2", pulse = "pwm_1" }
drive.pwm = { neutral_us = 1500, volts_per_us = 0.02 }
"""
WHEEL = parse_rig('kind = "wheel"\n' + MOTOR + THESIS + "wheel_encoder.counts_per_rev = 100")
REACTION = parse_rig('kind = "reaction"\n' + MOTOR + THESIS + "axis.inertia = 1\nencoder.counts_per_rev = 2048")
ROWS = [f"{k / 100},{k % 3},{7 * k}" for k in range(12)]
HEADER = "time_s,voltage_V,yaw_counts"
THESIS_HEADER = "t;pos1;pos2;speed2;pwm_1;pwm_2"
THESIS_ROWS = [f"junk;{k};{2 * k};nan;{1500 + k};1500" for k in range(12)]


@pytest.fixture
def log(tmp_path):
    """Writes lines to a file and reads it as a log."""

    def read(lines, rig=PLATFORM, ending="\n", **options):
        path = tmp_path / "run.csv"
        path.write_bytes(ending.join(lines).encode())
        return read_log(path, rig, **options)

    return read


def changed(row: int, line: str) -> list[str]:
    """A good log with one row (counted from 0 below the header in line 1) replaced."""
    return [HEADER, *ROWS[:row], line, *ROWS[row + 1 :]]


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


def test_linear_axis_and_no_outputs(log):
    run = log(["time_s,voltage_V,position_m", *ROWS])
    assert list(run.outputs) == ["yaw_rad"] and run.resolution == {"yaw_rad": 0.0}
    assert log(["time_s,voltage_V", *(row.rpartition(",")[0] for row in ROWS)], outputs_required=False).outputs == {}


@pytest.mark.parametrize(("rig", "output", "counts"), [(WHEEL, "wheel_rad", 100), (REACTION, "yaw_rad", 2048)])
def test_thesis_layout(log, rig, output, counts):
    run = log(["# role: validate", THESIS_HEADER, *THESIS_ROWS], rig)
    assert run.validate and run.time == pytest.approx(0.01 * np.arange(12))
    assert run.command == pytest.approx(0.02 * np.arange(12))
    assert run.outputs[output] == pytest.approx(2 * np.arange(12) * math.tau / counts)


def test_columns_that_a_note_says_to_ignore_are_not_looked_at(log):
    more = [f"{HEADER},temperature_C,state", *(f"{row},21.5,warm" for row in ROWS)]
    read, plain = log(["# ignore: temperature_C, state", *more]), log([HEADER, *ROWS])
    assert read.outputs.keys() == plain.outputs.keys()
    assert np.array_equal(read.outputs["yaw_rad"], plain.outputs["yaw_rad"])


def test_cut_keeps_the_origin(log):
    run = log([HEADER, *(f"{k / 100 + 3},0,{k}" for k in range(20))])
    part = run.cut(4, 8).cut(1, 4)
    assert part.origin == 3.0 and part.time == pytest.approx([3.05, 3.06, 3.07])
    assert part.outputs["yaw_rad"] == pytest.approx(np.array([5, 6, 7]) * math.tau / 256)
    assert run.cut(0, 20).name == "run.csv" and run.cut(10, 20).name == "run.csv[3.1 s…]"


two = "time_s,voltage_V"
MALFORMED = [
    ([""], "holds no header and no samples"),
    (["# a: b"], "holds no header and no samples"),
    (ROWS, ":1: no header; the first row has to name the columns"),
    ([HEADER], ":1: 0 samples below the header; a log needs at least 10"),
    ([HEADER, *ROWS[:9]], ":1: 9 samples below the header"),
    (["volt,yaw_counts", *ROWS], ":1: no column `time_s`, which every log needs; found `volt`, `yaw_counts`"),
    (
        ["time_s,volts,yaw_counts", *ROWS],
        "no column `voltage_V`, which every log needs; found `time_s`, `volts`, ",
    ),
    ([two + ",yaw_count", *ROWS], ":1: unknown column `yaw_count`; did you mean `yaw_counts`? Else write `# ignore: "),
    (
        [HEADER + ",temperature_C", *(row + ",20" for row in ROWS)],
        ":1: unknown column `temperature_C`; write `# ignore: temperature_C` above the header to leave it out",
    ),
    ([HEADER + ",", *(row + "," for row in ROWS)], ":1: column 4 has no name; name it, or take it out"),
    (["# ignore: yaw", HEADER, *ROWS], "`# ignore: yaw`: no such column; the nearest is `yaw_counts`"),
    (["# ignore: time_s", HEADER, *ROWS], "no column `time_s`, which every log needs; found `voltage_V`, `yaw_counts`"),
    (
        [HEADER + ",current_A", *ROWS],
        "a `platform` rig has no `current_A`; its columns are time_s, voltage_V, supply_V",
    ),
    ([HEADER + ",yaw_rad", *ROWS], "`yaw_counts` and `yaw_rad` are the same reading; keep one of them"),
    ([HEADER + ",voltage_V", *ROWS], "`voltage_V` and `voltage_V` are the same reading"),
    (
        [two, *(row.rpartition(",")[0] for row in ROWS)],
        "no measured output; a `platform` rig needs at least one of `yaw_counts`, `yaw_rad`, `position_m`",
    ),
    (
        [HEADER.replace(",", ";"), *ROWS],
        ":1: the columns are separated by semicolons; separate them by commas",
    ),
    ([HEADER.replace(",", "\t"), *ROWS], ":1: the columns are separated by tabs; separate them by commas"),
    (["# role: test", HEADER, *ROWS], "`# role: test` is unknown; it is `train` or `validate`"),
    (["# role validate", HEADER, *ROWS], ":1: `# role validate` is no note; write `# role: validate`"),
    (changed(3, "0.03,1"), ":5: 2 cells; the header names 3 columns"),
    (changed(3, ""), ":5: 1 cells; the header names 3 columns"),
    (changed(3, "0.03,1,2,3"), ":5: 4 cells; the header names 3 columns"),
    (changed(3, "# a: b"), ":5: a note among the samples; notes go before the header"),
    (
        changed(3, "0.03,1,1O"),
        ":5: `yaw_counts` is '1O'; it has to be a number, or empty where a reading is missing",
    ),
    (changed(3, "0.03,1,1.5"), ":5: `yaw_counts` is 1.5; counts have to be whole numbers"),
    (changed(3, "0.03,1,inf"), ":5: `yaw_counts` is infinite; leave the cell empty"),
    (changed(3, "nan,1,1"), ":5: `time_s` is missing; it has to be a finite number in every row"),
    (changed(3, "0.03,,1"), ":5: `voltage_V` is missing; it has to be a finite number in every row"),
    (changed(3, "0.03,-inf,1"), ":5: `voltage_V` is -inf; it has to be a finite number in every row"),
    (changed(3, "0.02,1,1"), ":5: `time_s` is 0.02 after 0.02; time has to increase from row to row"),
    (
        [HEADER, *(f"{k},1," for k in range(12))],
        ":1: `yaw_counts` holds 0 readings; give at least 10, or leave",
    ),
    ([HEADER, *(f"{k},1,{'' if k > 8 else k}" for k in range(12))], "`yaw_counts` holds 9 readings"),
    (
        [THESIS_HEADER, *THESIS_ROWS],
        ':1: the thesis layout needs [columns] position = "pos1" or "pos2" in the rig',
    ),
]


@pytest.mark.parametrize(("lines", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_malformed_log_is_refused_in_one_line(log, lines, message):
    with pytest.raises(LogError) as error:
        log(lines)
    assert "run.csv:" in str(error.value) and message in str(error.value)
    assert len(str(error.value).splitlines()) == 1


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
        ([THESIS_HEADER, *THESIS_ROWS, "0;1;2;3;;5"], WHEEL, "run.csv:14: `pwm_1` is missing"),
        ([THESIS_HEADER, *THESIS_ROWS, "0;1;2;3"], WHEEL, "run.csv:14: 4 cells; the header names 6 columns"),
    ],
)
def test_log_that_does_not_fit_the_rig(log, lines, rig, message):
    with pytest.raises(LogError) as error:
        log(lines, rig)
    assert message in str(error.value)


def test_unreadable_files(tmp_path):
    with pytest.raises(LogError, match="none.csv: cannot be read: No such file or directory"):
        read_log(tmp_path / "none.csv", PLATFORM)
    (tmp_path / "latin.csv").write_bytes(HEADER.encode() + b"\n0,1,\xb5\n")
    with pytest.raises(LogError, match="latin.csv:2: byte 0xb5 is not UTF-8"):
        read_log(tmp_path / "latin.csv", PLATFORM)


def test_several_logs(tmp_path):
    for name in ("a/run.csv", "b/run.csv", "c.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("\n".join([HEADER, *ROWS]))
    paths = [tmp_path / "a/run.csv", tmp_path / "c.csv", tmp_path / "b/run.csv"]
    assert [log.name for log in read_logs(paths, PLATFORM)] == [str(paths[0]), "c.csv", str(paths[2])]
    with pytest.raises(LogError, match="c.csv: named 2 times; name each log once"):
        read_logs([tmp_path / "c.csv", tmp_path / "a/../c.csv"], PLATFORM)


@given(
    readings=st.lists(st.floats(-1e12, 1e12) | st.just(math.nan), min_size=10, max_size=30).filter(
        lambda x: np.isfinite(x).sum() >= 10
    )
)
def test_what_is_written_reads_back_equal(tmp_path_factory, readings):
    path, t = tmp_path_factory.mktemp("log") / "run.csv", np.cumsum(np.full(len(readings), 0.1))
    write_log(
        path,
        {"time_s": t, "voltage_V": np.arange(len(t)), "yaw_rad": np.array(readings)},
        {"role": "validate"},
    )
    run = read_log(path, PLATFORM)
    assert run.validate and np.array_equal(run.time, t)
    kept = ~np.isin(t, run.left_out.get("yaw_rad", []))
    assert np.array_equal(run.outputs["yaw_rad"][kept], np.array(readings)[kept], equal_nan=True)
    assert np.isnan(run.outputs["yaw_rad"][~kept]).all()


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("old")
    with pytest.raises(ValueError):
        write_log(path, {"time_s": np.arange(3), "voltage_V": np.arange(4)})
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["run.csv"]
    with pytest.raises(LogError, match="cannot be written: there is no folder .*none; make it first"):
        write_log(tmp_path / "none" / "run.csv", {"time_s": np.arange(3)})


def test_other_notes_may_begin_with_add(log):
    assert log(["# add: weights on both ends", "# add weight at: 12:30", HEADER, *ROWS]).added == {}


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("0.03,0,1e15", "`yaw_counts` is 1e+15; no rig gives more than"),
        ("0.03,0,-1e300", "no rig gives more than 1e+12"),
    ],
)
def test_a_reading_beyond_all_rigs_is_refused(log, row, message):
    with pytest.raises(LogError, match=re.escape(message)):
        log(changed(3, row))


def test_milliseconds_are_noticed(log):
    with pytest.raises(LogError, match="a sample every 10 s; a rig needs one every 2 s at least"):
        log([HEADER, *(f"{10 * k},{k % 3},{7 * k}" for k in range(12))])


def test_what_a_run_had_more_is_read_by_name(log):
    for remark in ("# add grease: the red one", "# add: 5", "# add magnet: 2"):
        assert log([remark, HEADER, *ROWS]).added == {}
    assert log(["# add axis.inertia: 0.012", HEADER, *ROWS]).added == {"axis.inertia": 0.012}
    effect = parse_rig(
        'kind = "platform"\ndrive.gain = 1\naxis.inertia = 1\nencoder.counts_per_rev = 256\n'
        '[effects."axis.coulomb"]\nM_c = 0.1'
    )
    assert log(["# add axis.coulomb.M_c: -0.01", HEADER, *ROWS], effect).added == {"axis.coulomb.M_c": -0.01}


@pytest.mark.parametrize(
    ("note", "message"),
    [
        ("# add axis.inertia 0.05", "write it with a colon, `# add axis.inertia: 0.012`"),
        ("# add axis.inertia: -2", "makes `axis.inertia` -1 from 1"),
        ("# rle: validate", "did you mean `# role: validate`?"),
        ("# add axis.intertia: 1", "the rig file has no `axis.intertia`; the nearest is `axis.inertia`"),
        ("# add inertia: 0.01 kg m2", "the rig file has no `inertia`; the nearest is `axis.inertia`"),
        ("# add axis.inertia: much", "has to be one number, such as `# add axis.inertia: 0.012`"),
        ("# add axis.inertia: inf", "has to be one number"),
    ],
)
def test_a_difference_that_cannot_be_is_refused(log, note, message):
    with pytest.raises(LogError, match=re.escape(message)):
        log([note, HEADER, *ROWS])
