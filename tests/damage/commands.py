"""Whole commands on damaged input, each a process of its own: how they end, what they say, what they leave."""

import csv
import hashlib
import io
import json
import os
import re
import tempfile
import threading
import time
import tomllib
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from hypothesis import strategies as st

from rwjax import InputError, parse_rig
from tests.damage import frames, logs, oracle, toml
from tests.damage.process import start
from tests.damage.trial import Damaged, Outcome
from tests.damage.values import NUMBERS, TEXTS, texts
from tests.damage.whole import LOGS, PLAN, RIGS, STILL, STREAM

SECONDS = 900
"""Wall-clock time after which a command hangs."""
FIT_FILE = json.dumps(
    {"numbers": {"axis.inertia": {"value": 0.0495}}, "covariance_of": ["axis.inertia"], "covariance": [[2.5e-5]]}
)
OPTIONS = {
    "predict": "RIG LOG -o OUT.csv|RIG LOG|RIG LOG --json|RIG LOG -o LOG",
    "fit": "RIG LOG -o OUT.toml --quiet|RIG LOG --json --quiet|RIG LOG LOG2 -o OUT.toml --quiet|RIG LOG -o RIG --quiet|RIG LOG --method two-stage --quiet|RIG LOG --method limit-speeds --quiet|RIG LOG --bootstrap 40 --quiet",
    "compare": "RIG LOG LOG2 -o OUT",
    "region": "RIG --kp 1:50:5 --kd 0:5:4 -o OUT.csv|RIG --sigma N --angle N --kp 1:9:3 --kd 1:9:3|RIG --kp 1:50:3 --kd N:N:2|RIG --period N --kp 1:2:2 --kd 1:2:2|RIG --fit FIT --plants 20 --kp 1:9:3 --kd 1:2:2",
    "sweep": "RIG --kp 1:50:2 --kd 1:5:2 --seconds 1 -o OUT.csv|RIG --kp 1:50:2 --kd 1:5:2 --step N --volts N --seconds 1|RIG --kp 1:50:2 --kd 1:5:2 --ki N --late N --period N --seconds N",
    "tune": "RIG --seconds 1 --kp 0:20 --quiet|RIG --fit FIT --plants 20 --seconds 1 --quiet",
    "size": "RIG --angle 45 --seconds 3 --density N|RIG --angle N --seconds N --radius 20:50:3 --thickness 1:5:3 -o OUT.csv",
    "slew": "RIG --angle 45 --amps 3 --rpm 4000 -o OUT.csv --quiet|RIG --angle N --amps N --volts N --quiet",
    "dump": "RIG --spin 3000 -o OUT.csv --quiet|RIG --spin N --volts N --quiet|RIG --spin 3000 --margin N --amps N --quiet",
    "plan": "RIG --volts 12 -o OUT|RIG --volts N --rate N -o OUT|RIG --volts 6 --travel N -o OUT",
    "decode": "RIG RAW -o OUT.csv|RIG RAW",
    "record": "RIG PORT -o OUT.csv --seconds 0.4|RIG PORT --seconds 0.4",
    "run-experiment": "RIG PORT --plan PLAN -o OUT|RIG PORT --kind square --volts N --seconds 1 -o OUT.csv",
    "diagnose": "RIG LOG LOG2 -o OUT --quiet",
}
"""Options of every command, apart by `|`; the words in capitals are replaced, N by a number."""
OFTEN = dict.fromkeys(OPTIONS, 6) | {
    "predict": 12,
    "fit": 10,
    "sweep": 3,
    "plan": 3,
    "tune": 1,
    "compare": 1,
    "diagnose": 1,
}
"""How often each command is tried, beside the others: few of those that take a minute."""
ON_PORT = ("record", "run-experiment")


@dataclass(frozen=True)
class Called:
    """A command with damaged files, or with files as they should be and damaged options."""

    command: str
    arguments: tuple[str, ...]
    files: dict[str, bytes]
    terminal: bool


