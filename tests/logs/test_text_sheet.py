"""A log file as text: notes, header, rows, whatever separates them, and which line is wrong."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.logs.read_sheet import read_sheet
from rwjax.logs.sheet import Sheet
from tests.logs.texts import HEADER, ROWS, THESIS_HEADER, THESIS_ROWS, WHEEL, changed

two = "time_s,voltage_V"
MALFORMED = [
    ([""], "holds no header and no samples"),
    (["# a: b"], "holds no header and no samples"),
    (ROWS, ":1: no header; the first row has to name the columns"),
    ([HEADER], ":1: 0 samples below the header; a log needs at least 10"),
    ([HEADER, *ROWS[:9]], ":1: 9 samples below the header"),
    (
        [HEADER.replace(",", ";"), *ROWS],
        ":2: 1 cell; the header names 3 columns, separated by semicolons",
    ),
    ([HEADER.replace(",", "\t"), *ROWS], ":2: 1 cell; the header names 3 columns, separated by tabs"),
    (["# role validate", HEADER, *ROWS], ":1: `# role validate` is no note; write `# role: validate`"),
    ([",".join(f"c{k}" for k in range(1001)), *ROWS], ":1: 1001 columns; a log has 1000 at most, `time_s,voltage_V,…`"),
    (changed(3, "0.03,1"), ":5: 2 cells; the header names 3 columns"),
    (changed(3, ""), ":5: 1 cell; the header names 3 columns"),
    ([HEADER, *ROWS, "0.12,1"], ":14: 2 cells; the header names 3 columns; the last line is cut short: delete it"),
    *(
        (
            [HEADER, *ROWS, f"0.12,1,{cut}"],
            f":14: `yaw_counts` is '{cut}'; it has to be a number; where the last line was cut short, delete it",
        )
        for cut in ("-", "1e", "-1.5E-", ".")
    ),
    (
        ["time_s;voltage_V;yaw_counts", *(row.replace(",", ";") for row in ROWS), "0.12;1;1,234"],
        ":14: `yaw_counts` is '1,234'; it has to be a number, and beside decimal points a comma is none",
    ),
    (changed(3, "0.03,1,-"), ":5: `yaw_counts` is '-'; it has to be a number, or empty where a reading is missing"),
    (
        [HEADER, *ROWS, "0.12,1,x"],
        ":14: `yaw_counts` is 'x'; it has to be a number, or empty where a reading is missing",
    ),
    (changed(3, "0.03,1,2,3"), ":5: 4 cells; the header names 3 columns"),
    ([HEADER, *(row.replace(".", ",") for row in ROWS[1:])], "3 columns; decimals have a point, 0.01, not 0,01"),
    (changed(3, "0:03,1,1"), "it has to be a number of seconds, or a date written as 2024-05-01 12:00:00.010"),
    *(
        ([HEADER, *ROWS, *between, again, *ROWS], f":{14 + len(between)}: the header again, as of a logger that was")
        for between, again in (
            ([], HEADER),
            ([""], HEADER),
            (["", "# role: validate"], HEADER),
            (["# load: 1, 2, 3"], HEADER),
            ([], f"\ufeff{HEADER}"),
            (["\ufeff# role: validate"], HEADER),
            ([], HEADER.replace(",", ", ")),
            ([], ",".join(f'"{name}"' for name in HEADER.split(","))),
        )
    ),
    (changed(3, "# a: b"), ":5: a note among the samples; notes go before the header"),
    (
        changed(3, "0.03,1,1O"),
        ":5: `yaw_counts` is '1O'; it has to be a number, or empty where a reading is missing",
    ),
    (changed(3, "nan,1,1"), ":5: `time_s` is missing; it has to be a finite number in every row"),
    (changed(3, "0.03,,1"), ":5: `voltage_V` is missing; it has to be a finite number in every row"),
    (changed(3, "0.03,-inf,1"), ":5: `voltage_V` is -inf; it has to be a finite number in every row"),
]


@pytest.mark.parametrize(("lines", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_a_malformed_file_is_refused_in_one_line(refused, lines: list[str], message: str) -> None:
    refused(lines, message)


def test_notes_header_and_rows_are_told_apart(tmp_path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(
        "\n".join(["# Rig: yaw: testbed", "", "# no colon", "# rig: again", HEADER.replace(",", " , "), *ROWS])
    )
    sheet = read_sheet(path)
    assert sheet.notes == {"rig": "yaw: testbed; again"} and sheet.header == 5 and sheet.delimiter == ","
    assert sheet.names == HEADER.split(",") and sheet.rows == ROWS
    assert str(sheet.error(2, "wrong")) == f"{path}:8: wrong" and str(sheet.error(None, "wrong")) == f"{path}:5: wrong"


def test_both_ways_of_reading_rows_give_the_same_numbers(tmp_path) -> None:
    """Row by row where a cell is empty, all at once where none is."""
    whole, holey = tmp_path / "whole.csv", tmp_path / "holey.csv"
    rows = [f"{k / 7!r},{k},{k * math.pi!r}" for k in range(12)]
    whole.write_text("\n".join([HEADER, *rows]))
    holey.write_text("\n".join([HEADER, *rows[:5], "0,,", *rows[6:]]))
    a, b = (np.array(read_sheet(path).numbers(["yaw_counts", "time_s"])) for path in (whole, holey))
    assert np.isnan(b[0, 5]) and b[1, 5] == 0.0
    assert np.array_equal(np.delete(a, 5, axis=1), np.delete(b, 5, axis=1)) and a[0, 3] == 3 * math.pi


def test_ten_samples_are_enough_and_a_thousand_columns_not_too_many(tmp_path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("\n".join([",".join(f"c{k}" for k in range(1000)), *[",".join(["1"] * 1000)] * 10]))
    (found,) = read_sheet(path).numbers(["c999"])
    assert np.array_equal(found, np.ones(10))


@pytest.mark.parametrize(
    ("lines", "comma"),
    [
        ([HEADER, *(row.replace(".", ",") for row in ROWS[1:])], True),
        (changed(3, "0.03,1,2,3"), False),
        ([HEADER, *(f"{row}," for row in ROWS)], False),
        (changed(3, "0.03,1"), False),
    ],
)
def test_rows_of_too_many_cells_may_hold_decimal_commas_and_one_row_does_not(
    log, lines: list[str], comma: bool
) -> None:
    with pytest.raises(LogError) as error:
        log(lines)
    assert ("decimals have a point" in str(error.value)) == comma


def test_a_blank_cell_is_missing_and_a_wrong_one_is_named(tmp_path, refused) -> None:
    path = tmp_path / "blank.csv"
    path.write_text("\n".join([HEADER, *ROWS[:11], "0.11, ,"]))
    volts, counts = read_sheet(path).numbers(["voltage_V", "yaw_counts"])
    assert np.flatnonzero(np.isnan(volts)).tolist() == np.flatnonzero(np.isnan(counts)).tolist() == [11]
    refused(changed(3, "0.03,,x"), ":5: `yaw_counts` is 'x'; it has to be a number")


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([THESIS_HEADER, *THESIS_ROWS, "0;1;2;3;;5"], "run.csv:14: `pwm_1` is missing"),
        (
            [THESIS_HEADER, *THESIS_ROWS, "0;1;2;3"],
            "run.csv:14: 4 cells; the header names 6 columns, separated by semicolons; the last line is",
        ),
    ],
)
def test_a_row_of_the_thesis_that_cannot_be_read_is_named(refused, lines, message) -> None:
    refused(lines, message, WHEEL)


@pytest.mark.parametrize(
    ("note", "message"),
    [
        ("# add axis.inertia 0.05", "write it with a colon, `# add axis.inertia: 0.012`"),
        ("# rle: validate", "did you mean `# role: validate`?"),
    ],
)
def test_a_note_that_is_written_otherwise_is_refused(log, note, message) -> None:
    with pytest.raises(LogError, match=re.escape(message)):
        log([note, HEADER, *ROWS])


def test_a_line_of_megabytes_makes_a_short_message(tmp_path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("\n".join([HEADER, *ROWS, "0.3,1," + 1_000_000 * "1" + "x"]))
    with pytest.raises(LogError, match=":14: `yaw_counts` is '1111") as error:
        read_sheet(path).numbers(["yaw_counts"])
    assert len(str(error.value)) < 2000


def test_notes_of_one_key_are_joined(tmp_path) -> None:
    (tmp_path / "run.csv").write_text("\n".join(["# a: 1", "# A: 2", "# a: 3", HEADER, *ROWS]))
    assert read_sheet(tmp_path / "run.csv").notes == {"a": "1; 2; 3"}


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ('0.03;"1";2', ""),
        ('0.03;"1;2', ":5: "),
        ("0.03;1,5;2", ""),
        ("0.03;1.000,5;2", ":5: `voltage_V` is '1.000,5'; it has to be a number"),
    ],
)
def test_quotes_and_decimal_commas_are_read_or_named(log, row: str, message: str) -> None:
    lines = [line.replace(",", ";") for line in changed(3, row.replace(";", "\0"))]
    lines[4] = row
    whole = (
        [line if k == 4 else line.replace(".", ",") for k, line in enumerate(lines)] if row == "0.03;1,5;2" else lines
    )
    whole[4] = whole[4].replace("0.03", "0,03") if row == "0.03;1,5;2" else whole[4]
    if not message:
        assert log(whole).command[3] == (1.5 if "," in row else 1.0)
    else:
        with pytest.raises(LogError, match=re.escape(message)):
            log(whole)


def test_a_comma_of_thousands_is_no_decimal_one_where_another_column_has_points(log) -> None:
    rows = [f'{k / 100},1,"{k + 990:,}"' for k in range(12)]
    with pytest.raises(LogError, match=re.escape(":12: `yaw_counts` is '1,000'; it has to be a number, and beside")):
        log([HEADER, *rows])


def test_the_last_row_may_lack_a_reading_between_tabs(log) -> None:
    rows = [row.replace(",", "\t") for row in ROWS]
    run = log([HEADER.replace(",", "\t"), *rows[:-1], rows[-1].rpartition("\t")[0] + "\t", "", "\t"])
    assert len(run.time) == len(ROWS) and np.isnan(run.outputs["yaw_rad"][-1])


def test_a_blank_of_another_kind_in_a_columns_name_is_a_blank(tmp_path) -> None:
    (tmp_path / "run.csv").write_text("Zeit\xa0[s],u\u2009[V]\n" + "\n".join(["0,1"] * 12))
    assert [*read_sheet(tmp_path / "run.csv").names] == ["Zeit [s]", "u [V]"]


@pytest.mark.parametrize(
    ("note", "notes"), [("## Device: ESP32", {"device": "ESP32"}), ("# : x", {}), ("# a\tb: c", {"a\\tb": "c"})]
)
def test_every_note_that_is_read_can_be_written(log, note: str, notes: dict[str, str]) -> None:
    assert log([note, HEADER, *ROWS]).notes == notes


def test_only_a_last_line_of_too_few_cells_is_cut_short(log) -> None:
    for lines in (changed(3, "0.03,1"), changed(11, "0.11,1,1,1")):
        with pytest.raises(LogError) as error:
            log(lines)
        assert "cut short" not in str(error.value)


def sheet_of(path: Path, times: Sequence[str], separator: str = ",", volts: str = "1.5") -> Sheet:
    """A text file of a column `when` and a column `volts`."""
    path /= "run.csv"
    path.write_text("\n".join(separator.join(row) for row in [("when", "volts"), *((time, volts) for time in times)]))
    return read_sheet(path)


@pytest.mark.parametrize(
    ("date", "separator", "volts"),
    [
        ("2024-05-01 12:00:{:06.3f}", ",", "1.5"),
        ("2024-05-01T12:00:{:06.3f}Z", ",", "1.5"),
        ("2024-05-01 12:00:{:06.3f}+0200", ";", "1,5"),
        ("2024-05-01 12:00:{:06.3f}", ";", "1,5"),
    ],
)
@pytest.mark.parametrize("point", [".", ","])
def test_dates_are_seconds_from_the_first_whatever_their_decimals(tmp_path, date, separator, volts, point) -> None:
    if separator == point:
        separator, volts = "\t", "1.5"
    dates = [date.format(50 + 0.01 * k).replace(".", point) for k in range(12)]
    when, held = sheet_of(tmp_path, ["", *dates], separator, volts).numbers(["when", "volts"], ["when"])
    assert np.isnan(when[0]) and np.array_equal(when[1:], np.arange(12) / 100) and (held == 1.5).all()


def test_each_date_counts_by_its_own_time_zone(tmp_path) -> None:
    dates = [f"2024-05-01 12:00:{k:02d}+02:00" for k in range(10)] + ["2024-05-01T11:00:10+01", "2024-05-01 10:01Z"]
    (when,) = sheet_of(tmp_path, dates).numbers(["when"], ["when"])
    assert when.tolist() == [*range(11), 60.0]


@pytest.mark.parametrize(
    ("row", "cell", "message"),
    [
        (3, "later", "it has to be a date like the first, '2024-05-01 12:00:00.00', all with a time zone or all"),
        (3, "20240501", "it has to be a date like the first"),
        (3, "0.03", "it has to be a date like the first"),
        (3, "2024W181", "it has to be a date like the first"),
        (3, "2024-05-01 12:00:00.03+02:00", "it has to be a date like the first"),
        (3, "2024-13-01 12:00", "it has to be a date like the first"),
        (0, "2024-13-01 12:00", "it has to be a number of seconds, or a date written as 2024-05-01 12:00:00.010"),
        (0, "2024W181", "it has to be a number, or empty"),
    ],
)
def test_a_column_that_begins_with_a_date_holds_nothing_else(refused, row: int, cell: str, message: str) -> None:
    dates = [f"2024-05-01 12:00:00.{k:02d}" for k in range(12)]
    dates[row] = cell
    refused(
        [HEADER, *(f"{date},1,{k}" for k, date in enumerate(dates))], f":{row + 2}: `time_s` is '{cell}'; {message}"
    )


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("2024-05-01 12:00,1,1", ":5: `time_s` is '2024-05-01 12:00'; it has to be a number like the first, '0.0'"),
        (
            "0.03,2024-05-01 12:00,1",
            "`voltage_V` is '2024-05-01 12:00'; it has to be a number: dates are read as `time_s`",
        ),
        ("0.03,1,12:30:10", "`yaw_counts` is '12:30:10'; it has to be a number, or empty where a reading is missing"),
    ],
)
def test_dates_and_clocks_among_numbers_are_refused(refused, row: str, message: str) -> None:
    refused(changed(3, row), message)


def test_only_time_is_read_by_dates(refused) -> None:
    rows = [f"{k / 100},2024-05-01 12:00:00.{k:02d},{k}" for k in range(12)]
    refused([HEADER, *rows], ":2: `voltage_V` is '2024-05-01 12:00:00.00'; it has to be a number: dates are read as")
    rows = [f"0;0;2024-05-01 12:00:00.{k:02d};0;1500;0" for k in range(12)]
    refused([THESIS_HEADER, *rows], ":2: `pos2` is '2024-05-01 12:00:00.00'; it has to be a number: dates", WHEEL)


def test_a_decimal_comma_makes_no_date(tmp_path) -> None:
    when, _ = sheet_of(tmp_path, [f"20240501,{k:02d}" for k in range(12)], ";").numbers(["when", "when"], ["when"])
    assert when == pytest.approx(20240501 + np.arange(12) / 100, abs=1e-8)


def test_a_number_is_no_date(refused) -> None:
    refused([HEADER, "20240501,1,x", *ROWS], ":2: `yaw_counts` is 'x'")
