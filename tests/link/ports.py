"""A port whose other end is written down beforehand, frames of a board to write down, and a rig that hangs on it."""

import errno
import termios

from serial import SerialBase, SerialException

from rwjax.link import frames, messages
from rwjax.link.frames import Frame
from rwjax.link.messages import MESSAGES, Hello, Message, Sample
from rwjax.link.session import Session
from rwjax.rig.read import parse_rig

RIG = parse_rig("""
kind = "reaction"
motor = { torque_constant = 0.02, resistance = 1.0 }
wheel = { inertia = 1e-4 }
axis = { inertia = 0.05 }
drive = { pwm = { neutral_us = 1500, volts_per_us = 0.02 } }
encoder = { counts_per_rev = 2048 }
wheel_encoder = { counts_per_rev = 1024 }
""")
HELLO = Hello(1, 0xABCDEF01, 7, 1, 0, 0, 100, 2048, 2048, 2000, 3000, 4000, 100, 20, 630, 9000)
SAMPLE = Sample(0, 0, 0, 3000, 3000, 12_000, messages.DISARMED, 0, 0, 0, 0, 0, 0)
LIKE_RIG = HELLO._replace(counts_per_rev_2=1024)


def wire(said: Message, seq: int) -> bytes:
    """A board's frame."""
    kind = {Hello: 0x81, Sample: 0x82}.get(type(said), 0x83)
    return frames.encode(Frame(kind, seq % 2**16, MESSAGES[kind][1].pack(*said)))


def stream(ticks, hello: Hello = HELLO, first: int = 0) -> list[bytes]:
    """HELLO and samples at these ticks, with counts of 3 and -5 a tick; numbers are missing where ticks are."""
    said = [wire(hello, first)]
    for k, tick in enumerate(ticks):
        sample = SAMPLE._replace(tick=tick % 2**32, count_1=wrapped(3 * tick), count_2=wrapped(-5 * tick))
        said.append(wire(sample, first + 1 + tick - ticks[0] if k else first + 1))
    return said


def wrapped(value: int) -> int:
    """A count as a board's 32 bits hold it."""
    return (value + 2**31) % 2**32 - 2**31


def resting(count: int, nonce: int) -> Session:
    """A session with a board on its start number `nonce`, whose encoder 1 stands still for two seconds."""
    said = [wire(SAMPLE._replace(tick=k, count_1=wrapped(count)), k + 1) for k in range(200)]
    return Session(Scripted([wire(HELLO._replace(nonce=nonce), 0), *said]))


class Scripted(SerialBase):
    """Gives one piece a read, then does `end`: "silence", or what pyserial does at a cable that is out: "unplugged", "gone"."""

    def __init__(self, pieces: list[bytes], end: str = "silence") -> None:
        super().__init__()
        self.pieces, self.end, self.written, self.now = list(pieces), end, b"", 0.0
        self._port = "scripted"
        self.is_open = True

    def open(self) -> None:
        self.is_open = True

    def close(self) -> None:
        self.is_open = False

    def _reconfigure_port(self) -> None:
        pass

    @property
    def in_waiting(self) -> int:
        if self.end == "gone" and not self.pieces:
            raise OSError(errno.EIO, "Input/output error")
        return len(self.pieces[0]) if self.pieces else 0

    def clock(self) -> float:
        """Seconds that have passed in reads which brought nothing."""
        return self.now

    def read(self, size: int = 1) -> bytes:
        if self.pieces:
            piece = self.pieces.pop(0)
            if len(piece) > size:
                self.pieces.insert(0, piece[size:])
            return piece[:size]
        if self.end == "unplugged":
            raise SerialException("device reports readiness to read but returned no data (device disconnected?)")
        self.now += self.timeout or 0.0
        return b""

    def write(self, data: bytes) -> int:
        if self.end == "unplugged" and not self.pieces:
            raise SerialException("write failed: [Errno 5] Input/output error")
        self.written += bytes(data)
        return len(data)

    def flush(self) -> None:
        if self.end == "gone" and not self.pieces:
            raise termios.error(errno.EIO, "Input/output error")
