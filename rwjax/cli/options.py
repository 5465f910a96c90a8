"""What the arguments of several commands share."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.errors import InputError

if TYPE_CHECKING:
    import numpy as np

RigFile = Annotated[Path, typer.Argument(metavar="RIG", help="rig file (TOML)", show_default=False)]
Json = Annotated[bool, typer.Option("--json", help="print the result as JSON on stdout")]
Quiet = Annotated[bool, typer.Option("--quiet", help="no progress")]
MOST = 10_000  # values along one axis
RATE = 2.0 * math.pi / 60.0  # rad/s per 1/min


@contextmanager
def of_file(path: Path, kind: type[InputError] = InputError) -> Iterator[None]:
    """Names a file in what is wrong with what it says, and raises that again as the same `kind`."""
    try:
        yield
    except kind as error:
        raise kind(f"{path}: {error}") from None


@contextmanager
def results(path: Path) -> Iterator[Path]:
    """The folder of the results, made before the work begins; gone again if there are none."""
    new = not path.exists()
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        what = "is a file, and a folder is wanted" if path.is_file() else f"cannot make this folder ({error.strerror})"
        raise InputError(f"{path}: {what}; give another with -o") from None
    try:
        yield path
    except (InputError, KeyboardInterrupt):
        if new and not any(path.iterdir()):
            path.rmdir()
        raise


def finite(**options: float) -> None:
    """Raises `InputError` for the first option that is no finite number."""
    for name, value in options.items():
        if not math.isfinite(value):
            raise InputError(f"--{name} {value}: has to be a finite number")


def positive(**options: float) -> None:
    """Raises `InputError` for the first option that is not positive."""
    for name, value in options.items():
        if not value > 0.0:
            raise InputError(f"--{name} {value:g}: has to be positive")


def keep_input(output: Path, *inputs: Path) -> None:
    """Raises `InputError` for an output that is one of the inputs."""
    if output.exists() and any(output.samefile(path) for path in inputs if path.exists()):
        raise InputError(f"{output}: is the input; give another path with -o")


def axis(option: str, text: str, example: str = "0:100:101") -> "np.ndarray":
    """The values that `FROM:TO:COUNT` stands for. Raises `InputError` for anything else."""
    import numpy as np

    wrong = InputError(f"{option} {text}: has to be FROM:TO:COUNT with 1 to {MOST} values, such as {example}")
    try:
        first, last, number = text.split(":")
        low, high, count = float(first), float(last), int(number)
    except ValueError:
        raise wrong from None
    if not (np.isfinite([low, high]).all() and 1 <= count <= MOST):
        raise wrong
    return np.linspace(low, high, count)


def span(option: str, text: str) -> "np.ndarray":
    """Both ends of `FROM:TO`, a range of gains that restore. Raises `InputError` for anything else."""
    import numpy as np

    try:
        low, high = (float(end) for end in text.split(":"))
    except ValueError:
        low, high = 0.0, 0.0
    if not 0.0 <= low < high < np.inf:
        raise InputError(f"{option} {text}: has to be FROM:TO, from 0 or more to a larger number, such as 0:100")
    return np.array([low, high])