@st.composite
def calls(draw: st.DrawFn) -> Called:
    """A command on damaged input."""
    command = draw(st.sampled_from([name for name in OPTIONS for _ in range(OFTEN[name])]))
    options = draw(st.sampled_from(OPTIONS[command].split("|"))).split()
    kinds = ("reaction",) * 3 + (("platform",) if command not in ("size", "slew", "dump", *ON_PORT, "decode") else ())
    kind = draw(st.sampled_from((*kinds, *kinds, *RIGS)))
    names = {
        "RIG": "rig.toml",
        "LOG": "run.csv",
        "LOG2": "run-2.csv",
        "FIT": "fit.json",
        "RAW": "run.raw",
        "PLAN": "plan.toml",
    }
    if draw(st.integers(0, 7)) == 0:
        names["RIG"] = _name(draw(texts())) + ".toml"
    if draw(st.integers(0, 7)) == 0:
        names["LOG"] = _name(draw(texts())) + ".csv"
    log = LOGS[kind][0]
    if command == "diagnose":
        kind, log = "platform", STILL
    whole = {"RIG": RIGS[kind], "LOG": log, "LOG2": log, "FIT": FIT_FILE, "PLAN": PLAN}
    files = {key: text.encode() for key, text in whole.items()} | {"RAW": b"".join(STREAM)}
    used = [key for key in files if key in options]
    for key in draw(st.lists(st.sampled_from(used), min_size=int(OFTEN[command] == 1), max_size=2, unique=True)):
        files[key] = draw(_damaged(key, whole.get(key, "")))
    if draw(st.integers(0, 3)) == 0:  # a name that is whole for TOML and means something elsewhere
        renamed = re.sub(r"(?m)^name = .*$", lambda _: f"name = {toml.quoted(draw(texts()))}", RIGS[kind])
        files["RIG"] = renamed.encode("utf-8", "surrogatepass")
    if "PORT" in options:
        files["WIRE"] = draw(frames.damaged(STREAM)) if draw(st.booleans()) else b"".join(STREAM)
    arguments = [names.get(o, o.replace("OUT", "out")) for o in options]
    arguments = [draw(_number()) if o == "N" else draw(_axis(o)) if ":N" in o or "N:" in o else o for o in arguments]
    return Called(
        command,
        tuple(arguments),
        {names.get(k, k): c for k, c in files.items() if k in (*used, "WIRE")},
        draw(st.booleans()),
    )


def _name(text: str) -> str:
    """A text as a file's name, which is no option."""
    return ("a" + text).replace("/", "").replace("\0", "")[:60]


@st.composite
def _number(draw: st.DrawFn) -> str:
    return draw(st.sampled_from((*NUMBERS, "nan", "inf", "-inf", "x", "", *TEXTS[:4])))


@st.composite
def _axis(draw: st.DrawFn, text: str) -> str:
    for _ in range(text.count("N")):
        text = text.replace("N", draw(st.sampled_from(NUMBERS)), 1)
    return text


@st.composite
def _damaged(draw: st.DrawFn, key: str, whole: str) -> bytes:
    if key == "RAW":
        return draw(frames.damaged(STREAM))
    return draw(logs.damaged(whole)) if key in ("LOG", "LOG2") else draw(toml.damaged(whole))


def tried(folder: Path, call: Called) -> tuple[Damaged, Outcome]:
    """A command with its files, to keep, and what comes of it in a folder."""
    line = json.dumps([call.command, *call.arguments]).encode()
    return Damaged("command", {**call.files, "command.json": line}), _called(folder, call)


