"""Recorders killed with -9 at random moments: `python -m tests.link.killed [N]`; 50 without an argument.

A feeder writes a board's samples to a pseudo terminal, one every 2 ms; a recorder takes as many as it was told and makes its log.
After the kill every byte that was sent is on disk or still in the terminal, except for what one read had just brought. Log and
notes are whole or not there. Prints how many kills lost what a read had brought.
"""

import os
import random
import signal
import sys
import tempfile
import time
import tty
from pathlib import Path

from rwjax.link.recorder import listen, record
from rwjax.link.stream import stretches
from rwjax.link.stream_to_logs import read_notes, write_logs
from tests.link.ports import RIG, stream

MOST_IN_HAND = 256  # bytes, of one read
TERMINAL = 4095  # bytes that a terminal holds; it drops what comes then
MOST_S = 0.6  # until the last kill: 100 samples, their log, and some more
NOTES = {"role": "train", "why": "to be killed"}


def killed_once(folder: Path, after: float) -> tuple[int, int]:
    """Samples on disk after a recorder was killed so many seconds after its first byte, and bytes lost in its hand."""
    master, slave = os.openpty()
    tty.setraw(slave)
    raw = folder / f"{after:.6f}.raw"
    if (child := os.fork()) == 0:
        try:
            record(os.ttyname(slave), RIG, raw.with_suffix(".csv"), NOTES, listen(1.0))
        finally:
            os._exit(0)
    sent, pieces = b"", iter(stream(range(100_000)))
    while not raw.exists():
        time.sleep(0.001)
    end = time.monotonic() + after
    while time.monotonic() < end:
        piece = next(pieces)
        os.write(master, piece)
        sent += piece
        time.sleep(0.002)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.set_blocking(slave, False)
    try:
        left = os.read(slave, 65_536)
    except BlockingIOError:
        left = b""
    os.close(master)
    os.close(slave)
    kept = raw.read_bytes()
    lost = len(sent) - len(kept) - len(left)
    dropped = len(left) >= TERMINAL  # a machine under load lets the recorder wait until the terminal overflows
    if not sent.startswith(kept) or not (0 <= lost <= MOST_IN_HAND or dropped):
        raise SystemExit(f"after {after} s: {len(kept)} of {len(sent)} bytes on disk, {len(left)} in the terminal")
    found, damaged = stretches(kept)
    whole = kept.count(b"\0") - 1  # frames that end on disk, without HELLO
    if damaged or sum(len(s.tick) for s in found) != max(whole, 0):
        raise SystemExit(
            f"after {after} s: {whole} frames on disk, {[len(s.tick) for s in found]} read, {damaged} damaged"
        )
    check_beside(raw, after)
    return max(whole, 0), lost


def check_beside(raw: Path, after: float) -> None:
    """Log and notes beside a raw stream: whole, or not there."""
    log, notes = raw.with_suffix(".csv"), raw.with_suffix(".notes")
    if notes.exists() and ({*read_notes(notes)} != {*NOTES, "date", "rig"} or not notes.read_bytes().endswith(b"\n")):
        raise SystemExit(f"after {after} s the notes are torn: {notes.read_text()!r}")
    if log.exists():
        (again,), _ = write_logs(raw, RIG, raw.with_name("again.csv"))
        if again.read_bytes() != log.read_bytes():
            raise SystemExit(f"after {after} s the log is torn")
        again.unlink()


def main(arguments: list[str]) -> None:
    """Kills, checks, prints; status 1 and what was wrong where a byte is missing."""
    times, rng = int(arguments[0]) if arguments else 50, random.Random(9)
    with tempfile.TemporaryDirectory() as folder:
        found = [killed_once(Path(folder), rng.uniform(0.0, MOST_S)) for _ in range(times)]
        logs = len(list(Path(folder).glob("*.csv")))
    lost = sum(n > 0 for _, n in found)
    print(
        f"{times} recorders killed: {sum(n for n, _ in found)} samples on disk, every one whole, {logs} logs; ", end=""
    )
    print(f"{lost} lost what a read had just brought, {sum(n for _, n in found)} bytes in all")


if __name__ == "__main__":
    main(sys.argv[1:])
