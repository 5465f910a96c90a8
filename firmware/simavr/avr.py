"""The firmware in simavr: `Avr` runs an ELF cycle by cycle and looks at nothing of the wall's clock.

Needs what `missing()` names. simavr is GPL: the shim is compiled where it is used and shipped nowhere.
"""

import ctypes
import fcntl
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

import numpy as np

F_CPU = 16_000_000  # Hz
CYCLES_PER_TICK = F_CPU // 100
BAUD = 250_000
ENTRY_CYCLES = {"atmega328p": 4, "atmega2560": 5}  # of an interrupt, data sheets section "Interrupt Response Time"
PIN_A = {"atmega328p": (2, 3), "atmega2560": (0, 1)}  # of the encoders on port D; B lies two pins on
PULSE = 2**16  # most pulses, bytes, … read in one call

FIRMWARE = Path(__file__).resolve().parents[1]
BUILD = FIRMWARE.parent / "build" / "firmware"
HEADER = Path("/usr/include/simavr/sim_avr.h")
ARDUINO = Path("/usr/share/arduino/hardware/arduino/avr/cores/arduino/Arduino.h")
NEEDS = {"gcc": "gcc", "make": "make", "avr-gcc": "gcc-avr avr-libc binutils-avr"}


def missing() -> list[str]:
    """Debian packages without which the firmware cannot be compiled and run here."""
    packages = [package for program, package in NEEDS.items() if shutil.which(program) is None]
    return packages + ([] if HEADER.exists() else ["libsimavr-dev"])


def missing_for_ide() -> list[str]:
    """The same, and what it takes to compile as the Arduino IDE does."""
    return missing() + ([] if ARDUINO.exists() else ["arduino-core-avr"])


class Pulse(NamedTuple):
    """A pulse that has ended."""

    rise: int  # cycle
    cycles: int
    output: int  # 0 or 1

    @property
    def width_us(self) -> float:
        return self.cycles * 1e6 / F_CPU


