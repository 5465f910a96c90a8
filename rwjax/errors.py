"""The errors that rwjax raises for unusable input, what their messages may show of it, and the valid name nearest to a wrong one."""

import difflib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from inspect import signature
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

LONGEST_LINE = 1500
"""Characters of a line beyond which its middle is left out: a header of megabytes is no message."""
LONGEST_NAME = 100
"""Characters of a name that are compared with valid ones: a longer one is no slip of the pen, and takes long to compare."""


def printable(text: str) -> str:
    r"""A text in which every character that is not printed stands as its escape: `\n`, `\x1b`, `\u202e`, `\udcff`.

    Names, notes, keys and file names come from others. Printed as they are, they may end a line, colour a terminal, turn
    the direction of writing, or not be encodable at all.

    Args:
        text: Any text.

    Returns:
        The text on one line.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def printable_lines(text: str) -> str:
    """A text whose lines are printable, each for itself.

    Args:
        text: Any text.

    Returns:
        The text with as many lines.
    """
    return "\n".join(map(printable, text.split("\n")))


def one_line(text: str) -> str:
    """A text on one line that is printable and no longer than `LONGEST_LINE`; of a longer one begin and end stay.

    Args:
        text: Any text.

    Returns:
        The line.
    """
    half = LONGEST_LINE // 2
    if len(text) > LONGEST_LINE:
        text = f"{text[:half]} … {text[-half:]}"
    line = printable(text)
    return line if len(line) <= LONGEST_LINE + 3 else f"{line[:half]} … {line[-half:]}"


LONGEST_TEXT = 255
"""Characters of a name that is shown in tables, figures and notes, as long as a file's name may be."""


def no_name(text: str) -> str:
    """Why a text cannot name a rig or a run, or say in a note what a run is for.

    Args:
        text: The text as a file holds it.

    Returns:
        The reason, as the rest of a sentence; "" for a text on one line, of characters that are printed.
    """
    if len(text) > LONGEST_TEXT:
        return f"has {len(text)} characters; {LONGEST_TEXT} at most"
    if bad := next((c for c in text if not c.isprintable()), None):
        return f"holds `{printable(bad)}`, which is not printed; write it in letters, digits, signs and blanks"
    return ""


def counted(number: int, one: str, end: str = "s") -> str:
    """A number of things in words.

    Args:
        number: How many [1].
        one: The word for one of them.
        end: What the word for several has at its end.

    Returns:
        The number and the word: "1 sample", "3 samples".
    """
    return f"{number} {one}{end * (number != 1)}"


def in_two_digits(value: float) -> str:
    """A number in two digits, written out below a million: 170, and not 1.7e+02.

    Args:
        value: The number [1].

    Returns:
        The text.
    """
    return f"{float(f'{value:.2g}'):g}"


class InputError(ValueError):
    r"""The input is unusable.

    The message is one line: file, line or key, what is wrong, what would be right.

    Args:
        message: The text; what a name in it holds besides printable characters is escaped, and of a long one the middle
            is left out.
    """

    def __init__(self, message: str):
        super().__init__(one_line(message))


class RigError(InputError):
    """A rig file (TOML) that cannot be used."""


class LogError(InputError):
    """A log file (CSV), or a set of logs, that cannot be used."""


RIGHT = {
    "Rig": "has to be a rig, as `rwjax.read_rig(path)` returns it",
    "Log": "has to be a log, as `rwjax.read_log(path, rig)` returns it",
    "Logs": "has to be a list of logs: [log], or what `rwjax.read_logs(paths, rig)` returns",
    "Solver": "has to be a solver, `rwjax.Exact()` or `rwjax.Smooth()`",
}
"""What is right for an argument, by the name of its type; with an s at its end for a sequence of it."""


