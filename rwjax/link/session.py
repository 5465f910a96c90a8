"""A session with a board: who it is, commands and their answers, a heartbeat for every few samples that come in.

Nothing here looks at a clock: waiting is counted in reads of the port, each of which lasts `READ_S` at most. So a
simulated board and a real one are talked to alike. A line that is dead in either direction, a host that hangs or a disk
that blocks ends the heartbeats, and the board goes to neutral by itself.
"""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from serial import SerialException

from rwjax.errors import InputError
from rwjax.link import frames
from rwjax.link.frames import Ack, Decoder, Hello, Message, Sample

READ_S = 0.1  # s, the port's timeout
GREETING_READS = 100  # a board with a bootloader takes up to 2 s
SILENT_READS = 10  # in a row without a byte, and the board is gone
ANSWER_READS = 200  # of one sample or more each
SAMPLES_PER_HEARTBEAT = 5  # 50 ms; the board waits for 200 ms


@runtime_checkable
class Port(Protocol):
    """What is needed of pyserial's ports."""

    @property
    def port(self) -> str | None: ...

    @property
    def in_waiting(self) -> int: ...

    @property
    def timeout(self) -> float | None: ...

    @timeout.setter
    def timeout(self, timeout: float | None, /) -> None: ...

    def read(self, size: int = 1, /) -> bytes: ...

    def write(self, data: bytes, /) -> int | None: ...

    def flush(self) -> None: ...

    def close(self) -> None: ...


class LinkError(InputError):
    """The board, the port or the disk does not do what a recording needs."""


class Session:
    """Talks to the board at `port`. Every byte goes to `keep` before anything else is done with it."""

    def __init__(
        self,
        port: Port,
        keep: Callable[[bytes], None] = lambda data: None,
        watch: Callable[["Session", Sample], None] = lambda session, sample: None,
    ) -> None:
        port.timeout = READ_S
        self.hello: Hello | None = None
        self.lost = 0  # frames of the board that did not arrive whole
        self._port, self._keep, self._watch = port, keep, watch
        self._decoder = Decoder()
        self._silent = 0
        self._theirs: int | None = None  # number of the last frame that came
        self._mine = 0
        self._since_heartbeat = 0

    def read(self) -> list[Message]:
        """What has come; waits for something, `READ_S` at most. Raises `LinkError` where the board is gone."""
        data = self._port.read(max(1, self._port.in_waiting))
        if not data:
            self._silent += 1
            if self.hello and self._silent >= SILENT_READS:
                raise LinkError(f"{self._port.port}: the board is silent for {SILENT_READS * READ_S:g} s; is it on?")
            return []
        self._silent = 0
        self._keep(data)
        messages = []
        for frame in self._decoder.feed(data):
            if self._theirs is not None:
                self.lost += (frame.seq - self._theirs - 1) % 2**16
            self._theirs = frame.seq
            if (message := frames.message(frame)) is not None:
                self._heed(message)
                messages.append(message)
        return messages

    def _heed(self, message: Message) -> None:
        if isinstance(message, Hello):
            if self.hello and message.nonce != self.hello.nonce:
                raise LinkError(f"{self._port.port}: the board has started anew in the middle of the session")
        elif isinstance(message, Sample):
            self._watch(self, message)
            self._since_heartbeat += 1
            if message.state in (frames.ARMING, frames.ARMED) and self._since_heartbeat >= SAMPLES_PER_HEARTBEAT:
                self._send(frames.HEARTBEAT)

    def _send(self, kind: int, *values: int) -> int:
        self._mine = (self._mine + 1) % 2**16
        self._since_heartbeat = 0
        self._port.write(frames.command(kind, self._mine, *values))
        return self._mine

    def greet(self) -> Hello:
        """Asks the board who it is until it answers."""
        self._port.write(b"\0")  # ends whatever an earlier host left unfinished
        for attempt in range(GREETING_READS):
            if attempt % 5 == 0:
                self._send(frames.ASK)
            for message in self.read():
                if isinstance(message, Hello):
                    return self._met(message)
        raise LinkError(f"{self._port.port}: no board of the testbed answers; is this the port, is the firmware on it?")

    def _met(self, hello: Hello) -> Hello:
        if hello.protocol != 1:
            raise LinkError(
                f"{self._port.port}: the firmware speaks protocol {hello.protocol}, this rwjax 1; update the older"
            )
        self.hello, self.lost = hello, 0
        if hello.heard:
            self._mine = hello.seq
        return hello

    def command(self, kind: int, *values: int) -> None:
        """Sends a command and waits for its answer; raises `LinkError` if the board does not do it."""
        number = self._send(kind, *values)
        for _ in range(ANSWER_READS):
            for message in self.read():
                if isinstance(message, Ack) and message.seq == number and message.command == kind:
                    if message.result:
                        raise LinkError(f"{self._port.port}: the board refuses: {frames.RESULTS[message.result]}")
                    return
        raise LinkError(f"{self._port.port}: the board does not answer a command")

    def samples(self) -> list[Sample]:
        """The samples of the next `read` that brings any."""
        while not (found := [m for m in self.read() if isinstance(m, Sample)]):
            pass
        return found

    def arm(self) -> None:
        """Neutral pulses until the ESCs are armed. A latched fault is a `LinkError` that says which."""
        hello = self.hello or self.greet()
        sample = self.samples()[-1]
        if sample.state == frames.FAULT:
            raise LinkError(f"{self._port.port}: fault: {faults(sample)}; `rwjax run-experiment --clear` clears it")
        if sample.state != frames.DISARMED:
            self.command(frames.DISARM)
        self.command(frames.ARM, hello.nonce)
        for _ in range(4 * hello.arm_ticks):
            state = self.samples()[-1].state
            if state == frames.ARMED:
                return
            if state == frames.FAULT:
                break
        raise LinkError(f"{self._port.port}: the board does not arm")

    def leave(self) -> None:
        """Disarms if it can; a board that does not hear it goes to neutral by itself."""
        try:
            self._send(frames.DISARM)
            self._port.flush()
        except (OSError, SerialException):
            pass


def faults(sample: Sample) -> str:
    """The faults of a sample in words."""
    return ", ".join(name for bit, name in frames.FAULTS.items() if sample.faults & bit) or "none"
