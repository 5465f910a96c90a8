"""Commands killed with -9 at random moments, two at a time, and on a full disk: the old output or the new one, whole.

Of a diagnosis there may be the answer alone: its page is drawn later.
"""

import itertools
import os
import random
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from rwjax import parse_rig
from rwjax.diagnosis.record import RECORD
from rwjax.link.stream_to_logs import write_logs
from rwjax.report.results import CORRECTED, JSON
from tests.damage.commands import SECONDS, board, contents
from tests.damage.process import start
from tests.damage.trial import Damaged, Outcome
from tests.damage.whole import RIGS, STILL
from tests.link.ports import LIKE_RIG, stream

MOVING = "time_s,voltage_V,yaw_counts\n" + "".join(f"{k / 100},{(k // 20) % 2},{k * k // 9}\n" for k in range(60))
WIRE = b"".join(stream(range(4000), LIKE_RIG))
"""Forty seconds of a board."""
COMMANDS = {
    "fit": ("fit", "rig.toml", "run.csv", "-o", "out.toml"),
    "diagnose": ("diagnose", "rig.toml", "run.csv", "run-2.csv", "-o", "out"),
    "record": ("record", "rig.toml", "PORT", "-o", "run.csv", "--seconds", "0.5"),
}
FILES = {"fit": {"run.csv": MOVING}, "diagnose": {"run.csv": STILL, "run-2.csv": STILL}}
KILLED = ("fit", "diagnose", "record")
BESIDE = ("fit two", "fit full", "diagnose two", "diagnose full", "record full")
"""What is done besides, once for every `EVERY` kills: two at a time, with different rigs; commands on a full disk."""
EVERY = 5
ANSWER = (JSON, CORRECTED, RECORD)
"""Files of a diagnosis that are there before its page is drawn."""
LEAST = 600
"""Bytes that a file may have on a full disk: the line that says so has to go somewhere."""


