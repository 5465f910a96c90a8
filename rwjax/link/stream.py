"""A raw stream read: stretches of samples within which the command is known throughout.

A stream that ends anywhere, because the recorder was killed, is read up to its last whole frame.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rwjax.errors import LogError, counted
from rwjax.link.frames import Decoder
from rwjax.link.messages import Hello, Message, Sample, message, reset_causes, unwanted_reset

MOST_LOST = 10
"""Samples in a row that may be lost within one stretch, 0.1 s, where the pulses before and after are the same. Where they
differ the command between them is unknown, and the gap ends the stretch."""
MOST_LATE = 10
"""Ticks by which a sample may be older than the one before it and is passed over; one that is older yet is of another start."""
WRAP = 2**32
"""At which a board's counters begin again."""
COUNTERS = {
    "missed": ("tick", "missed"),
    "dropped": ("frame", "dropped for lack of room on the line"),
    "damaged": ("frame", "of the host damaged"),
    "overruns": ("byte", "of the host lost"),
}
"""What a board counts since its start: in words one of them, and what became of it."""


@dataclass(frozen=True)
class Stretch:
    """Samples in a row of one start of a board, `n` of them.

    Attributes:
        hello: What the board said of itself, None where that was not heard.
        tick: Number of each tick (n,), without wrap-around.
        count: Counts [1] of both encoders (n, 2), without wrap-around.
        pulse: Pulses [half us] of both outputs (n, 2).
        battery: Battery voltage [mV] (n,).
        playing: Whether an experiment was being played (n,).
        counters: What the board counted since its start (n, 4), in the order of `COUNTERS`.
    """

    hello: Hello | None
    tick: np.ndarray
    count: np.ndarray
    pulse: np.ndarray
    battery: np.ndarray
    playing: np.ndarray
    counters: np.ndarray

    def gaps(self) -> list[tuple[int, int]]:
        """The gaps that lost samples left.

        Returns:
            For every gap the index of the sample after it, and how many samples are missing.
        """
        step = np.diff(self.tick)
        return [(int(k) + 1, int(step[k]) - 1) for k in np.flatnonzero(step > 1)]

    def troubles(self) -> list[str]:
        """What went wrong on the board.

        Returns:
            In words, what it counted during the stretch, and why it had started where that was a failure.
        """
        more = (self.counters[-1] - self.counters[0]) % [2**16, 2**16, 2**16, 2**8]
        found = [
            f"{counted(n, one)} {what}" for n, (one, what) in zip(more.tolist(), COUNTERS.values(), strict=True) if n
        ]
        if self.hello is not None and unwanted_reset(self.hello):
            found.append(f"its last start was by {reset_causes(self.hello)}")
        return found

    def only(self, keep: np.ndarray) -> "Stretch":
        """Some of the samples.

        Args:
            keep: Which (n,) [true or false].

        Returns:
            The stretch without the others.
        """
        names = ("tick", "count", "pulse", "battery", "playing", "counters")
        return replace(self, **{name: getattr(self, name)[keep] for name in names})


def read_stream(path: Path) -> tuple[list[Stretch], int]:
    """The stretches of a raw stream on disk.

    Args:
        path: The file (`.raw`).

    Returns:
        The stretches, and how many frames are damaged.

    Raises:
        LogError: Where the file cannot be read.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}; give the path of a raw stream") from None
    return stretches(data)


def stretches(data: bytes) -> tuple[list[Stretch], int]:
    """The stretches of a raw stream.

    Args:
        data: The bytes that came. Those before the first zero may be half a frame and are not called damaged.

    Returns:
        The stretches, and how many frames are damaged.
    """
    said, damaged = _messages(data)
    found: list[Stretch] = []
    hello, group = None, []
    for one in said:
        if isinstance(one, Hello):
            if hello and one.nonce != hello.nonce:
                found += _stretch(hello, group)
                group = []
            hello = one
        elif isinstance(one, Sample) and not (group and _late(group[-1], one)):
            if group and not _joined(group[-1], one):
                found += _stretch(hello, group)
                group = []
            group.append(one)
    return found + _stretch(hello, group), damaged


def _messages(data: bytes) -> tuple[list[Message | None], int]:
    """The messages of all frames, None for an unknown one, and how many frames after the first zero are damaged."""
    decoder = Decoder()
    first = data.find(b"\0") + 1
    found = [message(frame) for frame in decoder.feed(data[:first])]
    decoder.damaged = 0
    found += [message(frame) for frame in decoder.feed(data[first:])]
    return found, decoder.damaged


def _late(last: Sample, said: Sample) -> bool:
    """Whether a sample is an earlier one that the line repeats or has delayed."""
    return (last.tick - said.tick) % WRAP <= MOST_LATE


def _joined(last: Sample, said: Sample) -> bool:
    """Whether the command between two samples is known."""
    step = (said.tick - last.tick) % WRAP
    return step == 1 or (1 < step <= MOST_LOST + 1 and (said.pulse_1, said.pulse_2) == (last.pulse_1, last.pulse_2))


def _unwrapped(values: Iterable[int]) -> np.ndarray:
    """Counters of 32 bits without their wrap-arounds: steps of less than 2^31 either way."""
    array = np.array(list(values), np.int64)
    steps = (np.diff(array, axis=0) + WRAP // 2) % WRAP - WRAP // 2
    return np.concatenate([array[:1], array[:1] + np.cumsum(steps, axis=0)])


def _stretch(hello: Hello | None, group: list[Sample]) -> list[Stretch]:
    """The stretch of some samples, none of none."""
    if not group:
        return []
    return [
        Stretch(
            hello,
            _unwrapped(s.tick for s in group),
            np.column_stack([_unwrapped(s.count_1 for s in group), _unwrapped(s.count_2 for s in group)]),
            np.array([(s.pulse_1, s.pulse_2) for s in group]),
            np.array([s.battery for s in group]),
            np.array([bool(s.playing) for s in group]),
            np.array([[getattr(s, name) for name in COUNTERS] for s in group]),
        )
    ]
