"""A session with a board: who it is, commands and their answers, a heartbeat for every few samples that come in.

Nothing here looks at a clock: waiting is counted in samples, and in reads of the port that bring nothing, each of which
lasts `READ_S`. So a simulated board and a real one are talked to alike. A line that is dead in either direction, a host
that hangs or a disk that blocks ends the heartbeats, and the board goes to neutral by itself.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Protocol, runtime_checkable

from rwjax.errors import InputError
from rwjax.link import frames
from rwjax.link.frames import Ack, Decoder, Hello, Message, Sample
from rwjax.planning.experiment import TICK_HZ

READ_S = 0.1  # s, the port's timeout
GREETINGS = 20  # a board with a bootloader takes up to 2 s
GREETING_WAIT = 5  # samples or reads in vain until the next greeting
SILENT_READS = 10  # in a row without a byte, and the board is gone
FOREIGN_BYTES = 5000  # in a row without a message in them, and it is no board: two seconds of samples
ANSWER_WAIT = 200  # samples or reads in vain
ATTEMPTS = 2  # at a command that nothing answers
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
        self._silent = 0  # reads in a row without a byte
        self._foreign = 0  # bytes in a row without a message
        self._armed_here = False
        self._theirs: int | None = None  # number of the last frame that came
        self._mine = 0
        self._since_heartbeat = 0

    @contextmanager
    def _plugged(self) -> Iterator[None]:
        """What the system says where the cable is out, in one line."""
        try:
            yield
        except OSError as error:
            said = f"{self._port.port}: the port is gone ({reason(error)}); is the cable plugged in?"
            raise LinkError(said) from None

    def read(self) -> list[Message]:
        """What has come; waits for something, `READ_S` at most. Raises `LinkError` where the board is gone."""
        with self._plugged():
            data = self._port.read(max(1, self._port.in_waiting))
        if not data:
            self._silent += 1
            if self.hello and self._silent >= SILENT_READS:
                raise LinkError(f"{self._port.port}: the board is silent for {SILENT_READS * READ_S:g} s; is it on?")
            return []
        self._silent = 0
        self._foreign += len(data)
        self._keep(data)
        messages = []
        for frame in self._decoder.feed(data):
            if self._theirs is not None:
                self.lost += (frame.seq - self._theirs - 1) % 2**16
            self._theirs = frame.seq
            if (message := frames.message(frame)) is not None:
                self._foreign = 0
                self._heed(message)
                messages.append(message)
        if self._foreign >= FOREIGN_BYTES:
            raise self._no_board()
        return messages

    def _no_board(self) -> LinkError:
        return LinkError(
            f"{self._port.port}: no board of the testbed answers; is this the port, is the firmware on it?"
        )

    def _coming(self, wait: int) -> Iterator[Message]:
        """What comes, until so many samples have come or reads have been in vain."""
        while wait > 0:
            messages = self.read()
            yield from messages
            wait -= sum(isinstance(m, Sample) for m in messages) if self._silent == 0 else 1

    def _heed(self, message: Message) -> None:
        if isinstance(message, Hello):
            if self.hello and message.nonce != self.hello.nonce:
                cause = frames.resets(message)
                raise LinkError(
                    f"{self._port.port}: the board has started anew in the middle of the session (cause: {cause})"
                )
        elif isinstance(message, Sample):
            self._watch(self, message)
            self._since_heartbeat += 1
            driven = self._armed_here and message.state in (frames.ARMING, frames.ARMED)
            if driven and self._since_heartbeat >= SAMPLES_PER_HEARTBEAT:
                self._send(frames.HEARTBEAT)

    def _write(self, data: bytes) -> None:
        with self._plugged():
            self._port.write(data)

    def _send(self, kind: int, *values: int) -> int:
        self._mine = (self._mine + 1) % 2**16
        self._since_heartbeat = 0
        self._write(frames.command(kind, self._mine, *values))
        return self._mine

    def greet(self) -> Hello:
        """Asks the board who it is until it answers."""
        self._write(b"\0")  # ends whatever an earlier host left unfinished
        for _ in range(GREETINGS):
            self._send(frames.ASK)
            for message in self._coming(GREETING_WAIT):
                if isinstance(message, Hello):
                    return self._met(message)
        raise self._no_board()

    def _met(self, hello: Hello) -> Hello:
        if hello.protocol != 1:
            raise LinkError(
                f"{self._port.port}: the firmware speaks protocol {hello.protocol}, this rwjax 1; update the older"
            )
        if hello.tick_hz != TICK_HZ:
            raise LinkError(f"{self._port.port}: the firmware ticks at {hello.tick_hz} Hz, this rwjax at {TICK_HZ} Hz")
        self.hello, self.lost = hello, 0
        if hello.heard:
            self._mine = hello.seq
        return hello

    def command(self, kind: int, *values: int, done: Callable[[Sample], bool] = lambda sample: False) -> None:
        """Sends a command and waits for its answer or for a sample that shows it `done`, and sends it once more where neither
        comes: either may be lost on the line. Raises `LinkError` if the board does not do it."""
        for _ in range(ATTEMPTS):
            number = self._send(kind, *values)
            for message in self._coming(ANSWER_WAIT):
                if isinstance(message, Sample) and done(message):
                    return
                if isinstance(message, Ack) and message.seq == number and message.command == kind:
                    if message.result and not (message.result == frames.NOT_NOW and done(self.samples()[-1])):
                        raise LinkError(f"{self._port.port}: the board refuses: {frames.RESULTS[message.result]}")
                    return
        raise LinkError(f"{self._port.port}: the board does not answer a command")

    def disarm(self) -> None:
        """Ends the pulses that drive."""
        self.command(frames.DISARM, done=lambda sample: sample.state not in (frames.ARMING, frames.ARMED))

    def samples(self) -> list[Sample]:
        """The samples of the next `read` that brings any."""
        while not (found := [m for m in self.read() if isinstance(m, Sample)]):
            pass
        return found

    def arm(self) -> None:
        """Neutral pulses until the ESCs are armed, and heartbeats from here on.

        A latched fault is a `LinkError` that says which.
        """
        hello = self.hello or self.greet()
        sample = self.samples()[-1]
        if sample.state == frames.FAULT:
            raise LinkError(f"{self._port.port}: fault: {faults(sample)}; `rwjax run-experiment --clear` clears it")
        if sample.state != frames.DISARMED:
            self.disarm()
        self._armed_here = True
        self.command(frames.ARM, hello.nonce, done=lambda sample: sample.state in (frames.ARMING, frames.ARMED))
        for message in self._coming(4 * hello.arm_ticks):
            if isinstance(message, Sample) and message.state == frames.ARMED:
                return
            if isinstance(message, Sample) and message.state == frames.FAULT:
                raise LinkError(f"{self._port.port}: the board does not arm: {faults(message)}")
        raise LinkError(f"{self._port.port}: the board does not arm")

    def leave(self) -> None:
        """Disarms if it can; a board that does not hear it goes to neutral by itself."""
        self._armed_here = False
        with suppress(Exception):  # whatever the port of a cable that is out raises: `termios.error` is no `OSError`
            self._send(frames.DISARM)
            self._port.flush()


def reason(error: Exception) -> str:
    """The system's words where there are any, pyserial's else."""
    number = getattr(error, "errno", None)
    return os.strerror(number) if number else str(error).splitlines()[0]


def faults(sample: Sample) -> str:
    """The faults of a sample in words."""
    return ", ".join(name for bit, name in frames.FAULTS.items() if sample.faults & bit) or "none"
