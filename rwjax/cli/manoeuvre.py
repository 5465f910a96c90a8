"""What the commands for manoeuvres without feedback share: the limits of the drive, and a line on its delay."""

from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import RATE, finite, positive

if TYPE_CHECKING:
    from rwjax.control.drive_limits import Limits

Amps = Annotated[float, typer.Option(help="largest current [A]")]
Degrees = Annotated[float, typer.Option("--angle", help="angle to turn [°]")]


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
