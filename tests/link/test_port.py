"""The serial port: one program's alone, and what is said where it cannot be opened."""

import errno
import os
from contextlib import closing

import pytest
import serial

from rwjax.link.port import LinkError, open_port, reason


def test_a_port_belongs_to_one_program() -> None:
    master, slave = os.openpty()
    with closing(open_port(os.ttyname(slave))):
        with pytest.raises(LinkError, match="another program talks to this port; end it first"):
            open_port(os.ttyname(slave))
    os.close(master)
    os.close(slave)


def test_a_port_that_is_not_there() -> None:
    with pytest.raises(
        LinkError, match="/dev/ttyNOPE: cannot be opened: No such file or directory; give a serial port"
    ):
        open_port("/dev/ttyNOPE")
    assert issubclass(serial.SerialException, OSError)


def test_the_reason_is_the_systems_where_it_gives_one() -> None:
    assert reason(OSError(errno.EIO, "whatever pyserial makes of it")) == "Input/output error"
    assert reason(serial.SerialException("device disconnected?\nmore")) == "device disconnected?"