def _called(folder: Path, call: Called) -> Outcome:
    """What comes of a command, run in a folder."""
    outcome = Outcome()
    for name, content in call.files.items():
        if name != "WIRE":
            (folder / os.fsencode(name).decode("utf-8", "surrogateescape")).write_bytes(content)
    before = contents(folder)
    began = time.monotonic()
    with board(call.files.get("WIRE", b"")) as line:
        arguments = [line.port if a == "PORT" else a for a in call.arguments]
        status, out, err = run([call.command, *arguments], folder, terminal=call.terminal)
    outcome.seconds = time.monotonic() - began
    if status is None:
        return Outcome("failed", [f"{call.command}: hangs"], outcome.seconds)
    outcome.status = {0: "accepted", 2: "refused"}.get(status, "failed")
    outcome.faults += [f"{call.command}: {what}" for what in _said(call, status, out, err)]
    outcome.faults += [f"{call.command}: {what}" for what in _left(folder, before, call, status)]
    return outcome


def contents(folder: Path) -> dict[str, str]:
    """A digest of every file below a folder, by its path."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def run(arguments: list[str], folder: Path, *, terminal: bool) -> tuple[int | None, bytes, bytes]:
    """Status and output of a command, whose stderr may be a terminal; None where it hangs and is killed."""
    with tempfile.TemporaryDirectory() as beside, _terminal() as (name, said):
        out, err = Path(beside) / "out", Path(beside) / "err"
        process = start(arguments, folder, out, name if terminal else err)
        process.join(SECONDS)
        if process.is_alive():
            process.kill()
            process.join()
            return None, b"", b""
        return process.exitcode, out.read_bytes(), said() if terminal else err.read_bytes()


@contextmanager
def _terminal() -> Iterator[tuple[str, Callable[[], bytes]]]:
    """Name of a terminal, and a function that gives what was written to it."""
    master, slave = os.openpty()
    said: list[bytes] = []
    reader = threading.Thread(target=lambda: said.extend(_read(master)), daemon=True)
    reader.start()

    def everything() -> bytes:
        time.sleep(0.05)
        return b"".join(said)

    try:
        yield os.ttyname(slave), everything
    finally:
        os.close(slave)
        reader.join(5.0)
        os.close(master)


def _read(master: int) -> Iterator[bytes]:
    """What comes to a terminal, until nobody writes to it any more."""
    while True:
        try:
            piece = os.read(master, 65_536)
        except OSError:
            return
        if not piece:
            return
        yield piece


class Line:
    """A pseudo terminal at whose other end a board sends the same bytes again and again, a few at a time, and hears nothing.

    Attributes:
        port: Name of the port.
        sent: What was sent so far.
    """

    def __init__(self, wire: bytes) -> None:
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        os.set_blocking(self.master, False)
        self.port, self.wire, self.sent = os.ttyname(self.slave), wire, b""

    def send(self, over: threading.Event) -> None:
        at = 0
        while self.wire and not over.is_set():
            try:
                piece = self.wire[at : at + 64]
                count = os.write(self.master, piece)
                self.sent, at = self.sent + piece[:count], (at + count) % len(self.wire)
            except OSError:
                pass  # nobody reads: the terminal is full
            try:
                os.read(self.master, 4096)
            except OSError:
                pass  # nothing was said
            time.sleep(0.005)


@contextmanager
def board(wire: bytes) -> Iterator[Line]:
    """The line to a board that sends `wire`."""
    line, over = Line(wire), threading.Event()
    thread = threading.Thread(target=line.send, args=(over,), daemon=True)
    thread.start()
    try:
        yield line
    finally:
        over.set()
        thread.join()
        os.close(line.master)
        os.close(line.slave)


NEVER = {"sweep": "settling_s", "size": "time_s"}
"""Columns that say `inf` for what never comes (`docs/files.md`), by command."""
DRAWN = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\r")
"""What progress and live views draw with."""


def _said(call: Called, status: int, out: bytes, err: bytes) -> list[str]:
    """What is wrong with how a command ended, and with what it said."""
    if status not in (0, 2):
        last = [line for line in err.decode("utf-8", "replace").splitlines() if line.strip()][-1:]
        return [f"status {status}, {_kind(last[0]) if last else ''}"]
    found = []
    if b"Traceback" in err:
        found.append("traceback")
    try:
        told, error = out.decode(), err.decode()
    except UnicodeDecodeError:
        return [*found, "output that is not UTF-8"]
    if call.terminal:
        error = DRAWN.sub("\n", error)
    if bad := {c for c in told + error if not (c.isprintable() or c in "\n")}:
        found.append(f"output with {', '.join(sorted(map(ascii, bad)))}")
    lines = [line for line in error.split("\n") if line.strip() and not line.startswith("note: ")]
    if status == 2 and not call.terminal and (len(lines) != 1 or not lines[0].startswith("rwjax: ")):
        found.append(f"status 2 after {len(lines)} lines")
    if status == 2 and told:
        found.append("status 2 after a result on stdout")
    if any(len(line) > 2000 for line in lines):
        found.append("a line of 2 kB")
    if status == 0:
        found += oracle.of_words("result", re.sub(",inf,", ",never,", told) if call.command in NEVER else told)
    if re.search(r"\w+Warning\b", error):
        found.append(f"a warning of Python: {_kind(next(x for x in error.splitlines() if 'Warning' in x))}")
    return found


def _kind(line: str) -> str:
    """A line without what differs from input to input."""
    return re.sub(r"[\d.]+", "0", line)[:100]


def _left(folder: Path, before: dict[str, str], call: Called, status: int) -> list[str]:
    """What is wrong with the files that a command left."""
    after = contents(folder)
    found = ["an input changed" for name, digest in before.items() if after.get(name) != digest]
    new = sorted(after.keys() - before.keys())
    if hidden := [name for name in new if any(part.startswith(".") for part in Path(name).parts)]:
        found.append(f"a temporary file stays: {_kind(hidden[0])}")
    if status == 2 and call.command not in ON_PORT and new:
        found.append(f"status 2 and {_kind(new[0])} written")
    if status == 2 and call.command not in ON_PORT and (folder / "out").exists():
        found.append("status 2 and a folder left")
    return found + [f"{_kind(name)}: {what}" for name in new for what in _unreadable(folder / name, call.command)]


def _unreadable(path: Path, command: str) -> list[str]:
    """What is wrong with a file that a command wrote."""
    checks = {".toml": _toml, ".csv": partial(_csv, never=NEVER.get(command)), ".json": _json, ".html": _html}
    check = checks.get(path.suffix)
    return check(path) if check else []


def _toml(path: Path) -> list[str]:
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
        if path.name != "plan.toml" and "kind" in document:
            parse_rig(path.read_text(encoding="utf-8"))
    except (InputError, ValueError) as error:
        return [f"written and refused ({type(error).__name__})"]
    return []


def _csv(path: Path, never: str | None) -> list[str]:
    lines = path.read_text(encoding="utf-8").split("\n")
    if lines[-1] or len(lines) < 2:
        return ["not whole"]
    if any(line.startswith("# add ") for line in lines):
        return ["a note injected"]
    rows = list(csv.reader(io.StringIO("\n".join(line for line in lines if not line.startswith("#")))))
    if any(len(row) != len(rows[0]) for row in rows):
        return ["rows of several lengths"]
    cells = [cell.lower() for row in rows[1:] for name, cell in zip(rows[0], row, strict=True) if name != never]
    bad = {"nan", "inf", "-inf"} & {*cells}
    return [f"holds {sorted(bad)[0]}"] if bad else []


def _json(path: Path) -> list[str]:
    try:
        json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse)
    except ValueError:
        return ["no JSON"]
    return []


def _refuse(word: str) -> None:
    raise ValueError(word)


def _html(path: Path) -> list[str]:
    text = path.read_text(encoding="utf-8")
    return [*(["not whole"] if "</html>" not in text else []), *(["a script injected"] if "<script>" in text else [])]
