"""What may stand where a number or a text is wanted, and bytes that a disk, an editor or a line has damaged."""

from hypothesis import strategies as st

NUMBERS = (
    *(
        "0",
        "-0.0",
        "1",
        "-1",
        "-5",
        "-12",
        "0.5",
        "2",
        "3.7",
        "1e3",
        "-1e3",
        "1e-3",
        "1e6",
        "-1e6",
        "1e-6",
        "1e-9",
        "1e9",
    ),
    *("1e12", "-1e12", "1e-12", "1e-15", "1e-20", "1e20", "1e-150", "1e150", "1e155", "-1e155", "1e-155", "1e300"),
    *(
        "-1e300",
        "1e-300",
        "-1e-300",
        "1e307",
        "1e308",
        "-1e308",
        "1.7976931348623157e308",
        "1e-308",
        "2.2e-308",
        "5e-324",
    ),
    *("-5e-324", "1e-310", "1e400", "-1e400", "1e-400", "9007199254740993", "18446744073709551616", "1" + "0" * 19),
)
"""Numbers as text, from those a rig may have to those no double holds."""
ENDLESS = ("9" * 400, "-" + "9" * 400, "1" + "0" * 308, "0." + "0" * 400 + "1")
NOT_FINITE = ("nan", "inf", "-inf", "+inf", "-nan")
TEXTS = (
    *(
        "",
        " ",
        "a",
        "x\ny",
        "x\r\ny",
        "# role: validate",
        "a\nrole: validate",
        "a\nadd axis.inertia: 9",
        "\n# add axis.inertia: 9",
    ),
    *(
        "\x1b[31mred\x1b[0m",
        "\x1b]0;title\x07",
        "\x1b[2J",
        "bell\x07",
        "back\b\b",
        "del\x7f",
        "c1\x9b31m",
        "nul\x00",
        "\u2028x",
    ),
    *(
        "[/]",
        "[red]",
        "[bold",
        "$\\foo$",
        "$x_",
        "\\frac{",
        "%s %d {0} {x}",
        "<script>",
        "&amp;<b>",
        "a,b;c\td",
        '"',
        "'",
        "\\",
    ),
    *(
        "\u202egnitset\u202c",
        "\u200f\u200e",
        "e\u0301",
        "\U0001f600",
        "\ud800",
        "\udcff",
        "\ufeff",
        "../x",
        "/etc/x",
        "a/b",
    ),
    *("-o", "--json", "con.txt.", "x" * 300, "näme", "имя", "名前", "\x85line", "\x0bx\x0cy"),
)
"""Texts that mean something to a terminal, to markup, to mathtext, to HTML, to CSV, to a log's notes or to a file system."""
LONG = 20_000
"""Characters of a long text; the longest of all has `LONGEST`."""
LONGEST = 10_000_000
ENCODINGS = ("utf-16", "utf-16-le", "utf-32", "latin-1", "cp1252", "utf-8-sig", "cp500")


@st.composite
def numbers(draw: st.DrawFn) -> str:
    """A number as text, seldom one that is none."""
    which = draw(st.integers(0, 9))
    if which < 6:
        return draw(st.sampled_from(NUMBERS))
    if which == 6:
        return draw(st.sampled_from(NOT_FINITE))
    if which == 7:
        return draw(st.sampled_from(ENDLESS))
    return repr(draw(st.floats(allow_nan=False, allow_infinity=False)))


@st.composite
def texts(draw: st.DrawFn) -> str:
    """A text, seldom a long one."""
    which = draw(st.integers(0, 39))
    if which < 30:
        return draw(st.sampled_from(TEXTS))
    if which < 39:
        return draw(st.text(max_size=12))
    return draw(st.sampled_from(TEXTS)) * (LONG // 10)


@st.composite
def spoilt(draw: st.DrawFn, whole: bytes) -> bytes:
    """A file of which some bytes are damaged."""
    way = draw(st.integers(0, 9))
    at = draw(st.integers(0, max(len(whole) - 1, 0)))
    if way <= 1:
        return whole[:at] + bytes([draw(st.integers(0, 255))]) + whole[at + 1 :]
    if way == 2:
        return whole[:at]
    if way == 3:
        return whole[at:]
    if way == 4:
        return whole[:at] + draw(st.binary(min_size=1, max_size=8)) + whole[at:]
    if way == 5:
        return whole[:at] + b"\0" * draw(st.sampled_from((1, 2, 512))) + whole[at:]
    if way == 6:
        return whole.replace(b"\n", draw(st.sampled_from((b"\r\n", b"\r", b"\n\n", b"\x0b", b"\xe2\x80\xa8"))))
    if way == 7:
        return whole.decode("utf-8", "replace").encode(draw(st.sampled_from(ENCODINGS)), "replace")
    if way == 8:
        end = draw(st.integers(at, len(whole)))
        return whole[:end] + whole[at:end] + whole[end:]
    return draw(
        st.sampled_from((b"", b"\n", b"\0", b"\xef\xbb\xbf", b"\xff\xfe", b"# role: validate\n", b"PK\x03\x04"))
    )
