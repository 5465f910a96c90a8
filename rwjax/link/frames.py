"""Frames between host and board: COBS(type u8, seq u16, body, crc u16), then a zero byte, which stands nowhere else.

Whatever is lost or damaged, a new frame begins after the next zero. `firmware/rwbed/frame.c` does the same; tests compare
both ends.

Source: Cheshire and Baker, Consistent Overhead Byte Stuffing, IEEE/ACM Trans. Netw. 7 (1999).
"""

import struct
from binascii import crc_hqx
from collections.abc import Iterator
from typing import NamedTuple

MAX_BODY = 48
"""Bytes of the longest body."""
LONGEST = MAX_BODY + 7
"""Bytes of the longest frame on the line, the zero included."""


class Frame(NamedTuple):
    """What one frame carries.

    Attributes:
        type: Number of the command (`messages.COMMANDS`) or of the board's message (`messages.MESSAGES`).
        seq: Number of the frame, counted by its sender modulo 2^16.
        body: The message, packed.
    """

    type: int
    seq: int
    body: bytes


def crc(data: bytes) -> int:
    """Check sum CRC-16/IBM-3740, whose check value is 0x29B1.

    Args:
        data: Any bytes.

    Returns:
        The check sum, 16 bits.
    """
    return crc_hqx(data, 0xFFFF)


def _cobs_encode(plain: bytes) -> bytes:
    """COBS of fewer than 254 bytes: no zero in it, and one byte longer."""
    return b"".join(bytes([len(part) + 1]) + part for part in plain.split(b"\0"))


def _cobs_decode(wire: bytes) -> bytes | None:
    """The bytes that COBS has encoded, None where `wire` cannot be a code."""
    parts, at = [], 0
    while at < len(wire):
        end = at + wire[at]
        if wire[at] == 0 or end > len(wire):
            return None
        parts.append(wire[at + 1 : end])
        at = end
    return b"\0".join(parts)


def encode(frame: Frame) -> bytes:
    """A frame as bytes on the line.

    Args:
        frame: The frame.

    Returns:
        At most `LONGEST` bytes, the zero at the end included.
    """
    plain = struct.pack("<BH", frame.type, frame.seq) + frame.body
    return _cobs_encode(plain + struct.pack("<H", crc(plain))) + b"\0"


def decode(wire: bytes) -> Frame | None:
    """The frame that stands between two zeros.

    Args:
        wire: The bytes between the zeros.

    Returns:
        The frame, None where it is damaged.
    """
    plain = _cobs_decode(wire) if len(wire) < LONGEST else None
    if plain is None or len(plain) < 5 or crc(plain[:-2]) != int.from_bytes(plain[-2:], "little"):
        return None
    return Frame(plain[0], int.from_bytes(plain[1:3], "little"), plain[3:-2])


class Decoder:
    """Frames out of a stream of bytes that comes in pieces of any length.

    Attributes:
        damaged: How many frames could not be read so far.
    """

    def __init__(self) -> None:
        self.damaged = 0
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[Frame]:
        """Takes the next piece of the stream.

        Args:
            data: The piece.

        Yields:
            The frames that it completes.
        """
        *whole, rest = (self._rest + data).split(b"\0")
        self._rest = rest[: LONGEST + 1]  # of bytes too many for a frame, enough for `decode` to refuse them
        for wire in whole:
            frame = decode(wire)
            if frame is not None:
                yield frame
            elif wire:
                self.damaged += 1
