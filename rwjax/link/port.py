"""The serial port that a board hangs on, and the error of everything that can fail there."""

import errno
import os
import time
from collections.abc import Callable
from typing import Protocol, runtime_checkable

from rwjax.errors import InputError

BAUD = 250_000
READ_S = 0.1
"""How long a read waits for a byte [s], the port's timeout."""
WRITE_S = 1.0
"""How long a write may take [s]: a line that takes nothing is dead."""


@runtime_checkable
class Port(Protocol):
    """What a session needs of pyserial's ports."""

    @property
    def port(self) -> str | None:
        """Name of the port."""
        ...

    @property
    def in_waiting(self) -> int:
        """Bytes that have come and are not read yet."""
        ...

    @property
    def timeout(self) -> float | None:
        """How long a read waits [s]."""
        ...

    @timeout.setter
    def timeout(self, timeout: float | None, /) -> None: ...

    def read(self, size: int = 1, /) -> bytes:
        """Reads bytes.

        Args:
            size: How many at most.

        Returns:
            What came within the timeout.
        """
        ...

    def write(self, data: bytes, /) -> int | None:
        """Writes bytes.

        Args:
            data: The bytes.

        Returns:
            How many were taken, where the port knows.
        """
        ...

    def flush(self) -> None:
        """Waits until everything is written."""
        ...

    def close(self) -> None:
        """Closes the port."""
        ...


@runtime_checkable
class Timed(Protocol):
    """A port with a time of its own, such as that of a simulated board."""

    def clock(self) -> float:
        """The port's time.

        Returns:
            Time since any moment [s].
        """
        ...


def clock_of(port: Port) -> Callable[[], float]:
    """The clock by which a port's timeouts pass.

    Args:
        port: The port.

    Returns:
        The port's own clock where it has one, else the wall's.
    """
    return port.clock if isinstance(port, Timed) else time.monotonic


class LinkError(InputError):
    """The board, the port or the disk does not do what a recording needs."""


def open_port(url: str) -> Port:
    """Opens a serial port for this program alone.

    Args:
        url: A path such as `/dev/ttyACM0`, or a URL of pyserial.

    Returns:
        The open port.

    Raises:
        LinkError: Where it cannot be opened, is no serial port, or another program has it.
    """
    import serial  # of an extra, which only the line itself needs

    try:
        return serial.serial_for_url(url, baudrate=BAUD, exclusive=True, write_timeout=WRITE_S)
    except (serial.SerialException, ValueError) as error:
        if getattr(error, "errno", None) == errno.EWOULDBLOCK:
            raise LinkError(f"{url}: another program talks to this port; end it first") from None
        if getattr(error.__context__, "args", ())[:1] == (errno.ENOTTY,):  # termios.error, which pyserial puts in words
            raise LinkError(f"{url}: is no serial port; give one such as /dev/ttyACM0") from None
        raise LinkError(f"{url}: cannot be opened: {reason(error)}; give a serial port such as /dev/ttyACM0") from None


def reason(error: Exception) -> str:
    """Why a port failed, in one line.

    Args:
        error: What the port raised.

    Returns:
        The operating system's words where it gives any, else pyserial's.
    """
    number = getattr(error, "errno", None)
    return os.strerror(number) if number else (str(error) or type(error).__name__).splitlines()[0]
