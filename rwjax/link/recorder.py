"""Recording: every byte goes to disk as it comes, notes beside it, and however it ends a log is made of what came."""

import math
import os
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from rwjax.errors import InputError, printable
from rwjax.link.channels import check_board, pwm_of
from rwjax.link.ctrl_c import CtrlC
from rwjax.link.messages import PLAY, Sample
from rwjax.link.port import LinkError, open_port
from rwjax.link.session import Session
from rwjax.link.stream_to_logs import numbered, refuse_existing, write_logs
from rwjax.planning.experiment import TICK_HZ
from rwjax.rig.model import Rig
from rwjax.text_files import write_text


class Raw:
    """A new file that hands bytes to the operating system at once, without a buffer of its own.

    Args:
        path: The file.

    Raises:
        LinkError: Where it is there already or cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o644)
        except FileExistsError:
            raise LinkError(f"{path}: exists already; a recording never replaces another, give a new name") from None
        except OSError as error:
            raise LinkError(f"{path}: cannot be written: {error.strerror}; give a path in a writable folder") from None

    def write(self, data: bytes) -> None:
        """Appends bytes.

        Args:
            data: The bytes.

        Raises:
            LinkError: Where the disk takes no more.
        """
        try:
            while data:
                data = data[os.write(self._file, data) :]
        except OSError as error:
            raise LinkError(f"{self.path}: {error.strerror}; what came before is kept") from None

    def close(self) -> None:
        """Closes the file; from here on its bytes survive a power cut."""
        try:
            os.fsync(self._file)
        except OSError:
            pass  # a pipe or a full disk
        os.close(self._file)


@dataclass(frozen=True)
class Recorded:
    """What a recording left on disk.

    Attributes:
        logs: The logs that were written.
        remarks: What a user should know about them.
        failure: What ended the recording early, None where nothing did.
    """

    logs: list[Path]
    remarks: list[str]
    failure: Exception | KeyboardInterrupt | None


def check_new(output: Path) -> None:
    """Checks that a recording would meet no file of another one.

    Args:
        output: Name of its log.

    Raises:
        LogError: Where one of its files is there already.
    """
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
    """Opens the port, acts, and leaves the board disarmed and a log on disk, however it ends.

    Args:
        url: The port, as `open_port` takes it.
        rig: The rig that hangs on the board.
        output: Name of the log; beside it lie its raw stream (`.raw`) and its notes (`.notes`).
        notes: Notes for the log by key.
        act: What the session does, such as `play(…)` or `listen(…)`.
        watch: Takes the session and every sample that comes.
        ready: Waits until the recording may begin, and returns further notes.

    Returns:
        What is on disk, and what ended the recording early.

    Raises:
        InputError: Where nothing could begin, and where an experiment's PLAY was never sent; then nothing stays on disk.
    """
    pwm_of(rig)
    check_new(output)
    with closing(open_port(url)) as port, CtrlC() as ctrl_c:
        failure, begun, found, beside = None, False, {}, output.with_suffix(".notes")
        logs, remarks = [], []
        with closing(Raw(output.with_suffix(".raw"))) as raw:
            session = Session(port, raw.write, watch, lambda: ctrl_c.pressed)
            try:
                started = {"date": f"{datetime.now().astimezone():%Y-%m-%d %H:%M:%S %z}", "rig": rig.name}
                write_text(beside, _lines(notes | started), LinkError)
                check_board(session.greet(), rig)
                found = ready(session)
                write_text(beside, _lines(notes | started | found), LinkError)
                begun = True
                act(session)
            except (Exception, KeyboardInterrupt) as error:  # whatever it is: raised by the caller, after the log
                failure = error
            finally:
                session.leave()
        begun = begun and ("experiment" not in notes or PLAY in session.sent)  # from there on the board may have played
        if failure and not begun:
            raw.path.unlink(missing_ok=True)
            beside.unlink(missing_ok=True)
        else:
            try:
                logs, remarks = write_logs(raw.path, rig, output)
            except InputError as error:
                remarks = [str(error)]
        if ctrl_c.pressed:  # also of one that came too late for the session: nobody wants the next run
            failure = failure or KeyboardInterrupt()
    with suppress(KeyboardInterrupt):  # it is told by what is returned, or raised here
        ctrl_c.heed()
    if failure and not begun:
        raise failure
    return Recorded(logs, [*found.values(), *remarks], failure)


def _lines(notes: dict[str, str]) -> str:
    """A note a line, whatever its key and its value hold."""
    return "".join(f"{printable(key)}: {printable(value)}\n" for key, value in notes.items())


def listen(seconds: float | None) -> Callable[[Session], None]:
    """What a session does to record without arming the board.

    Args:
        seconds: How long it listens [s]; None until it is interrupted.

    Returns:
        A function that takes samples for so long.
    """

    def act(session: Session) -> None:
        if seconds is None:
            while True:
                session.samples()
        wanted = math.ceil(TICK_HZ * seconds)
        came = sum(isinstance(message, Sample) for message in session.coming(wanted))
        if came < wanted:
            raise LinkError(
                f"only {came} of the {wanted} samples of {seconds:g} s have come in more than twice that time"
            )

    return act
