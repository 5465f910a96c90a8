"""A host in simulated time: commands, heartbeats, and what the board says. For tests and tables; users have `rwjax.link`."""

import hashlib
from itertools import pairwise

from firmware.simavr.avr import CYCLES_PER_TICK
from firmware.simavr.bench import Bench
from rwjax.link import messages
from rwjax.link.frames import Decoder
from rwjax.link.messages import Ack, Hello, Sample, command, message


class Host:
    """Talks to the board of a bench; keeps everything that it says."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.samples: list[Sample] = []
        self.acks: list[Ack] = []
        self.hellos: list[Hello] = []
        self.numbers: list[int] = []  # of all frames
        self.decoder, self.digest = Decoder(), hashlib.sha256()
        self._seq = 0

    @property
    def latest(self) -> Sample:
        return self.samples[-1]

    @property
    def gaps(self) -> int:
        """Frames that did not arrive."""
        return sum((b - a - 1) % 2**16 for a, b in pairwise(self.numbers))

    def listen(self) -> None:
        """Takes what has come by now."""
        data, cycles = self.bench.avr.receive_stamped()
        self.digest.update(data + cycles.tobytes())
        for frame in self.decoder.feed(data):
            self.numbers.append(frame.seq)
            said = message(frame)
            if isinstance(said, Sample):
                self.samples.append(said)
            elif isinstance(said, Ack):
                self.acks.append(said)
            elif isinstance(said, Hello):
                self.hellos.append(said)

    def send(self, kind: int, *values: int) -> None:
        """A command, without waiting for its answer."""
        self._seq += 1
        self.bench.avr.send(command(kind, self._seq % 2**16, *values))

    def run(self, ticks: int, beat: int = 5) -> None:
        """So many ticks, with a heartbeat every `beat` of them (0: none)."""
        for k in range(ticks):
            if beat and k % beat == 0:
                self.send(messages.HEARTBEAT)
            self.bench.run(self.bench.avr.cycle + CYCLES_PER_TICK)
            self.listen()

    def arm(self) -> None:
        """From power-on to armed."""
        self.run(3, beat=0)
        self.send(messages.ARM, self.hellos[-1].nonce)
        self.run(105)
        assert self.latest.state == messages.ARMED, self.acks