A_PATH = str | os.PathLike[str]
OF_PATH = "has to be a path, as a text or a `pathlib.Path`"
OF_TYPE: dict[Any, tuple[Callable[[Any], bool], str]] = {
    A_PATH: (lambda given: isinstance(given, str | os.PathLike), OF_PATH),
    Iterable[A_PATH] | A_PATH: (
        lambda given: (
            isinstance(given, str | os.PathLike)
            or (isinstance(given, Iterable) and not (isinstance(given, Mapping | bytes) or hasattr(given, "read")))
        ),
        f"{OF_PATH}, or several in a list",
    ),
    str: (lambda given: isinstance(given, str), "has to be a text"),
    "ndarray": (
        lambda given: (
            hasattr(given, "__array__") or (isinstance(given, Sequence) and not isinstance(given, str | bytes))
        ),
        "has to be an array of numbers",
    ),
    "Mapping[str, ndarray]": (lambda given: isinstance(given, Mapping), "has to be columns by name, as {name: array}"),
    Mapping[str, Any] | None: (
        lambda given: given is None or isinstance(given, Mapping),
        "has to be values by name, as {name: value}",
    ),
    Mapping[str, str] | None: (
        lambda given: given is None or isinstance(given, Mapping),
        'has to be notes by key, as {"role": "validate"}',
    ),
}
"""Whether an argument may be right, and what is right, by its type in the signature.

numpy's array goes by the name of its type, and columns of such by those of theirs: what needs no more than an error, as the command's
options do, imports no numpy for it.
"""


def refuses_other_types(function: Function) -> Function:
    """A function that refuses arguments of other types before it begins, where `RIGHT` or `OF_TYPE` says what is right.

    Args:
        function: The function; arguments without a type in its signature are not looked at.

    Returns:
        The same function, which raises `InputError` for an argument of another type.
    """
    types = {name: one.annotation for name, one in signature(function).parameters.items()}

    @wraps(function)
    def called(*arguments: Any, **named: Any) -> Any:
        given = [*zip(types, arguments, strict=False), *named.items()]
        for name, value in given:
            if wrong := _of_other_type(value, types.get(name)):
                raise InputError(f"{function.__name__}: `{name}` {wrong}")
        for name, value in given:  # what has changed places with a rig or a log is told above
            wanted = types.get(name)
            fits, right = OF_TYPE.get(wanted) or OF_TYPE.get(_in_words(wanted)) or (None, "")
            if fits and not fits(value):
                raise InputError(f"{function.__name__}: `{name}` is a `{type(value).__name__}`; it {right}")
        return function(*arguments, **named)

    return called  # pyright: ignore[reportReturnType]


def _in_words(wanted: Any) -> str:
    """The name of a type, with those of what it holds where it says so."""
    name, of = getattr(wanted, "__name__", ""), getattr(wanted, "__args__", ())
    return f"{name}[{', '.join(getattr(one, '__name__', '') for one in of)}]" if of else name


def _of_other_type(value: Any, wanted: Any) -> str:
    """What is wrong with an argument's type and what would be right; "" where it is right, or no matter of `RIGHT`."""
    many = getattr(wanted, "__origin__", None) is Sequence
    kind = wanted.__args__[0] if many else wanted
    right = RIGHT.get(getattr(kind, "__name__", "") + "s" * many)
    several = many and isinstance(value, Sequence) and not isinstance(value, str)
    other = [one for one in (value if several else (value,)) if right and not isinstance(one, kind)]
    if not right or (several == many and not other):
        return ""
    found = other[0] if other else value
    what = f"the class `{found.__name__}`" if isinstance(found, type) else f"a `{type(found).__name__}`"
    return f"{'holds' if several else 'is'} {what}; it {right}"


def nearest(name: str, valid: Iterable[str]) -> str:
    """The valid name that is spelled most like a given one.

    Args:
        name: What was given.
        valid: Names to choose from, at least one.

    Returns:
        One of `valid`, however unlike it is.
    """
    return difflib.get_close_matches(name[:LONGEST_NAME], list(valid), n=1, cutoff=0.0)[0]


def alike(name: str, valid: Iterable[str]) -> bool:
    """Whether a name is spelled so like a valid one that it may be a typing mistake.

    Args:
        name: What was given.
        valid: Names to compare it with.

    Returns:
        True from a similarity of 0.75 on (`difflib.SequenceMatcher.ratio`).
    """
    return bool(difflib.get_close_matches(name[:LONGEST_NAME], list(valid), n=1, cutoff=0.75))
