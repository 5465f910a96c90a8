"""Boards that do only part of what they should, on a clock of their own, so that nobody has to wait for them."""

from rwjax.link import messages
from rwjax.link.frames import Decoder
from rwjax.link.messages import Ack, Hello, Message
from tests.link.ports import HELLO, SAMPLE, Scripted, wire

TICK_S, PATIENCE_S, SILENCE_S = 0.01, 200.0, 0.2


class Stubborn(Scripted):
    """A board.

    Args:
        without: what it does not do, of "greet", "acknowledge", "arm", "begin", "end", and "disarm"
        samples_every: ticks between its samples; None for none
        acks_every: ticks between answers that nobody has asked for; None for none
        hello: what it says of itself
    """

    def __init__(
        self,
        *without: str,
        samples_every: int | None = 1,
        acks_every: int | None = None,
        hello: Hello = HELLO,
    ) -> None:
        super().__init__([])
        self.without, self.every, self.hello = without, {"samples": samples_every, "acks": acks_every}, hello
        self.state, self.playing, self.tick, self.number = messages.DISARMED, False, 0, 0
        self.heard: list[tuple[float, int]] = []
        self._commands = Decoder()

    def say(self, *said: Message) -> None:
        for one in said:
            self.pieces.append(wire(one, self.number))
            self.number += 1

    def write(self, data: bytes) -> int:
        for frame in self._commands.feed(data):
            self.heard.append((self.now, frame.type))
            self.obey(frame.type)
            if frame.type != messages.ASK and "acknowledge" not in self.without:
                self.say(Ack(frame.seq, frame.type, 0))
        return len(data)

    def obey(self, kind: int) -> None:
        if kind == messages.ASK and "greet" not in self.without:
            self.say(self.hello)
        elif kind == messages.ARM and "arm" not in self.without:
            self.state = messages.ARMED
        elif kind == messages.PLAY and "begin" not in self.without:
            self.playing = True
        elif kind == messages.CLEAR:
            self.state = messages.DISARMED
        elif kind == messages.DISARM and "disarm" not in self.without:
            self.state, self.playing = messages.DISARMED, False

    def read(self, size: int = 1) -> bytes:
        if not self.pieces:
            self.pass_tick()
        return super().read(size) if self.pieces else b""

    def pass_tick(self) -> None:
        self.tick, self.now = self.tick + 1, self.now + TICK_S
        assert self.now < PATIENCE_S, "the host waits for ever"
        if self.state == messages.ARMED and self.now - self.heard[-1][0] > SILENCE_S:
            self.state, self.playing = messages.FAULT, False  # neutral, as the firmware's
        if self.playing and "end" not in self.without and self.tick % 200 == 0:
            self.playing = False
        if (every := self.every["samples"]) and self.tick % every == 0:
            fault = int(self.state == messages.FAULT)
            self.say(SAMPLE._replace(tick=self.tick, state=self.state, playing=int(self.playing), faults=fault))
        if (every := self.every["acks"]) and self.tick % every == 0:
            self.say(Ack(0, messages.HEARTBEAT, 0))
