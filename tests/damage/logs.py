"""Logs damaged where they stand as lines: notes, header, cells, the order of rows, whole columns."""

from hypothesis import strategies as st

from tests.damage.values import LONG, LONGEST, numbers, spoilt, texts

NOTES = (
    *(
        "role: validate",
        "role: test",
        "role validate",
        "Role: TRAIN",
        "validate: 1",
        "x: validate",
        "add axis.inertia: 1e308",
    ),
    *("add axis.inertia: -9", "add axis.inertia: nan", "add inertia: 1", "add axis.mass: 1", "add drive.gain: -0.428"),
    *("add axis.inertia: 1e-320", "add axis.friction.viscous: -6", "add motor.resistance: -0.83", "ignore: time_s"),
    *(
        "ignore: voltage_V",
        "ignore: yaw_counts, supply_V",
        "ignore: nothing",
        "ignore: ;;",
        "add wheel.inertia: 0.1; 0.2",
    ),
)
NAMES = (
    *(
        "time_s",
        "voltage_V",
        "yaw_counts",
        "yaw_rad",
        "wheel_rad_s",
        "wheel_counts",
        "current_A",
        "supply_V",
        "position_m",
    ),
    *("temperature_C", "yaw_rpm", "Time_s", "", "pitch_rad", "voltage_1_V", "time"),
)
FACTORS = (
    "0",
    "-1",
    "10",
    "0.1",
    "1e3",
    "1e-3",
    "1e6",
    "1e12",
    "1e100",
    "1e-100",
    "1e298",
    "1e-298",
    "1e306",
    "1e-306",
    "57.3",
)
CELLS = ("", " ", "x", "1,5", "0x10", "1e3e3", "--", "NaN", "TRUE", "1_0", "١", "1d3")


@st.composite
def _cell(draw: st.DrawFn) -> str:
    """What stands in one cell."""
    which = draw(st.integers(0, 9))
    return draw(numbers()) if which < 6 else draw(st.sampled_from(CELLS)) if which < 9 else draw(texts())


def _scaled(cell: str, factor: float) -> str:
    try:
        return repr(float(cell) * factor)
    except ValueError:
        return cell


@st.composite
def _column(draw: st.DrawFn, rows: list[list[str]]) -> list[list[str]]:
    """The rows after a change of a whole column."""
    j = draw(st.integers(0, len(rows[0]) - 1))
    way = draw(st.integers(0, 5))
    if way <= 2:
        factor = float(draw(st.sampled_from(FACTORS)))
        column = [_scaled(row[j], factor) if j < len(row) else "" for row in rows]
    elif way == 3:
        column = [draw(_cell())] * len(rows)
    elif way == 4:
        column = list(reversed([row[j] if j < len(row) else "" for row in rows]))
    else:
        every = draw(st.sampled_from((2, 3, 7, 59)))
        with_ = draw(_cell())
        column = [with_ if k % every else row[j] if j < len(row) else "" for k, row in enumerate(rows)]
    return [[*row[:j], cell, *row[j + 1 :]] for row, cell in zip(rows, column, strict=True)]


@st.composite
def _rows(draw: st.DrawFn, rows: list[list[str]]) -> list[list[str]]:
    """The rows after a change of some."""
    way, k = draw(st.integers(0, 9)), draw(st.integers(0, len(rows) - 1))
    if way <= 3:
        j = draw(st.integers(0, len(rows[k]) - 1))
        return [*rows[:k], [*rows[k][:j], draw(_cell()), *rows[k][j + 1 :]], *rows[k + 1 :]]
    if way == 4:
        return rows[: draw(st.sampled_from((0, 1, 2, 9, 10, 11, 30)))]
    if way == 5:
        return [*rows[:k], rows[k], *rows[k:]]
    if way == 6:
        return [*rows[:k], [*rows[k], draw(_cell())], *rows[k + 1 :]]
    if way == 7:
        return [*rows[:k], rows[k][:-1], *rows[k + 1 :]]
    if way == 8:  # a gap in the time
        by = draw(st.sampled_from((0.5, 1e2, 1e4, 1e6, 1e9, 1e12, 1e15, 1e300)))
        return [*rows[:k], *([_scaled(row[0], 1.0 + by) if row else "", *row[1:]] for row in rows[k:])]
    return [*rows[:k], [draw(texts())], *rows[k:]]


@st.composite
def damaged(draw: st.DrawFn, whole: str, *, vast: bool = False) -> bytes:
    """A log after one to three changes, of notes, header, rows, columns or bytes; `vast`: very seldom one of 10 MB."""
    lines = whole.splitlines()
    head = next(k for k, line in enumerate(lines) if not line.startswith("#"))
    notes, sign = lines[:head], ";" if ";" in lines[head] else ","
    header, rows = lines[head].split(sign), [line.split(sign) for line in lines[head + 1 :]]
    for _ in range(draw(st.sampled_from((1, 1, 1, 2, 3)))):
        way = draw(st.integers(0, 9))
        if way <= 3 and rows and rows[0]:
            rows = draw(_column(rows))
        elif way <= 6 and rows and all(rows):
            rows = draw(_rows(rows))
        elif way == 7:
            notes = [
                *notes,
                "# " + (draw(st.sampled_from(NOTES)) if draw(st.booleans()) else f"{draw(texts())}: {draw(texts())}"),
            ]
        elif way == 8:
            j = draw(st.integers(0, len(header)))
            header = [*header[:j], draw(st.sampled_from(NAMES) | texts()), *header[j + draw(st.integers(0, 1)) :]]
        else:
            sign = draw(st.sampled_from((",", ";", "\t", " ", "|")))
    if draw(st.integers(0, 399)) == 0:
        header = [*header, *(f"c{k}" for k in range(LONG // 4))]
    if vast and draw(st.integers(0, 1999)) == 0:
        header = ["x" * LONGEST, *header[1:]]
    text = "\n".join([*notes, sign.join(header), *(sign.join(row) for row in rows), ""])
    plain = text.encode("utf-8", "surrogatepass")
    return draw(spoilt(plain)) if draw(st.integers(0, 7)) == 0 else plain
