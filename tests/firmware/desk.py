"""The firmware's hardware-free parts, compiled for this machine: their structs and functions for ctypes."""

import ctypes
from ctypes import POINTER, c_int16, c_int32, c_uint8, c_uint16, c_uint32

import numpy as np

BODY_LONGEST, WIRE_LONGEST = 48, 55


class Frame(ctypes.Structure):
    _fields_ = (("type", c_uint8), ("length", c_uint8), ("seq", c_uint16), ("body", c_uint8 * BODY_LONGEST))


class Receiver(ctypes.Structure):
    _fields_ = (("wire", c_uint8 * WIRE_LONGEST), ("length", c_uint8))


class Law(ctypes.Structure):
    _fields_ = (("reference", c_int32), ("kp", c_int16), ("kd", c_int16), ("breakaway", c_uint16))


class Experiment(ctypes.Structure):
    _fields_ = (
        ("kind", c_uint8),
        ("amplitude", c_int16),
        ("offset", c_int16),
        ("period", c_uint16),
        ("length", c_uint32),
    )


class Readings(ctypes.Structure):
    _fields_ = (
        ("tick", c_uint32),
        ("count", c_int32 * 2),
        ("in_force", c_uint16 * 2),
        ("battery", c_uint16),
        ("missed", c_uint8),
        ("dropped", c_uint16),
        ("overruns", c_uint8),
    )


class Machine(ctypes.Structure):
    _fields_ = (
        *((name, c_uint8) for name in ("state", "faults", "mode", "output", "heard")),
        *((name, c_uint16) for name in ("seq", "waited", "silence", "low", "missed", "damaged")),
        *((name, c_uint32) for name in ("nonce", "played")),
        ("count", c_int32 * 2),
        ("moved", c_int32 * 2),
        ("width", c_uint16 * 2),
        ("law", Law),
        ("experiment", Experiment),
    )


SIGNATURES = {
    "frame_crc": ([ctypes.c_char_p, c_uint8], c_uint16),
    "frame_encode": ([POINTER(Frame), ctypes.c_char_p], c_uint8),
    "frame_receive": ([POINTER(Receiver), c_uint8, POINTER(Frame)], ctypes.c_int),
    "decode_widen": ([c_int32, c_uint16], c_int32),
    "law_width": ([POINTER(Law), c_int32, c_int32, c_int16], c_int16),
    "experiment_width": ([POINTER(Experiment), c_uint32], c_int16),
    "machine_init": ([POINTER(Machine), c_uint32], None),
    "machine_command": ([POINTER(Machine), POINTER(Frame)], c_uint8),
    "machine_tick": ([POINTER(Machine), POINTER(Readings), c_uint8], None),
    "machine_hello": ([POINTER(Machine), c_uint8, POINTER(Frame)], None),
    "machine_sample": ([POINTER(Machine), POINTER(Readings), POINTER(Frame)], None),
    "machine_ack": ([POINTER(Frame), c_uint8, POINTER(Frame)], None),
}


def load(path: object) -> ctypes.CDLL:
    """The library at `path`."""
    library = ctypes.CDLL(str(path))
    for name, (arguments, result) in SIGNATURES.items():
        function = getattr(library, name)
        function.argtypes, function.restype = arguments, result
    return library


def frame(kind: int, seq: int, body: bytes) -> Frame:
    """A frame of the firmware."""
    return Frame(kind, len(body), seq, (c_uint8 * BODY_LONGEST)(*body))


def plain(found: Frame) -> tuple[int, int, bytes]:
    """Type, number and body of a frame of the firmware."""
    return found.type, found.seq, bytes(found.body[: found.length])


class Line:
    """The firmware's receiving end: bytes in, frames out."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self.library, self.receiver, self.damaged = library, Receiver(), 0

    def feed(self, data: bytes) -> list[tuple[int, int, bytes]]:
        """Frames that `data` completes."""
        found, into = [], Frame()
        for byte in data:
            outcome = self.library.frame_receive(self.receiver, byte, into)
            if outcome == 1:
                found.append(plain(into))
            self.damaged += outcome == 2
        return found


def widths(library: ctypes.CDLL, experiment: Experiment, ticks: int) -> np.ndarray:
    """What an experiment plays in its first ticks."""
    return np.array([library.experiment_width(experiment, k) for k in range(ticks)])
