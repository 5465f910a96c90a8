"""One damaged input through what the commands do with it, within this process, and what is wrong with the outcome."""

import signal
import time
import traceback
import warnings
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

import numpy as np
from hypothesis import strategies as st

from rwjax import InputError, Log, Rig, fit, parse_rig, predict, read_log, read_logs, read_rig, region, write_rig
from rwjax.fitting.problem import pose
from rwjax.link.frames import Decoder
from rwjax.link.stream import stretches
from rwjax.link.stream_to_logs import write_logs
from rwjax.planning.files import Run, read_plan, write_plan
from rwjax.plant.from_rig import structure_of
from tests.damage import frames, logs, oracle, toml
from tests.damage.values import spoilt, texts
from tests.damage.whole import FORMS, LOGS, PLAN, RIGS, STREAM
from tests.link.ports import RIG as ON_BOARD

SLOW_S = 10.0
"""Time of the processor [s] beyond which an input takes too long. One that does is tried again, with its programs compiled."""
GIVE_UP_S = 60
"""After which it is given up [s]."""
GAINS = np.array([1.0, 30.0]), np.array([0.5, 5.0])
LIBRARY = str(Path(__file__).parents[2] / "rwjax")


@dataclass(frozen=True)
class Damaged:
    """A damaged input.

    Attributes:
        kind: What is damaged: "rig", "log", "rig and log", "form" (a log that is no plain text), "plan" or "frames".
        files: Contents by the names of the files, in the order in which a command takes them.
    """

    kind: str
    files: dict[str, bytes]

    @property
    def lot(self) -> int:
        """A number that is the same whenever this input is tried, by which few are chosen for what takes long."""
        return zlib.crc32(b"\0".join(self.files.values()))


@dataclass
class Outcome:
    """What came of an input.

    Attributes:
        status: "accepted", "refused" or "failed".
        faults: What is wrong, by the kind of fault.
        seconds: Time of the processor [s].
    """

    status: str = "accepted"
    faults: list[str] = field(default_factory=list)
    seconds: float = 0.0


@dataclass
class Shares:
    """How much of what takes long is tried.

    Attributes:
        programs: How many programs may still be compiled for free runs; none more are simulated after that.
        fits: One in so many accepted inputs is fitted, 0 for none.
        regions: One in so many has its region of gains worked out.
        known: What programs there are.
    """

    programs: int
    fits: int
    regions: int
    known: set = field(default_factory=set)

    def simulated(self, rig: Rig, log: Log) -> bool:
        """Whether a free run may be tried: its program is there, or one more may be compiled."""
        structure = structure_of(rig)
        batch = pose(structure, (log,)).batch
        key = structure, tuple(np.shape(array) for array in batch)
        if key not in self.known and len(self.known) < self.programs:
            self.known.add(key)
        return key in self.known


@st.composite
def inputs(draw: st.DrawFn, *, vast: bool = False) -> Damaged:
    """A damaged rig file, log, both, plan or stream; `vast`: very seldom of 10 MB."""
    kind = draw(st.sampled_from(("rig",) * 4 + ("log",) * 4 + ("rig and log", "form", "plan", "plan", "frames")))
    if kind == "plan":
        return Damaged(kind, {"plan.toml": draw(toml.damaged(PLAN, vast=vast))})
    if kind == "frames":
        return Damaged(kind, {"run.raw": draw(frames.damaged(STREAM)), "run.notes": draw(frames.notes())})
    if kind == "form":
        rig, form = draw(st.sampled_from(("columns", "joint"))), draw(st.sampled_from(tuple(FORMS)))
        return Damaged(kind, {"rig.toml": RIGS[rig].encode(), f"run.{form}": draw(spoilt(FORMS[form]))})
    rig = draw(st.sampled_from(tuple(RIGS)))
    text, log = RIGS[rig].encode(), draw(st.sampled_from(LOGS[rig])).encode()
    if "rig" in kind:
        text = draw(toml.damaged(RIGS[rig], vast=vast))
    if "log" in kind:
        log = draw(logs.damaged(log.decode(), vast=vast))
    name = draw(texts()) if draw(st.integers(0, 19)) == 0 else "run"
    return Damaged(kind, {"rig.toml": text, f"{_file_name(name)}.csv": log})


def _file_name(text: str) -> str:
    """A text as far as a file may be called so."""
    return text.replace("/", "").replace("\0", "").encode("utf-8", "replace")[:200].decode("utf-8", "ignore")


class TooLong(BaseException):
    """The time for an input is over."""


def tried(folder: Path, damaged: Damaged, shares: Shares) -> Outcome:
    """What comes of an input, whose files are put into a folder."""
    outcome = _tried(folder, damaged, shares)
    if outcome.seconds > SLOW_S:
        outcome = _tried(folder, damaged, shares)
    if outcome.seconds > SLOW_S:
        outcome.faults.append(f"slow: {damaged.kind}")
    return outcome


