"""What the arguments of several commands share."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.errors import InputError
from rwjax.kinds import OTHER, SUBSYSTEMS

if TYPE_CHECKING:
    import numpy as np

RigFile = Annotated[Path, typer.Argument(metavar="RIG", help="rig file (TOML)", show_default=False)]
LogFiles = Annotated[
    list[Path],
    typer.Argument(metavar="LOG…", help="log files: CSV, and others by the rig file's [columns]", show_default=False),
]
Json = Annotated[bool, typer.Option("--json", help="print the result as JSON on stdout")]
Quiet = Annotated[bool, typer.Option("--quiet", help="no progress")]
Segments = Annotated[
    float | None,
    typer.Option(
        "--segments",
        metavar="SECONDS",
        help="length of the segments in which free runs follow a log, inf for whole runs; chosen by the rig and the logs without it",
    ),
]
MOST_VALUES = 10_000  # along one axis
RATE = 2.0 * math.pi / 60.0  # rad/s per 1/min


OF_NAMES = {"diagnose": ("--only", "--without")}
"""Options that take one name or several, by the command."""


def one_name_each(arguments: Sequence[str]) -> list[str]:
    """The program's arguments, with an option that takes several names repeated before each of them.

    Args:
        arguments: what the user has typed, the command first.

    Returns:
        The same for a parser whose options take one value each. A word behind the first name is a further one where it begins as
        names do and is no file.
    """
    options, found, option = OF_NAMES.get(arguments[0], ()) if arguments else (), [], ""
    for before, word in zip(("", *arguments), arguments, strict=False):
        if word in options:
            option = word
        elif before not in options and option:
            first, dot, _ = word.partition(".")
            if dot and first in {*SUBSYSTEMS, "parameter"} and not Path(word).exists():
                found.append(option)
            else:
                option = ""
        found.append(word)
    return found


@contextmanager
def of_file(path: Path, kind: type[InputError] = InputError) -> Iterator[None]:
    """Names a file in what is wrong with what it says.

    Args:
        path: the file.
        kind: errors that are raised again with the file's name before them.

    Yields:
        Nothing.

    Raises:
        InputError: of the same `kind`, where the block raises one.
    """
    try:
        yield
    except kind as error:
        raise kind(f"{path}: {error}") from None


@contextmanager
def results(path: Path) -> Iterator[Path]:
    """A folder of logs, each of which is written for itself; made before the work begins, gone again if there are none.

    Args:
        path: the folder that the user wants.

    Yields:
        The same path.

    Raises:
        InputError: the folder cannot be made.
    """
    new = not path.exists()
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        what = "is a file, and a folder is wanted" if path.is_file() else f"cannot make this folder ({error.strerror})"
        raise InputError(f"{path}: {what}; give another with -o") from None
    try:
        yield path
    except BaseException:
        if new and not any(path.iterdir()):
            path.rmdir()
        raise


def finite(**options: float) -> None:
    """Checks that options are finite numbers, of no larger size than any quantity has.

    Args:
        options: values by the options' names [any unit].

    Raises:
        InputError: names the first that is none.
    """
    for name, value in options.items():
        if not math.isfinite(value):
            raise InputError(f"--{name} {value}: has to be a finite number")
        if abs(value) > OTHER.most:
            raise InputError(f"--{name} {value:g}: has to lie between {-OTHER.most:g} and {OTHER.most:g}")


def positive(**options: float) -> None:
    """Checks that options are positive, and of a size that a quantity has; `inf`, no limit, is.

    Args:
        options: values by the options' names [any unit].

    Raises:
        InputError: names the first that is not.
    """
    for name, value in options.items():
        if not value > 0.0:
            raise InputError(f"--{name} {value:g}: has to be positive")
        if not (OTHER.least <= value <= OTHER.most or value == math.inf):
            raise InputError(f"--{name} {value:g}: has to lie between {OTHER.least:g} and {OTHER.most:g}")


def check_segments(segments: float | None) -> None:
    """Checks the length of segments.

    Args:
        segments: the length [s], None where none was given.

    Raises:
        InputError: nothing is left of so short a segment once its start is known.
    """
    from rwjax.fitting.segments import SHORTEST_S

    if segments is not None and not segments >= SHORTEST_S:
        raise InputError(
            f"--segments {segments:g}: has to be {SHORTEST_S:g} s or more, of which the start takes half a second"
        )


def keep_input(output: Path, *inputs: Path) -> None:
    """Checks that an output does not replace an input.

    Args:
        output: file that is to be written.
        inputs: files that were read.

    Raises:
        InputError: it is one of them.
    """
    if output.exists() and any(output.samefile(path) for path in inputs if path.exists()):
        raise InputError(f"{output}: is the input; give another path with -o")


def check_file(output: Path, *inputs: Path) -> None:
    """Checks an output before the work for it begins: it can be written, and does not replace an input.

    Args:
        output: file that is to be written.
        inputs: files that are read.

    Raises:
        InputError: it is one of them, or cannot be written.
    """
    from rwjax.text_files import check_writable

    check_writable(output, InputError)
    keep_input(output, *inputs)


def axis(option: str, text: str, example: str = "0:100:101") -> "np.ndarray":
    """Equally spaced values from an option.

    Args:
        option: its name, for messages.
        text: `FROM:TO:COUNT`.
        example: what an error message shows as right.

    Returns:
        The values [unit of the option], shape `(count,)`.

    Raises:
        InputError: the text is anything else, one value is asked for between two ends, or the values are too many or too large.
    """
    import numpy as np

    wrong = InputError(f"{option} {text}: has to be FROM:TO:COUNT with 1 to {MOST_VALUES} values, such as {example}")
    try:
        first, last, number = text.split(":")
        low, high, count = float(first), float(last), int(number)
    except ValueError:
        raise wrong from None
    if not (np.isfinite([low, high]).all() and 1 <= count <= MOST_VALUES):
        raise wrong
    if count == 1 and low != high:
        raise InputError(
            f"{option} {text}: one value leaves {high:g} out; give {low:g}:{low:g}:1, or a COUNT of 2 or more"
        )
    for end in (low, high):
        finite(**{option.removeprefix("--"): end})
    return np.linspace(low, high, count)


def span(option: str, text: str) -> "np.ndarray":
    """A range of gains from an option.

    Args:
        option: its name, for messages.
        text: `FROM:TO`, from 0 or more to a larger number.

    Returns:
        Both ends [unit of the option], shape `(2,)`.

    Raises:
        InputError: the text is anything else, or the range is too large or too small.
    """
    import numpy as np

    try:
        low, high = (float(end) for end in text.split(":"))
    except ValueError:
        low, high = 0.0, 0.0
    if not 0.0 <= low < high < np.inf:
        raise InputError(f"{option} {text}: has to be FROM:TO, from 0 or more to a larger number, such as 0:100")
    positive(**{option.removeprefix("--"): high})
    return np.array([low, high])
