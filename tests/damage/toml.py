"""TOML files damaged where they stand as lines: values, keys, headers, the order of lines."""

from hypothesis import strategies as st

from tests.damage.values import LONG, LONGEST, numbers, spoilt, texts

OTHER = (
    "true",
    "false",
    "[]",
    "{}",
    "[1, 2]",
    "[[1]]",
    "{ a = 1 }",
    "{ a = { b = {} } }",
    "1979-05-27",
    "07:32:00",
    "0x10",
    "1_000",
)
DEEP = ("[" * 3000 + "]" * 3000, "{ a = " * 900 + "1" + " }" * 900, "[" * 90 + "1" + "]" * 90)


FACTORS = (-1.0, 0.5, 1.1, 2.0, 4.0, 10.0, 0.1, 30.0, 1e-3, 1e3)


def _times(value: str, factor: float) -> str:
    """A number as text times a factor, twice a text that is none."""
    try:
        return repr(float(value) * factor)
    except ValueError:
        return value * 2


def quoted(text: str) -> str:
    """A text in quotes, escaped as TOML wants it; what TOML cannot hold stands as it is."""
    plain = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c >= " " and c != "\x7f" else f"\\u{ord(c):04x}" for c in plain) + '"'


@st.composite
def _value(draw: st.DrawFn, before: str) -> str:
    """What stands behind `=` instead of `before`; of a list mostly one entry changes."""
    before = before.partition("#")[0].strip()
    which = draw(st.integers(0, 19))
    if before.startswith("[") and before.endswith("]") and which < 14:
        entries = [entry.strip() for entry in before[1:-1].split(",") if entry.strip()]
        at = draw(st.integers(0, len(entries)))
        entry = draw(_value(entries[at])) if at < len(entries) else draw(numbers())
        return "[" + ", ".join([*entries[:at], entry, *entries[at + draw(st.integers(0, 1)) :]]) + "]"
    if which < 7:
        return _times(before, draw(st.sampled_from(FACTORS)))
    if which < 13:
        return draw(numbers())
    if which < 16:
        return quoted(draw(texts()))
    if which < 19:
        return draw(st.sampled_from(OTHER))
    return draw(st.sampled_from(DEEP))


@st.composite
def _key(draw: st.DrawFn, before: str) -> str:
    """What stands before `=` instead of `before`."""
    which = draw(st.integers(0, 4))
    plain = before.strip().strip('"')
    if which == 0:
        at = draw(st.integers(0, len(plain)))
        return quoted(plain[:at] + draw(st.sampled_from("abxyz_.-")) + plain[at + 1 :])
    if which == 1:
        return quoted(plain + draw(texts()))
    if which == 2:
        return quoted(draw(texts()))
    if which == 3:
        return ".".join("a" for _ in range(draw(st.sampled_from((2, 30, 900)))))
    return before.strip() + ".x"


@st.composite
def _changed(draw: st.DrawFn, lines: list[str], values: st.SearchStrategy[str] | None = None) -> list[str]:
    """The lines after one change."""
    way = draw(st.integers(0, 19))
    pairs = [k for k, line in enumerate(lines) if "=" in line]
    if way < 12 and pairs:
        k = draw(st.sampled_from(pairs))
        key, _, value = lines[k].partition("=")
        return [*lines[:k], f"{key}= {draw(_value(value))}", *lines[k + 1 :]]
    if not lines:
        return [draw(texts())]
    k = draw(st.integers(0, len(lines) - 1))
    if way == 12:
        return [*lines[:k], *lines[k + 1 :]]
    if way == 13:
        at = draw(st.integers(0, len(lines)))
        return [*lines[:at], lines[k], *lines[at:]]
    if way <= 15 and pairs:
        k = draw(st.sampled_from(pairs))
        key, _, value = lines[k].partition("=")
        return [*lines[:k], f"{draw(_key(key))} ={value}", *lines[k + 1 :]]
    if way == 16:
        return [*lines[:k], f"{quoted(draw(texts()))} = {draw(numbers())}", *lines[k:]]
    if way == 17:
        return [*lines[:k], f"[{draw(st.sampled_from(('fit', 'axis', 'effects', 'motor.x', 'a.b.c')))}]", *lines[k:]]
    if way == 18:
        return [*lines[:k], f"[effects.{quoted(draw(texts()))}]", *lines[k:]]
    return [*lines[:k], draw(texts()), *lines[k:]]


@st.composite
def damaged(draw: st.DrawFn, whole: str, *, vast: bool = False) -> bytes:
    """A TOML file after one to three changes, of lines or of bytes; `vast`: very seldom one of 10 MB."""
    lines = whole.splitlines()
    for _ in range(draw(st.sampled_from((1, 1, 1, 2, 3)))):
        lines = draw(_changed(lines))
    if draw(st.integers(0, 399)) == 0:
        lines += [f"k{n} = 1" for n in range(draw(st.sampled_from((1000, LONG))) if vast else 1000)]
    if vast and draw(st.integers(0, 1999)) == 0:
        lines.append(f'{"x" * LONGEST} = "{draw(texts())}"')
    plain = "\n".join([*lines, ""]).encode("utf-8", "surrogatepass")  # surrogates become bytes that are no UTF-8
    return draw(spoilt(plain)) if draw(st.integers(0, 7)) == 0 else plain
