"""A raw stream as logs: stretches in which the command is known throughout, in the columns of the interface.

A stream that ends anywhere, because the recorder was killed, is read up to its last whole frame.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rwjax.errors import LogError, RigError, read_text
from rwjax.link.frames import Decoder, Hello, Sample, message, resets, unwanted
from rwjax.logs.sheet import FEWEST
from rwjax.logs.write import write_log
from rwjax.planning.experiment import TICK_HZ
from rwjax.rig.model import Rig

MOST_LOST = 10
"""Samples in a row that may be lost within one log, 0.1 s, where the pulses before and after are the same: else the command
is unknown meanwhile, and the gap ends the log."""
WRAP = 2**32
COUNTERS = {
    "missed": "ticks missed",
    "dropped": "frames dropped for lack of room on the line",
    "damaged": "frames of the host damaged",
    "overruns": "bytes of the host lost",
}
"""What a board counts since its start, and what that is in words."""
COLUMNS = {"axis": "yaw_counts", "wheel": "wheel_counts"}


@dataclass(frozen=True)
class Stretch:
    """Samples of one boot of a board in a row. Arrays have shape (n,)."""

    hello: Hello | None  # of the board, where it was heard
    tick: np.ndarray  # unwrapped
    count: np.ndarray  # (n, 2), unwrapped
    pulse: np.ndarray  # (n, 2), half us
    battery: np.ndarray  # mV
    playing: np.ndarray
    counters: np.ndarray  # (n, 4), by `COUNTERS`

    def gaps(self) -> list[tuple[int, int]]:
        """For every gap the index of the sample after it, and how many samples are missing."""
        step = np.diff(self.tick)
        return [(int(k) + 1, int(step[k]) - 1) for k in np.flatnonzero(step > 1)]

    def troubles(self) -> list[str]:
        """What went wrong on the board: what it counted meanwhile, and why it had started where that was no one's wish."""
        more = (self.counters[-1] - self.counters[0]) % [2**16, 2**16, 2**16, 2**8]
        found = [f"{n} {words}" for n, words in zip(more, COUNTERS.values(), strict=True) if n]
        if self.hello is not None and unwanted(self.hello):
            found.append(f"its last start was by {resets(self.hello)}")
        return found

    def only(self, keep: np.ndarray) -> "Stretch":
        """Part of the samples."""
        names = ("tick", "count", "pulse", "battery", "playing", "counters")
        return replace(self, **{name: getattr(self, name)[keep] for name in names})


def read_stream(path: Path) -> tuple[list[Stretch], int]:
    """The stretches of a raw stream, and how many frames in it are damaged."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}; give the path of a raw stream") from None
    return stretches(data)


def stretches(data: bytes) -> tuple[list[Stretch], int]:
    """The same of bytes. What stands before the first zero may be half a frame and is not called damaged."""
    decoder = Decoder()
    first = data.find(b"\0") + 1
    messages = [message(frame) for frame in decoder.feed(data[:first])]
    decoder.damaged = 0
    messages += [message(frame) for frame in decoder.feed(data[first:])]
    found: list[Stretch] = []
    hello, group = None, []
    for said in messages:
        if isinstance(said, Hello):
            if hello and said.nonce != hello.nonce:
                found += _stretch(hello, group)
                group = []
            hello = said
        elif isinstance(said, Sample):
            if group and not _joined(group[-1], said):
                found += _stretch(hello, group)
                group = []
            group.append(said)
    return found + _stretch(hello, group), decoder.damaged


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


def check_rig(rig: Rig) -> None:
    """`RigError` for a rig file that says nothing about pulses or counts."""
    if rig.pwm is None:
        raise RigError(
            f"{rig.name}: no `drive.pwm`; a recording needs `pwm = {{ neutral_us = 1500, volts_per_us = … }}`"
        )
    if not rig.counts_per_rev:
        raise RigError(f"{rig.name}: no `counts_per_rev`; a recording needs one under [encoder] or [wheel_encoder]")


class Channels(NamedTuple):
    """Which of a board's two, 0 or 1, belongs to what."""

    output: int
    encoders: dict[str, int]
    """Of "axis" and "wheel", those that the rig has and counts."""


def channels(rig: Rig) -> Channels:
    """Encoder 1 and output 1 belong to the axis unless `[columns]` says otherwise.

    The wheel's encoder is the other one; where there is no axis it takes the axis's place.
    """
    axis = int(rig.columns.get("position", "pos1") == "pos2")
    of = {"axis": axis, "wheel": axis if rig.kind == "wheel" else 1 - axis}
    absent = {"wheel": "axis", "platform": "wheel"}.get(rig.kind)
    encoders = {who: k for who, k in of.items() if who in rig.counts_per_rev and who != absent}
    return Channels(int(rig.columns.get("pulse", "pwm_1") == "pwm_2"), encoders)