@contextmanager
def _alone() -> Iterator[None]:
    """One process at a time: tests run side by side."""
    BUILD.mkdir(parents=True, exist_ok=True)
    with open(BUILD / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def build(variant: str = "", *flags: str, mcu: str = "atmega328p", by: str = "rwbed") -> Path:
    """The ELF of the sketch, compiled with `flags` unless it is there already; folders are named by `variant` and flags. `by`
    "arduino": as the Arduino IDE compiles it, its core beside it."""
    folder = BUILD / f"{variant}-{crc32(' '.join(flags).encode()):08x}" if flags else BUILD
    target = folder / f"{by}-{mcu}.elf"
    command = ["make", "-s", "-C", FIRMWARE, f"BUILD={folder}", f"FLAGS={' '.join(flags)}", target]
    with _alone():
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return target


def desk() -> Path:
    """The hardware-free parts as a shared library of this machine."""
    with _alone():
        subprocess.run(["make", "-s", "-C", FIRMWARE, f"BUILD={BUILD}", BUILD / "desk.so"], check=True)
    return BUILD / "desk.so"


@cache
def _shim() -> ctypes.CDLL:
    source, target = Path(__file__).with_name("shim.c"), BUILD / "shim.so"
    options = ["-O2", "-Wall", "-Wextra", "-shared", "-fPIC"]
    with _alone():
        if not target.exists() or target.stat().st_mtime < source.stat().st_mtime:
            subprocess.run(["gcc", *options, "-o", target, source, "-lsimavr"], check=True)
    c = ctypes.CDLL(str(target))
    u8, u32, u64, size, pointer = ctypes.c_uint8, ctypes.c_uint32, ctypes.c_uint64, ctypes.c_size_t, ctypes.c_void_p

    def array(kind: type) -> type:
        return np.ctypeslib.ndpointer(kind, flags="C")

    signatures = {
        "sim_new": ([ctypes.c_char_p, ctypes.c_char_p, u32, u32, u32], pointer),
        "sim_free": ([pointer], None),
        "sim_cycle": ([pointer], u64),
        "sim_resets": ([pointer], ctypes.c_int),
        "sim_data": ([pointer, u32], u8),
        "sim_watch_entries": ([pointer, ctypes.c_int], None),
        "sim_adc": ([pointer, u32, u32], None),
        "sim_edges": ([pointer, size, array(np.uint64), array(np.uint8), array(np.uint8)], None),
        "sim_send": ([pointer, size, ctypes.c_char_p], None),
        "sim_run": ([pointer, u64], ctypes.c_int),
        "sim_receive": ([pointer, size, array(np.uint8), array(np.uint64)], size),
        "sim_pulses": ([pointer, size, array(np.uint64), array(np.uint32), array(np.uint8)], size),
        "sim_entries": ([pointer, size, array(np.uint64), array(np.uint64), array(np.uint8)], size),
    }
    for name, (arguments, result) in signatures.items():
        getattr(c, name).argtypes, getattr(c, name).restype = arguments, result
    return c


class Avr:
    """A board. Times are cycles since power-on; `run` advances it, everything else looks or hands in."""

    def __init__(self, elf: Path, mcu: str = "atmega328p", battery_mV: float = 12_000.0, baud: int = BAUD) -> None:
        self._c, self.mcu = _shim(), mcu
        self._sim = self._c.sim_new(str(elf).encode(), mcu.encode(), F_CPU, ENTRY_CYCLES[mcu], baud)
        if not self._sim:
            raise RuntimeError(f"{elf}: simavr cannot run this on an {mcu}")
        self._bytes, self._at = np.zeros(PULSE, np.uint8), np.zeros(PULSE, np.uint64)
        self._more, self._long = np.zeros(PULSE, np.uint64), np.zeros(PULSE, np.uint32)
        self.battery(battery_mV)

    def __del__(self) -> None:
        if getattr(self, "_sim", None):
            self._c.sim_free(self._sim)

    @property
    def cycle(self) -> int:
        return self._c.sim_cycle(self._sim)

    @property
    def resets(self) -> int:
        return self._c.sim_resets(self._sim)

    def data(self, address: int) -> int:
        """One byte of the data space: a register, or RAM."""
        return self._c.sim_data(self._sim, address)

    def battery(self, millivolts: float) -> None:
        """Voltage of the battery, behind the divider 18:5."""
        self._c.sim_adc(self._sim, 0, round(millivolts * 5.0 / 18.0))

    def edges(self, cycle: np.ndarray, pin: np.ndarray, level: np.ndarray) -> None:
        """Levels of pins of port D from these cycles on, in order of time."""
        self._c.sim_edges(
            self._sim,
            len(cycle),
            np.ascontiguousarray(cycle, np.uint64),
            np.ascontiguousarray(pin, np.uint8),
            np.ascontiguousarray(level, np.uint8),
        )

    def send(self, data: bytes) -> None:
        """Bytes from the host, one after the other at the line's rate."""
        self._c.sim_send(self._sim, len(data), data)

    def run(self, until: int) -> None:
        if state := self._c.sim_run(self._sim, until):
            raise RuntimeError(f"the firmware has stopped in state {state} at cycle {self.cycle}")

    def receive(self) -> bytes:
        """Bytes that the board has sent since the last call."""
        return self.receive_stamped()[0]

    def receive_stamped(self) -> tuple[bytes, np.ndarray]:
        """The same, and the cycle at which each byte left."""
        n = self._c.sim_receive(self._sim, PULSE, self._bytes, self._at)
        return self._bytes[:n].tobytes(), self._at[:n].copy()

    def pulses(self) -> list[Pulse]:
        """Pulses that have ended since the last call."""
        n = self._c.sim_pulses(self._sim, PULSE, self._at, self._long, self._bytes)
        return [Pulse(*map(int, row)) for row in zip(self._at[:n], self._long[:n], self._bytes[:n], strict=True)]

    def watch_interrupts(self) -> None:
        """From now on `interrupts` has something to tell."""
        self._c.sim_watch_entries(self._sim, 1)

    def interrupts(self) -> np.ndarray:
        """Rows (cycle of entry, cycle of return, vector) since the last call."""
        n = self._c.sim_entries(self._sim, PULSE, self._at, self._more, self._bytes)
        return np.column_stack([self._at[:n], self._more[:n], self._bytes[:n]]).astype(np.int64)


if __name__ == "__main__":
    sys.exit(f"needs the Debian packages {' '.join(packages)}" if (packages := missing_for_ide()) else 0)