def _tried(folder: Path, damaged: Damaged, shares: Shares) -> Outcome:
    """What comes of an input the first time or the second."""
    outcome, began = Outcome(), time.process_time()
    for name, content in damaged.files.items():
        (folder / name).write_bytes(content)
    steps = {"plan": _plan, "frames": _frames}.get(damaged.kind, _rig_and_log)
    with warnings.catch_warnings(record=True) as warned, _limited():
        warnings.simplefilter("always")
        try:
            outcome.faults += steps(folder, damaged, shares)
        except InputError as error:
            outcome.status = "refused"
            outcome.faults += oracle.of_message(str(error))
        except (Exception, TooLong) as error:
            outcome.status = "failed"
            outcome.faults.append(_traceback(error))
    outcome.faults += sorted({f"warning: {w.category.__name__} {_where(w.filename, w.lineno)}" for w in warned})
    outcome.seconds = time.process_time() - began
    return outcome


@contextmanager
def _limited() -> Iterator[None]:
    """Raises `TooLong` in the block when it has taken too much of the processor's time."""

    def over(number: int, frame: FrameType | None) -> None:
        raise TooLong

    before = signal.signal(signal.SIGPROF, over)
    signal.setitimer(signal.ITIMER_PROF, GIVE_UP_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def _traceback(error: BaseException) -> str:
    """The kind of an error and where in the library it was raised."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename.startswith(LIBRARY)]
    at = (
        _where(frames[-1].filename, frames[-1].lineno or 0) + f" {frames[-1].name}" if frames else "outside the library"
    )
    return f"traceback: {type(error).__name__} {at}"


def _where(path: str, line: int) -> str:
    return f"{path.removeprefix(LIBRARY + '/').rpartition('site-packages/')[2]}:{line}"


def _rig_and_log(folder: Path, damaged: Damaged, shares: Shares) -> Iterator[str]:
    """A rig file and a log, as `predict`, `region` and `fit` take them."""
    rig_path, log_path = (folder / name for name in damaged.files)
    rig = read_rig(rig_path)
    yield from (f"nonsense: {what}" for what in oracle.of_rig(rig))
    yield from _written(rig)
    log = read_log(log_path, rig, outputs_required=False)
    str(log)
    yield from (f"nonsense: {what}" for what in oracle.of_log(log))
    if shares.simulated(rig, log):
        yield from oracle.of_numbers("nonsense: prediction", predict(rig, log).columns.values())
    if shares.regions and damaged.lot % shares.regions == 0:
        yield from _refusal(lambda: _region(rig))
    if shares.fits and damaged.lot % shares.fits == 0:
        yield from _refusal(lambda: _fit(rig, log_path))


def _refusal(steps: Callable[[], list[str]]) -> list[str]:
    """What is wrong with what several commands may refuse, each for itself."""
    try:
        return steps()
    except InputError as error:
        return list(oracle.of_message(str(error)))


def _written(rig: Rig) -> Iterator[str]:
    """A rig printed, and written as a file and read again."""
    str(rig)
    try:
        again = parse_rig(write_rig(rig))
    except InputError:
        yield "round trip: a rig file written that the reader refuses"
    else:
        if again != rig:
            yield "round trip: a rig file written that reads otherwise"


def _region(rig: Rig) -> list[str]:
    if rig.kind not in ("platform", "reaction"):
        return []
    found = region(rig, *GAINS)
    return [*oracle.of_words("nonsense: region", str(found))]


def _fit(rig: Rig, log: Path) -> list[str]:
    result = fit(rig, read_logs([log], rig))
    values = [
        np.array([number["value"] for number in result.json()["numbers"].values()]),
        *map(np.array, result.rms.values()),
    ]
    said = [*oracle.of_numbers("nonsense: fit", values), *oracle.of_words("nonsense: fit", str(result))]
    return [*said, *_written(result.rig)]


def _plan(folder: Path, damaged: Damaged, shares: Shares) -> Iterator[str]:
    """A plan, read and written with the logs of its runs."""
    plan = read_plan(folder)
    yield from (f"nonsense: {what}" for what in oracle.of_plan(plan))
    if any(run.experiment.length > 1000.0 for run in plan.runs):
        return  # its logs would be long
    target = folder / "written"
    target.mkdir(exist_ok=True)
    write_plan(target, plan)
    if [_said(run) for run in read_plan(target).runs] != [_said(run) for run in plan.runs]:
        yield "round trip: a plan written that reads otherwise"
    for run in plan.runs:
        yield from oracle.of_run_file((target / f"{run.name}.csv").read_bytes().decode(), run.role)


def _said(run: Run) -> tuple:
    """What a plan's file says of a run to every digit."""
    return run.name, run.experiment, run.role, run.why, run.tells_apart


def _frames(folder: Path, damaged: Damaged, shares: Shares) -> Iterator[str]:
    """A stream, decoded whole and in pieces, made into logs that are read again."""
    raw = folder / "run.raw"
    data, size = raw.read_bytes(), 1 + damaged.lot % 60
    whole, pieces = Decoder(), Decoder()
    frames = list(whole.feed(data))
    if frames != [f for k in range(0, len(data), size) for f in pieces.feed(data[k : k + size])]:
        yield "frames: read otherwise in pieces"
    if whole.damaged != pieces.damaged:
        yield "frames: damage counted otherwise in pieces"
    for stretch in stretches(data)[0]:
        if (np.diff(stretch.tick) <= 0).any():
            yield "frames: ticks go back"
    for path in folder.glob("run*.csv"):
        path.unlink()
    written, _ = write_logs(raw, ON_BOARD, folder / "run.csv")
    for path in written:
        log = read_log(path, ON_BOARD)
        yield from (f"nonsense: {what}" for what in oracle.of_log(log))
