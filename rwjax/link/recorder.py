"""Recording: every byte handed to the system as it comes, notes beside it, and whatever happens a log of what was received."""

import errno
import math
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import serial

from rwjax.errors import InputError, write_text
from rwjax.link import frames
from rwjax.link.frames import Sample
from rwjax.link.session import LinkError, Port, Session, faults, reason
from rwjax.link.stream import channels, check_board, check_rig, numbered, refuse_existing, write_logs
from rwjax.planning.envelope import LITTLE, PULSES_US, check_neutral
from rwjax.planning.experiment import TICK_HZ, Experiment
from rwjax.rig.model import Rig

BAUD = 250_000


class Raw:
    """A file that takes bytes at once: no buffer of ours between them and the system."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o644)
        except FileExistsError:
            raise LinkError(f"{path}: exists already; a recording never replaces another, give a new name") from None
        except OSError as error:
            raise LinkError(f"{path}: cannot be written: {error.strerror}; give a path in a writable folder") from None

    def write(self, data: bytes) -> None:
        """Raises `LinkError` where the disk takes no more."""
        try:
            while data:
                data = data[os.write(self._file, data) :]
        except OSError as error:
            raise LinkError(f"{self.path}: {error.strerror}; what came before is kept") from None

    def close(self) -> None:
        """The bytes survive a power cut from here on."""
        try:
            os.fsync(self._file)
        except OSError:
            pass  # a pipe or a full disk
        os.close(self._file)


def open_port(url: str) -> Port:
    """The port at a path or URL of pyserial, for this program alone."""
    try:
        return serial.serial_for_url(url, baudrate=BAUD, exclusive=True)
    except (serial.SerialException, ValueError) as error:
        if getattr(error, "errno", None) == errno.EWOULDBLOCK:
            raise LinkError(f"{url}: another program talks to this port; end it first") from None
        raise LinkError(f"{url}: cannot be opened: {reason(error)}; give a serial port such as /dev/ttyACM0") from None


@dataclass(frozen=True)
class Recorded:
    """What a recording left on disk, and what ended it early."""

    logs: list[Path]
    remarks: list[str]
    failure: Exception | KeyboardInterrupt | None


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Ctrl-C does nothing meanwhile: whoever presses it twice gets the log too. It always reaches the main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def check_new(output: Path) -> None:
    """`LogError` where a recording at `output` would meet a file of another one."""
    refuse_existing(output, numbered(output, 1), output.with_suffix(".raw"), output.with_suffix(".notes"))


def record(
    url: str,
    rig: Rig,
    output: Path,
    notes: dict[str, str],
    act: Callable[[Session], None],
    watch: Callable[[Session, Sample], None] = lambda session, sample: None,
    ready: Callable[[Session], dict[str, str]] = lambda session: {},
) -> Recorded:
    """Opens the port, does `act`, and leaves the board disarmed and a log at `output`, however it ends.

    Beside the log lie its raw stream (`.raw`) and its notes (`.notes`). `ready` waits until the recording may begin, and tells
    what else the notes should say. Raises `InputError` where nothing could begin: then nothing stays.
    """
    check_rig(rig)
    check_new(output)
    failure, begun, found = None, False, {}
    with closing(open_port(url)) as port, closing(Raw(output.with_suffix(".raw"))) as raw:
        session = Session(port, raw.write, watch)
        try:
            started = {"date": f"{datetime.now().astimezone():%Y-%m-%d %H:%M:%S %z}", "rig": rig.name}
            beside = raw.path.with_suffix(".notes")
            write_text(beside, _lines(notes | started), LinkError)
            check_board(session.greet(), rig)
            found = ready(session)
            write_text(beside, _lines(notes | started | found), LinkError)
            begun = True
            act(session)
        except (Exception, KeyboardInterrupt) as error:  # whatever it is: raised by the caller, after the log
            failure = error
        finally:
            with _uninterrupted():
                session.leave()
    if failure and not begun:
        raw.path.unlink()
        raw.path.with_suffix(".notes").unlink(missing_ok=True)
        raise failure
    with _uninterrupted():
        try:
            logs, remarks = write_logs(raw.path, rig, output)
        except InputError as error:
            logs, remarks = [], [str(error)]
    return Recorded(logs, [*found.values(), *remarks], failure)


def _lines(notes: dict[str, str]) -> str:
    return "".join(f"{key}: {value}\n" for key, value in notes.items())


def listen(seconds: float | None) -> Callable[[Session], None]:
    """Only takes what comes, for so long or until it is interrupted."""

    left = math.inf if seconds is None else TICK_HZ * seconds

    def act(session: Session) -> None:
        nonlocal left
        while left > 0:
            left -= len(session.samples())

    return act


def to_play(experiment: Experiment, rig: Rig) -> tuple[int, ...]:
    """What the command PLAY carries. Raises `LinkError` for what the board cannot play."""
    check_rig(rig)
    assert rig.pwm is not None
    check_neutral(rig.pwm)
    half_us = [_whole(2.0 * volts / rig.pwm.volts_per_us) for volts in (experiment.amplitude, experiment.offset)]
    ticks = [_whole(TICK_HZ * seconds) for seconds in (experiment.period, experiment.length)]
    check_pulses(experiment, rig, *PULSES_US)
    if not 4 <= ticks[0] < 2**16:
        raise LinkError(f"a period of {experiment.period:g} s: has to lie between 0.04 and 655 s")
    if not 0 < ticks[1] <= 360_000:
        raise LinkError(f"a length of {experiment.length:g} s: has to lie between 0.01 and 3600 s")
    return channels(rig).output, frames.EXPERIMENTS.index(experiment.kind), *half_us, *ticks


def check_pulses(experiment: Experiment, rig: Rig, shortest: float, longest: float) -> None:
    """Raises `LinkError` where an experiment needs pulses that an ESC between these [us] does not take."""
    assert rig.pwm is not None
    neutral, per_us = rig.pwm
    size = (abs(experiment.amplitude) + abs(experiment.offset)) / abs(per_us)
    span = longest - neutral  # boards drive no further the other way either
    ends = [(end - neutral) * per_us for end in (max(shortest, neutral - span), longest)]
    least = LITTLE * max(map(abs, ends))
    low, high = sorted(end if abs(end) >= least else 0.0 for end in ends)
    spare = 1e-6  # us, of rounding
    small = size <= span + spare
    beyond = max(low - experiment.span[0], experiment.span[1] - high) / abs(per_us)
    if not (small and beyond <= spare):
        right = "this ESC turns one way: add an offset" if small and 0.0 in (low, high) else "give less"
        raise LinkError(
            f"{experiment.amplitude:g} V about {experiment.offset:g} V: the pulses reach {low:g} to {high:g} V; {right}"
        )


def _whole(value: float) -> int:
    """The nearest whole number; of what no command holds, or is no number, one that is refused."""
    return round(value) if abs(value) < 2**31 else 2**31


def play(experiment: Experiment, rig: Rig, clear: bool = False) -> Callable[[Session], None]:
    """Arms, plays to the end, disarms."""
    values = to_play(experiment, rig)

    def act(session: Session) -> None:
        hello = session.hello or session.greet()
        check_pulses(experiment, rig, hello.pulse_min / 2.0, hello.pulse_max / 2.0)
        if clear and session.samples()[-1].state == frames.FAULT:
            session.command(frames.CLEAR, done=lambda sample: sample.state != frames.FAULT)
        session.arm()
        session.command(frames.PLAY, *values, done=lambda sample: bool(sample.playing))
        begun = False
        while True:
            for sample in session.samples():
                if sample.state != frames.ARMED:
                    why = faults(sample) if sample.faults else f"it is {frames.STATES[sample.state]}"
                    raise LinkError(f"the board has stopped the experiment: {why}")
                if begun and not sample.playing:
                    return session.disarm()
                begun = begun or bool(sample.playing)

    return act
