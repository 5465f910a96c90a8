"""A session with a board: greeting, commands and their answers, and a heartbeat for every few samples that come in.

Every wait ends. It is counted in samples, the board's own time, and where they come too slowly the clock ends it. The clock
is the wall's, or the port's own where that has one: a simulated board may be faster or slower than the real one. After an end
there are no more heartbeats. A line that is dead in either direction, a host that hangs or a disk that blocks ends them, too,
and the board goes to neutral by itself.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Thread

from rwjax.link import messages
from rwjax.link.frames import Decoder, Frame
from rwjax.link.messages import Ack, Hello, Message, Sample
from rwjax.link.port import READ_S, LinkError, Port, clock_of
from rwjax.planning.experiment import TICK_HZ

GREETINGS = 10
"""How often a board is asked who it is: one with a bootloader takes up to 2 s."""
GREETING_WAIT = 10
"""Ticks until it is asked again."""
SILENCE_S = 1.0
"""Time [s] without a sample after which the board is gone."""
FOREIGN_BYTES = 5000
"""Bytes in a row without a message after which it is no board: two seconds of samples."""
ANSWER_WAIT = 200
"""Ticks within which a command has to be answered."""
SLOWEST, SLACK_S = 2.0, 1.0
"""By the clock a wait ends after so many times what its ticks take, and so many seconds more."""
LONGEST_PAUSE_S = 5 * READ_S
"""What counts at most of the time between two reads: a host that was suspended says nothing of the board."""
FLUSH_S = 1.0
"""How long the last bytes may take to leave."""
ATTEMPTS = 2
"""How often a command is sent that nothing answers."""
SAMPLES_PER_HEARTBEAT = 5
"""50 ms; the board waits for 200 ms."""


class Session:
    """Talks to a board.

    Args:
        port: The port that the board hangs on.
        keep: Takes every byte that comes, before anything else is done with it.
        watch: Takes the session and every sample that comes.
        stop: Whether the session is to end at the next read, as by Ctrl-C.

    Attributes:
        hello: What the board said of itself, None before the greeting.
        lost: Frames of the board that did not arrive whole.
        sent: Kinds of the commands that went out, or were on their way when the port was gone.
    """

    def __init__(
        self,
        port: Port,
        keep: Callable[[bytes], None] = lambda data: None,
        watch: Callable[["Session", Sample], None] = lambda session, sample: None,
        stop: Callable[[], bool] = lambda: False,
    ) -> None:
        port.timeout = READ_S
        self.hello: Hello | None = None
        self.lost = 0
        self.sent: set[int] = set()
        self._port, self._keep, self._watch, self._stop = port, keep, watch, stop
        self._decoder = Decoder()
        self._clock = clock_of(port)
        self._read_at = self._clock()
        self._time = 0.0  # since the session began, long pauses left out
        self._byte_at = self._sample_at = 0.0  # by `_time`
        self._foreign_bytes = 0  # in a row
        self._armed_here = False
        self._last_frame: Frame | None = None
        self._last_received: int | None = None  # number of the latest frame that came
        self._last_sent = 0
        self._since_heartbeat = 0

    @contextmanager
    def _plugged(self) -> Iterator[None]:
        """Turns what the system says where the cable is out into one plain line; that is its cause."""
        try:
            yield
        except OSError as error:
            raise LinkError(f"{self._port.port}: the port is gone; is the cable plugged in?") from error

    def read(self) -> list[Message]:
        """Takes what has come, and waits for something, `READ_S` at most.

        Returns:
            The messages, in their order; none where nothing came.

        Raises:
            LinkError: Where the port is gone, the board has started anew, or is no board of the testbed.
            KeyboardInterrupt: Where the session is to end.
        """
        if self._stop():
            raise KeyboardInterrupt
        with self._plugged():
            data = self._port.read(max(1, self._port.in_waiting))
        now = self._clock()
        self._time += min(now - self._read_at, LONGEST_PAUSE_S)
        self._read_at = now
        if not data:
            return []
        self._byte_at = self._time
        self._foreign_bytes += len(data)
        self._keep(data)
        found = []
        for frame in self._decoder.feed(data):
            if frame == self._last_frame:
                continue  # its sender counts: the line has repeated it
            self._last_frame = frame
            self._count_lost(frame.seq)
            if (message := messages.message(frame)) is not None:
                self._foreign_bytes = 0
                self._heed(message)
                found.append(message)
        if self._foreign_bytes >= FOREIGN_BYTES:
            raise self._no_board()
        return found

    def _count_lost(self, number: int) -> None:
        """Counts the frames that are missing before this one, none before one that comes late."""
        step = 1 if self._last_received is None else (number - self._last_received) % 2**16
        if 0 < step < 2**15:
            self.lost += step - 1
            self._last_received = number

    def _no_board(self) -> LinkError:
        return LinkError(
            f"{self._port.port}: no board of the testbed answers; is this the port, is the firmware on it?"
        )

    def _read_of_a_board_that_samples(self) -> list[Message]:
        """As `read`; `LinkError` where the samples have ended."""
        found = self.read()
        if self._time - self._sample_at < SILENCE_S:
            return found
        if self._time - self._byte_at < SILENCE_S:
            raise LinkError(f"{self._port.port}: the board answers and has sent no sample for {SILENCE_S:g} s")
        raise LinkError(f"{self._port.port}: the board is silent for {SILENCE_S:g} s; is it on?")

    def coming(self, ticks: int) -> Iterator[Message]:
        """What comes within a time of the board.

        Args:
            ticks: That time; a sample comes with each tick. Where fewer come, the clock ends the wait.

        Yields:
            The messages, in their order.

        Raises:
            LinkError: Where the board is gone, sends no samples, has started anew, or is no board of the testbed.
        """
        yield from self._until(ticks, self._read_of_a_board_that_samples)

    def _until(self, ticks: int, read: Callable[[], list[Message]]) -> Iterator[Message]:
        """What `read` brings, for so many samples, and no longer than they may take."""
        end = self._time + SLOWEST * ticks / TICK_HZ + SLACK_S
        while ticks > 0 and self._time < end:
            found = read()
            yield from found
            ticks -= sum(isinstance(message, Sample) for message in found)

    def _heed(self, message: Message) -> None:
        """Passes samples on, sends heartbeats, and notices a board that has started anew."""
        if isinstance(message, Hello):
            if self.hello and message.nonce != self.hello.nonce:
                cause = messages.reset_causes(message)
                raise LinkError(
                    f"{self._port.port}: the board has started anew in the middle of the session (cause: {cause})"
                )
        elif isinstance(message, Sample):
            self._sample_at = self._time
            self._watch(self, message)
            self._since_heartbeat += 1
            driven = self._armed_here and message.state in (messages.ARMING, messages.ARMED)
            if driven and self._since_heartbeat >= SAMPLES_PER_HEARTBEAT:
                self.send(messages.HEARTBEAT)

    def _write(self, data: bytes) -> None:
        with self._plugged():
            self._port.write(data)

    def send(self, kind: int, *values: int) -> int:
        """Sends a command and does not wait for its answer.

        Args:
            kind: One of `messages.COMMANDS`.
            *values: What its body holds, in the order and the units given there.

        Returns:
            Number of the frame, which the answer names.

        Raises:
            LinkError: Where the port is gone.
        """
        self._last_sent = (self._last_sent + 1) % 2**16
        self._since_heartbeat = 0
        self.sent.add(kind)
        self._write(messages.command(kind, self._last_sent, *values))
        return self._last_sent

    def greet(self) -> Hello:
        """Asks the board who it is until it answers.

        Returns:
            What the board says of itself.

        Raises:
            LinkError: Where none answers, or one with another protocol or tick.
        """
        self._write(b"\0")  # ends whatever an earlier host left unfinished
        for _ in range(GREETINGS):
            self.send(messages.ASK)
            for message in self._until(GREETING_WAIT, self.read):
                if isinstance(message, Hello):
                    return self._met(message)
        raise self._no_board()

    def _met(self, hello: Hello) -> Hello:
        """Takes over what the board says of itself; `LinkError` where it speaks otherwise."""
        if hello.protocol != 1:
            raise LinkError(
                f"{self._port.port}: the firmware speaks protocol {hello.protocol}, this rwjax 1; update the older"
            )
        if hello.tick_hz != TICK_HZ:
            raise LinkError(f"{self._port.port}: the firmware ticks at {hello.tick_hz} Hz, this rwjax at {TICK_HZ} Hz")
        self.hello, self.lost, self._sample_at = hello, 0, self._time
        if hello.heard:
            self._last_sent = hello.seq
        return hello

    def command(self, kind: int, *values: int, done: Callable[[Sample], bool] = lambda sample: False) -> None:
        """Sends a command and waits until the board has done it.

        It is sent once more where neither an answer comes nor a sample that shows it done: either may be lost on the line.

        Args:
            kind: One of `messages.COMMANDS`.
            *values: What its body holds, in the order and the units given there.
            done: Whether a sample shows that the command is done.

        Raises:
            LinkError: If the board refuses it or does not answer.
        """
        for _ in range(ATTEMPTS):
            number = self.send(kind, *values)
            for message in self.coming(ANSWER_WAIT):
                if isinstance(message, Sample) and done(message):
                    return
                if isinstance(message, Ack) and message.seq == number and message.command == kind:
                    if message.result and not (message.result == messages.NOT_NOW and done(self.samples()[-1])):
                        raise LinkError(f"{self._port.port}: the board refuses: {messages.RESULTS[message.result]}")
                    return
        raise LinkError(f"{self._port.port}: the board does not answer a command")

    def disarm(self) -> None:
        """Ends the pulses that drive.

        Raises:
            LinkError: If the board does not answer.
        """
        self.command(messages.DISARM, done=lambda sample: sample.state not in (messages.ARMING, messages.ARMED))

    def samples(self) -> list[Sample]:
        """The samples of the next read that brings any.

        Returns:
            At least one sample.

        Raises:
            LinkError: Where the board is gone, sends no samples, has started anew, or is no board of the testbed.
        """
        while not (found := [m for m in self._read_of_a_board_that_samples() if isinstance(m, Sample)]):
            pass
        return found

    def arm(self) -> None:
        """Arms the board, with neutral pulses until the ESCs are ready, and sends heartbeats from here on.

        Raises:
            LinkError: Where a latched fault, which the message names, or a silent board keeps it from arming.
        """
        hello = self.hello or self.greet()
        sample = self.samples()[-1]
        if sample.state == messages.FAULT:
            raise LinkError(f"{self._port.port}: fault: {faults(sample)}; `rwjax run-experiment --clear` clears it")
        if sample.state != messages.DISARMED:
            self.disarm()
        self._armed_here = True
        self.command(messages.ARM, hello.nonce, done=lambda sample: sample.state in (messages.ARMING, messages.ARMED))
        for message in self.coming(4 * hello.arm_ticks):
            if isinstance(message, Sample) and message.state == messages.ARMED:
                return
            if isinstance(message, Sample) and message.state == messages.FAULT:
                raise LinkError(f"{self._port.port}: the board does not arm: {faults(message)}")
        raise LinkError(f"{self._port.port}: the board does not arm")

    def leave(self) -> None:
        """Disarms the board if it can; a board that does not hear it goes to neutral by itself."""
        self._armed_here = False
        with suppress(Exception):
            self.send(messages.DISARM)
            flushing = Thread(target=self._flush, daemon=True)  # the system waits for ever where nothing leaves
            flushing.start()
            flushing.join(FLUSH_S)

    def _flush(self) -> None:
        with suppress(Exception):  # whatever the port of a cable that is out raises: `termios.error` is no `OSError`
            self._port.flush()


def faults(sample: Sample) -> str:
    """The faults of a sample in words.

    Args:
        sample: Any sample.

    Returns:
        The faults, "none" where there is none.
    """
    return ", ".join(name for bit, name in messages.FAULTS.items() if sample.faults & bit) or "none"