class Kills:
    """Commands whose output is known, and what is left of it when they are stopped.

    Attributes:
        seconds: How long each command takes where it is left alone [s].
    """

    def __init__(self, seed: int) -> None:
        self.random, self.seconds = random.Random(seed), {"record": 1.5}
        self.known: dict[tuple[str, str], dict[str, str]] = {}
        self.whole: dict[tuple[str, str], Path] = {}
        self.place = Path(tempfile.mkdtemp())
        for command, name in itertools.product(("fit", "diagnose"), ("old", "new")):
            folder = self.place / f"{command} {name}"
            folder.mkdir()
            self._lay(folder, command, name)
            began = time.monotonic()
            process = start([*COMMANDS[command]], folder, folder.with_suffix(".out"), folder.with_suffix(".err"))
            process.join(SECONDS)
            if process.exitcode != 0:
                raise SystemExit(folder.with_suffix(".err").read_text())
            self.seconds[command] = time.monotonic() - began
            self.whole[command, name], self.known[command, name] = folder, _output(folder)

    def __enter__(self) -> "Kills":
        return self

    def __exit__(self, *of_an_error: object) -> None:
        shutil.rmtree(self.place)

    def attempts(self, count: int) -> Iterator[tuple[Damaged, Outcome]]:
        """So many commands killed, in turns, and a fifth as many that write beside another or on a full disk."""
        beside = itertools.cycle(BESIDE)
        for number, killed in enumerate(itertools.islice(itertools.cycle(KILLED), count), start=1):
            for kind in (killed, next(beside)) if number % EVERY == 0 else (killed,):
                yield self._attempt(kind)

    def _attempt(self, kind: str) -> tuple[Damaged, Outcome]:
        """A command stopped, and what is wrong then."""
        command, _, how = kind.partition(" ")
        with tempfile.TemporaryDirectory(dir=self.place) as folder:
            own = Path(folder) / "own"
            if command == "record":
                faults = self._recorded(own, most_bytes=self.random.randrange(LEAST, 4000) if how else None)
            else:
                shutil.copytree(self.whole[command, "old"], own)
                faults = {"": self._killed, "two": self._two, "full": self._full}[how](own, command)
        status = "failed" if faults else "accepted"
        return Damaged(kind, {}), Outcome(status, [f"{kind}: {what}" for what in faults])

    def _lay(self, folder: Path, command: str, name: str) -> None:
        """The input of a command, by which its output is the old or the new one."""
        rig = RIGS["platform"].replace("thesis platform", f"{name} rig")
        (folder / "rig.toml").write_text(rig)
        for log, text in FILES[command].items():
            (folder / log).write_text(text)

    def _killed(self, folder: Path, command: str) -> list[str]:
        """A command killed at any moment, or as soon as it writes."""
        self._lay(folder, command, "new")
        before = _listing(folder)
        process = start([*COMMANDS[command]], folder, folder.with_name("out"), folder.with_name("err"))
        end = time.monotonic() + self.random.uniform(0.0, 1.2 * self.seconds[command])
        at_once = self.random.random() < 0.6
        while process.is_alive() and (at_once or time.monotonic() < end):
            if at_once and _listing(folder) != before:
                time.sleep(
                    self.random.choice((0.0, 0.0, self.random.uniform(0.0, 0.02), self.random.uniform(0.0, 0.6)))
                )
                break
            time.sleep(0.0005)
        process.kill()
        process.join()
        return self._torn(folder, command)

    def _torn(self, folder: Path, command: str) -> list[str]:
        """What is wrong with an output that has to be the old or the new one, or of a diagnosis the answer without its page."""
        whole = [self.known[command, name] for name in ("old", "new")]
        answers = [{name: digest for name, digest in each.items() if Path(name).name in ANSWER} for each in whole]
        return [] if _output(folder) in (whole + answers if command == "diagnose" else whole) else ["torn"]

    def _two(self, folder: Path, command: str) -> list[str]:
        """Two processes that write one output."""
        names = {"old": "one.toml", "new": "other.toml"}
        self._lay(folder, command, "old")
        (folder / "rig.toml").rename(folder / "one.toml")
        self._lay(folder, command, "new")
        (folder / "rig.toml").rename(folder / "other.toml")
        both = [
            start(
                [a.replace("rig.toml", rig) for a in COMMANDS[command]],
                folder,
                folder.with_name(rig),
                folder.with_name(rig + ".err"),
            )
            for rig in names.values()
        ]
        for process in both:
            process.join(SECONDS)
        faults = [f"status {process.exitcode}" for process in both if process.exitcode not in (0, 2)]
        return [*faults, *self._torn(folder, command), *_strangers(folder)]

    def _full(self, folder: Path, command: str) -> list[str]:
        """A disk on which no file becomes longer than some size."""
        self._lay(folder, command, "new")
        largest = max(path.stat().st_size for path in self.whole[command, "new"].rglob("*") if path.is_file())
        process = start(
            [*COMMANDS[command]],
            folder,
            folder.with_name("out"),
            folder.with_name("err"),
            most_bytes=self.random.choice((LEAST, *(self.random.randrange(LEAST, most) for most in (2000, largest)))),
        )
        process.join(SECONDS)
        return [*_refused(process.exitcode, folder.with_name("err")), *self._torn(folder, command), *_strangers(folder)]

    def _recorded(self, folder: Path, *, most_bytes: int | None) -> list[str]:
        """A recording killed at any moment, or on a full disk."""
        folder.mkdir()
        (folder / "rig.toml").write_text(RIGS["reaction"])
        with board(WIRE) as line:
            arguments = [line.port if a == "PORT" else a for a in COMMANDS["record"]]
            process = start(arguments, folder, folder.with_name("out"), folder.with_name("err"), most_bytes=most_bytes)
            if most_bytes is None:
                process.join(self.random.uniform(0.0, self.seconds["record"]))
                process.kill()
            process.join(SECONDS)
        faults = _refused(process.exitcode, folder.with_name("err")) if most_bytes is not None else []
        raw = folder / "run.raw"
        if (raw.read_bytes() if raw.exists() else b"") not in line.sent:
            faults.append("bytes on disk that were not sent in this order")
        if logs := sorted(folder.glob("*.csv")):
            again = folder / "again"
            again.mkdir()
            shutil.copy(raw, again)
            write_logs(again / raw.name, parse_rig(RIGS["reaction"]), again / "run.csv")
            faults += [f"{log.name} is not whole" for log in logs if _rows(log) != _rows(again / log.name)]
        return faults


def _listing(folder: Path) -> list[str]:
    """What stands in a folder and right below it."""
    found = []
    for name in os.listdir(folder):
        found.append(name)
        with suppress(FileNotFoundError, NotADirectoryError):  # a file, or what a writer removes just now
            found += [f"{name}/{each}" for each in sorted(os.listdir(folder / name))]
    return sorted(found)


def _output(folder: Path) -> dict[str, str]:
    """A digest of every file of the output."""
    return {name: digest for name, digest in contents(folder).items() if name.startswith("out")}


def _strangers(folder: Path) -> list[str]:
    """Temporary files that stay although no command was killed."""
    return [f"{name} stays" for name in os.listdir(folder) if name.startswith(".")]


def _refused(status: int | None, err: Path) -> list[str]:
    """What is wrong with the end of a command on a full disk: it may say so in one line."""
    said = err.read_text().splitlines() if err.exists() else []
    lines = [line for line in said if not line.startswith("note: ")]
    if status not in (0, 2) or any("Traceback" in line for line in lines):
        return [f"status {status}, {lines[-1][:80] if lines else ''}"]
    return [] if status == 0 or len(lines) <= 1 else [f"{len(lines)} lines"]


def _rows(path: Path) -> list[str]:
    return [line for line in path.read_text().split("\n") if not line.startswith("#")]