def check_board(hello: Hello, rig: Rig) -> list[str]:
    """Remarks where a board counts otherwise than the rig file says; `RigError` where its pulses mean other volts."""
    check_rig(rig)
    assert rig.pwm is not None
    if hello.pulse_neutral != 2.0 * rig.pwm.neutral_us:
        raise RigError(
            f"{rig.name}: `neutral_us` is {rig.pwm.neutral_us:g}, and the board's neutral pulse lasts "
            f"{hello.pulse_neutral / 2:g} us; correct the rig file or PULSE_NEUTRAL in the firmware's config.h"
        )
    told = hello.counts_per_rev_1, hello.counts_per_rev_2
    return [
        f"the firmware's config.h has {told[k]} counts a turn for the encoder of the {who}, the rig file "
        f"{rig.counts_per_rev[who]:g}, which is used"
        for who, k in channels(rig).encoders.items()
        if told[k] != rig.counts_per_rev[who]
    ]


def columns(stretch: Stretch, rig: Rig) -> dict[str, np.ndarray]:
    """Columns of the interface, by `channels`. Time counts from the first sample, in the board's ticks."""
    assert rig.pwm is not None
    output, encoders = channels(rig)
    hertz = stretch.hello.tick_hz if stretch.hello else TICK_HZ
    return {
        "time_s": (stretch.tick - stretch.tick[0]) / hertz,
        "voltage_V": np.round((stretch.pulse[:, output] / 2.0 - rig.pwm.neutral_us) * rig.pwm.volts_per_us, 9),
        **{COLUMNS[who]: stretch.count[:, k] for who, k in encoders.items()},
        "supply_V": stretch.battery / 1000.0,
    }


def refuse_existing(*paths: Path) -> None:
    """`LogError` for the first that is there already."""
    for path in paths:
        if path.exists():
            raise LogError(f"{path}: exists already; a recording never replaces another, give a new name with -o")


def write_logs(raw: Path, rig: Rig, output: Path) -> tuple[list[Path], list[str]]:
    """The logs in a raw stream: `output`, or where it falls into several stretches `output-1`, `output-2` …; and remarks.

    Of an experiment, the part that was played. Notes come from the file beside the stream. Raises `LogError` where one of
    the logs is there already, and `RigError` where the board was set up for another rig; then none is written.
    """
    check_rig(rig)
    notes = read_notes(raw.with_suffix(".notes"))
    all_found, damaged = read_stream(raw)
    hellos = dict.fromkeys(s.hello for s in all_found if s.hello)
    remarks = list(dict.fromkeys(remark for hello in hellos for remark in check_board(hello, rig)))
    played = [s.only(s.playing) if s.playing.any() else s for s in all_found]
    if "experiment" in notes:
        played = [s for s in played if s.playing.any()]
        if idle := len(all_found) - len(played):
            remarks.append(f"{idle} stretches in which nothing was played are left out")
    found = [s for s in played if len(s.tick) >= FEWEST]
    if short := len(played) - len(found):
        remarks.append(f"{short} stretches of under {FEWEST} samples are left out")
    if damaged:
        remarks.append(f"{damaged} damaged frames")
    names = [output] if len(found) == 1 else [numbered(output, k + 1) for k in range(len(found))]
    refuse_existing(*names)
    for name, stretch in zip(names, found, strict=True):
        about = notes | {"firmware": f"{stretch.hello.firmware:08x}"} if stretch.hello else notes
        table = columns(stretch, rig)
        gaps = [f"{n} samples before {table['time_s'][k]:.2f} s" for k, n in stretch.gaps()]
        troubles = stretch.troubles()
        said = {"gap": "; ".join(gaps), "board": "; ".join(troubles)}
        write_log(name, table, about | {key: value for key, value in said.items() if value})
        remarks += [f"{name.name}: gap of {gap}" for gap in gaps]
        remarks += [f"{name.name}: the board: {trouble}" for trouble in troubles]
    return names, remarks


def numbered(output: Path, k: int) -> Path:
    """The name of the k-th of several logs."""
    return output.with_stem(f"{output.stem}-{k}")


def read_notes(path: Path) -> dict[str, str]:
    """Notes beside a stream, lines `key: value`; none if there is no such file."""
    if not path.exists():
        return {}
    pairs = (line.partition(":") for line in read_text(path, LogError).splitlines() if ":" in line)
    return {key.strip(): value.strip() for key, _, value in pairs}
