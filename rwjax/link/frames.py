"""Frames between host and board: COBS(type u8, seq u16, body, crc u16), then a zero byte, which stands nowhere else.

Whatever is lost or damaged, the next zero begins anew (Cheshire and Baker, IEEE/ACM Trans. Netw. 7, 1999). The same as
`firmware/rwbed/frame.c` and the bodies of `machine.c`; the tests hold both against each other.
"""

import struct
from binascii import crc_hqx
from collections.abc import Iterator
from typing import NamedTuple

from rwjax.planning.experiment import SHAPES

LONGEST = 55  # bytes on the wire, the zero included; a frame of the board is never longer
MAX_BODY = 48


class Frame(NamedTuple):
    """What one frame carries."""

    type: int
    seq: int
    body: bytes


def crc(data: bytes) -> int:
    """CRC-16/IBM-3740, check value 0x29B1."""
    return crc_hqx(data, 0xFFFF)


def stuff(plain: bytes) -> bytes:
    """COBS: no zero in it; one byte longer than `plain`, which has to be shorter than 254."""
    return b"".join(bytes([len(part) + 1]) + part for part in plain.split(b"\0"))


def unstuff(wire: bytes) -> bytes | None:
    """The plain text of `stuff`, None where this cannot be one."""
    parts, at = [], 0
    while at < len(wire):
        end = at + wire[at]
        if wire[at] == 0 or end > len(wire):
            return None
        parts.append(wire[at + 1 : end])
        at = end
    return b"\0".join(parts)


def encode(frame: Frame) -> bytes:
    """The bytes on the wire, the zero included."""
    plain = struct.pack("<BH", frame.type, frame.seq) + frame.body
    return stuff(plain + struct.pack("<H", crc(plain))) + b"\0"


def decode(wire: bytes) -> Frame | None:
    """The frame between two zeros, None where it is damaged."""
    plain = unstuff(wire) if len(wire) < LONGEST else None
    if plain is None or not 5 <= len(plain) <= MAX_BODY + 5 or crc(plain[:-2]) != int.from_bytes(plain[-2:], "little"):
        return None
    return Frame(plain[0], int.from_bytes(plain[1:3], "little"), plain[3:-2])


class Decoder:
    """Frames out of a stream of bytes, in pieces of any length; counts what was damaged."""

    def __init__(self) -> None:
        self.damaged = 0
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[Frame]:
        """The frames that `data` completes."""
        *whole, rest = (self._rest + data).split(b"\0")
        self._rest = rest[: LONGEST + 1]  # of what cannot become a frame, enough to be refused
        for wire in whole:
            frame = decode(wire)
            if frame is not None:
                yield frame
            elif wire:
                self.damaged += 1


DISARMED, ARMING, ARMED, FAULT = range(4)
STATES = ("disarmed", "arming", "armed", "fault")
FAULTS = {1: "silence of the host", 2: "over the speed limit", 4: "battery low", 8: "ticks missed"}
RESETS = {1: "power-on", 2: "the reset line", 4: "a brown-out", 8: "the watchdog"}  # bits of MCUSR
RESULTS = (
    "done",
    "unknown command",
    "wrong length",
    "stale number",
    "wrong nonce",
    "out of range",
    "not in this state",
)
NOT_NOW = RESULTS.index("not in this state")
EXPERIMENTS = tuple(SHAPES)

ASK, HEARTBEAT, ARM, DISARM, CLEAR, PULSE, HOLD, PLAY = range(1, 9)
COMMANDS = {
    ASK: struct.Struct("<"),
    HEARTBEAT: struct.Struct("<"),
    ARM: struct.Struct("<I"),  # nonce
    DISARM: struct.Struct("<"),
    CLEAR: struct.Struct("<"),
    PULSE: struct.Struct("<HH"),  # widths [half us]
    HOLD: struct.Struct("<BihhH"),  # output, reference [counts], kp, kd [half us / 256], breakaway [half us]
    PLAY: struct.Struct("<BBhhHI"),  # output, kind, amplitude, offset [half us], period, length [ticks]
}


def command(kind: int, seq: int, *values: int) -> bytes:
    """A command's bytes on the wire."""
    return encode(Frame(kind, seq, COMMANDS[kind].pack(*values)))


class Hello(NamedTuple):
    """What a board says of itself: at boot, and when asked."""

    protocol: int
    firmware: int  # hash of its sources
    nonce: int  # boots of this board so far
    reset_cause: int  # bits of `RESETS`; a bootloader may clear them
    heard: int  # whether a command was accepted since boot, the last of them numbered `seq`
    seq: int
    tick_hz: int
    counts_per_rev_1: int
    counts_per_rev_2: int
    pulse_min: int  # half us, as all pulses
    pulse_neutral: int
    pulse_max: int
    arm_ticks: int
    silence_ticks: int
    most_counts: int  # in a tick
    battery_lowest: int  # mV


def unwanted(hello: Hello) -> bool:
    """Whether a start was no one's wish: by the watchdog, or by a brown-out that no power-on, as supplies rise slowly, explains."""
    cause = hello.reset_cause
    return bool(cause & 8) or (bool(cause & 4) and not cause & 1)


def resets(hello: Hello) -> str:
    """Why a board has started, in words."""
    return ", ".join(name for bit, name in RESETS.items() if hello.reset_cause & bit) or "unknown"


class Sample(NamedTuple):
    """What a board says of one tick."""

    tick: int
    count_1: int
    count_2: int
    pulse_1: int  # half us, of the pulse that begins with this tick
    pulse_2: int
    battery: int  # mV
    state: int
    faults: int  # bits of `FAULTS`
    playing: int
    missed: int  # ticks since boot
    dropped: int  # frames for which the line had no room
    damaged: int  # frames from the host
    overruns: int  # bytes from the host


class Ack(NamedTuple):
    """A board's answer to a command."""

    seq: int
    command: int
    result: int


Message = Hello | Sample | Ack
MESSAGES = {
    0x81: (Hello, struct.Struct("<BIIBBHHHHHHHHHHH")),
    0x82: (Sample, struct.Struct("<IiiHHHBBBHHHB")),
    0x83: (Ack, struct.Struct("<HBB")),
}


def message(frame: Frame) -> Message | None:
    """What a board's frame says; None for one that this version does not know."""
    kind, body = MESSAGES.get(frame.type, (None, None))
    said = kind(*body.unpack(frame.body)) if kind and body and len(frame.body) == body.size else None
    unknown = (isinstance(said, Sample) and said.state >= len(STATES)) or (
        isinstance(said, Ack) and said.result >= len(RESULTS)
    )
    return None if unknown else said
