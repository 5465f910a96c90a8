"""What frames between host and board say: the host's commands, the board's messages, and their numbers in words.

The bodies are those of `firmware/rwbed/machine.c`; tests compare both ends.
"""

import struct
from typing import NamedTuple

from rwjax.link.frames import Frame, encode
from rwjax.planning.experiment import SHAPES

DISARMED, ARMING, ARMED, FAULT = range(4)
STATES = ("disarmed", "arming", "armed", "fault")
"""States of a board, by number."""
FAULTS = {1: "silence of the host", 2: "over the speed limit", 4: "battery low", 8: "ticks missed"}
"""Faults in words, by bit of `Sample.faults`."""
RESETS = {1: "power-on", 2: "the reset line", 4: "a brown-out", 8: "the watchdog"}
"""Causes of a board's start in words, by bit of its register MCUSR."""
RESULTS = (
    "done",
    "unknown command",
    "wrong length",
    "stale number",
    "wrong nonce",
    "out of range",
    "not in this state",
)
"""A board's answers to a command in words, by number."""
NOT_NOW = RESULTS.index("not in this state")
EXPERIMENTS = tuple(SHAPES)
"""Kinds of experiments, by the number that PLAY carries."""

ASK, HEARTBEAT, ARM, DISARM, CLEAR, PULSE, HOLD, PLAY = range(1, 9)
COMMANDS = {
    ASK: struct.Struct("<"),
    HEARTBEAT: struct.Struct("<"),
    ARM: struct.Struct("<I"),  # nonce
    DISARM: struct.Struct("<"),
    CLEAR: struct.Struct("<"),
    PULSE: struct.Struct("<HH"),  # widths [half us]
    HOLD: struct.Struct("<BihhH"),  # output, reference [counts], kp, kd [half us / 256], breakaway [half us]
    PLAY: struct.Struct("<BBhhHI"),  # output, kind, amplitude, offset [half us], period, length [ticks]
}
"""Commands of the host, by frame type: what their bodies hold."""


def command(kind: int, seq: int, *values: int) -> bytes:
    """A command as bytes on the line.

    Args:
        kind: One of `COMMANDS`.
        seq: Number of the frame, modulo 2^16.
        *values: What its body holds, in the order and the units of `COMMANDS`.

    Returns:
        The bytes, the zero at the end included.
    """
    return encode(Frame(kind, seq, COMMANDS[kind].pack(*values)))


class Hello(NamedTuple):
    """What a board says of itself, when it starts and when it is asked.

    Attributes:
        protocol: Version of these messages.
        firmware: Hash of the firmware's sources.
        nonce: Starts of this board so far; ARM has to name it.
        reset_cause: Causes of the last start, bits of `RESETS`; a bootloader may clear them.
        heard: Whether a command was accepted since the start, the last of them numbered `seq`.
        seq: Number of that command.
        tick_hz: Ticks per second [Hz].
        counts_per_rev_1: Counts per turn [1] of encoder 1.
        counts_per_rev_2: Counts per turn [1] of encoder 2.
        pulse_min: Shortest pulse [half us].
        pulse_neutral: Neutral pulse [half us].
        pulse_max: Longest pulse [half us].
        arm_ticks: Ticks for which the ESCs are armed with neutral pulses.
        silence_ticks: Ticks without a host after which the board goes to neutral.
        most_counts: Counts in a tick beyond which the board stops.
        battery_lowest: Battery voltage [mV] below which the board stops.
    """

    protocol: int
    firmware: int
    nonce: int
    reset_cause: int
    heard: int
    seq: int
    tick_hz: int
    counts_per_rev_1: int
    counts_per_rev_2: int
    pulse_min: int
    pulse_neutral: int
    pulse_max: int
    arm_ticks: int
    silence_ticks: int
    most_counts: int
    battery_lowest: int


def unwanted_reset(hello: Hello) -> bool:
    """Whether a board's last start was a failure, by its causes.

    Args:
        hello: What the board says of itself.

    Returns:
        True after the watchdog, and after a brown-out unless a power-on explains it: supplies rise slowly.
    """
    cause = hello.reset_cause
    return bool(cause & 8) or (bool(cause & 4) and not cause & 1)


def reset_causes(hello: Hello) -> str:
    """Why a board has started, in words.

    Args:
        hello: What the board says of itself.

    Returns:
        The causes, "unknown" where none is set.
    """
    return ", ".join(name for bit, name in RESETS.items() if hello.reset_cause & bit) or "unknown"


class Sample(NamedTuple):
    """What a board says of one tick.

    Attributes:
        tick: Number of the tick, modulo 2^32.
        count_1: Counts [1] of encoder 1, modulo 2^32.
        count_2: Counts [1] of encoder 2, modulo 2^32.
        pulse_1: Pulse [half us] of output 1 that begins with this tick.
        pulse_2: Pulse [half us] of output 2.
        battery: Battery voltage [mV].
        state: State of the board, index of `STATES`.
        faults: Faults, bits of `FAULTS`.
        playing: Whether an experiment is being played.
        missed: Ticks missed since the start.
        dropped: Frames dropped because the line had no room.
        damaged: Frames from the host that could not be read.
        overruns: Bytes from the host that were lost.
    """

    tick: int
    count_1: int
    count_2: int
    pulse_1: int
    pulse_2: int
    battery: int
    state: int
    faults: int
    playing: int
    missed: int
    dropped: int
    damaged: int
    overruns: int


class Ack(NamedTuple):
    """A board's answer to a command.

    Attributes:
        seq: Number of the command.
        command: Its frame type.
        result: Index of `RESULTS`.
    """

    seq: int
    command: int
    result: int


Message = Hello | Sample | Ack
"""Anything that a board says."""
MESSAGES = {
    0x81: (Hello, struct.Struct("<BIIBBHHHHHHHHHHH")),
    0x82: (Sample, struct.Struct("<IiiHHHBBBHHHB")),
    0x83: (Ack, struct.Struct("<HBB")),
}
"""Messages of a board, by frame type: class and layout of the body."""


def message(frame: Frame) -> Message | None:
    """What a board's frame says.

    Args:
        frame: A frame of the board.

    Returns:
        The message, None for one that this version does not know.
    """
    kind, body = MESSAGES.get(frame.type, (None, None))
    said = kind(*body.unpack(frame.body)) if kind and body and len(frame.body) == body.size else None
    unknown = (isinstance(said, Sample) and said.state >= len(STATES)) or (
        isinstance(said, Ack) and said.result >= len(RESULTS)
    )
    return None if unknown else said
