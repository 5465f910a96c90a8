"""pyserial's handler of `simavr://NAME`: a port whose other end is a `Bench`. Timeouts pass in simulated seconds.

`serial.serial_for_url(url(bench))` opens it.
"""

import itertools

import serial
from serial import SerialBase

from firmware.simavr.avr import F_CPU
from firmware.simavr.bench import Bench

BENCHES: dict[str, Bench] = {}
PACKAGE = __package__ or "firmware.simavr"
SLICE = F_CPU // 1000  # cycles between two looks at the line
_names = itertools.count()


def url(bench: Bench) -> str:
    """The URL under which a bench can be opened."""
    if PACKAGE not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.append(PACKAGE)
    name = f"simavr://{next(_names)}"
    BENCHES[name] = bench
    return name


class Serial(SerialBase):
    """The host's end of the line."""

    def open(self) -> None:
        self.bench = BENCHES[str(self.port)]
        self._waiting = bytearray()
        self.is_open = True

    def close(self) -> None:
        self.is_open = False

    def _reconfigure_port(self) -> None:
        pass

    @property
    def in_waiting(self) -> int:
        self._waiting += self.bench.avr.receive()
        return len(self._waiting)

    def reset_input_buffer(self) -> None:
        if self.in_waiting:
            self._waiting.clear()

    def clock(self) -> float:
        """Simulated seconds, by which a session's waits end too."""
        return self.bench.avr.cycle / F_CPU

    def read(self, size: int = 1) -> bytes:
        end = None if self.timeout is None else self.bench.avr.cycle + round(self.timeout * F_CPU)
        while self.in_waiting < size and (end is None or self.bench.avr.cycle < end):
            self.bench.run(self.bench.avr.cycle + SLICE)
        data, self._waiting = bytes(self._waiting[:size]), self._waiting[size:]
        return data

    def write(self, data: bytes) -> int:
        self.bench.avr.send(bytes(data))
        return len(data)

    def flush(self) -> None:
        pass
