"""What the commands for manoeuvres without feedback share: the limits of the drive, and a line on its delay."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import RATE, finite, of_file, positive
from rwjax.errors import InputError, RigError

if TYPE_CHECKING:
    from rwjax.control.drive_limits import Limits

Amps = Annotated[float, typer.Option(help="largest current [A]")]
Degrees = Annotated[float, typer.Option("--angle", help="angle to turn [°]")]
NUMBERS = "angle", "spin", "volts", "amps", "seconds", "margin"
"""Options with which messages on numbers begin."""


def limits_of(volts: float, amps: float, rpm: float) -> "Limits":
    """The limits that the options name.

    Args:
        volts: largest command [V].
        amps: largest current [A].
        rpm: largest rate of the wheel [1/min].

    Returns:
        The same in SI units.

    Raises:
        InputError: a limit is not positive, or the volts are not finite.
    """
    from rwjax.control.drive_limits import Limits

    finite(volts=volts)
    positive(volts=volts, amps=amps, rpm=rpm)
    return Limits(volts, amps, rpm * RATE)


@contextmanager
def of_rig_or_option(rig_file: Path) -> Iterator[None]:
    """Names the rig file where the rig cannot be used, and the option where it is a number of the command.

    Args:
        rig_file: the rig's file.

    Yields:
        Nothing.

    Raises:
        InputError: as the block does, with dashes before the option that a message on a number begins with.
    """
    with of_file(rig_file, RigError):
        try:
            yield
        except InputError as error:
            raise InputError(f"--{error}") if f"{error}".partition(" ")[0] in NUMBERS else error from None


def delay_note(delay: float) -> list[str]:
    """A line on a delay of the drive.

    Args:
        delay: the delay [s], 0 where there is none.

    Returns:
        The line, or nothing.
    """
    if not delay:
        return []
    return [f"the drive's delay of {delay:g} s is in this time: what the table shows happens so much later"]
