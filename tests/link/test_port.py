"""The serial port: one program's alone, and what is said where it cannot be opened."""

import errno
import os
import time
import tty
from contextlib import closing
from pathlib import Path

import pytest
import serial

from rwjax.link import port
from rwjax.link.port import LinkError, clock_of, open_port, reason
from rwjax.link.session import Session
from tests.link.ports import Scripted


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


@pytest.mark.parametrize("name", ["/dev/null", "notes.txt"])
def test_what_is_no_serial_port_is_called_so(name: str, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("no port\n")
    with pytest.raises(LinkError, match="is no serial port; give one such as /dev/ttyACM0"):
        open_port(str(tmp_path / name))  # /dev/null stays as it is


def test_the_reason_is_the_systems_where_it_gives_one() -> None:
    assert reason(OSError(errno.EIO, "whatever pyserial makes of it")) == "Input/output error"
    assert reason(serial.SerialException("device disconnected?\nmore")) == "device disconnected?"
    assert reason(serial.SerialException()) == "SerialException"


def test_a_line_that_takes_nothing_is_dead(monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal takes some kilobytes that nobody reads, and then lets the writer wait."""
    monkeypatch.setattr(port, "WRITE_S", 0.05)
    master, slave = os.openpty()
    tty.setraw(slave)
    with closing(open_port(os.ttyname(slave))) as line:
        session = Session(line)
        with pytest.raises(LinkError, match="the port is gone"):
            for _ in range(10_000):
                session.send(1)
    os.close(master)
    os.close(slave)


def test_a_port_may_have_a_time_of_its_own() -> None:
    simulated = Scripted([])
    simulated.now = 7.0
    assert clock_of(simulated)() == 7.0 and clock_of(serial.serial_for_url("loop://")) is time.monotonic
