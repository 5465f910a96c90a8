"""Logs made of a raw stream: its stretches in the columns of a log file, with notes on what was lost."""

import re
from pathlib import Path

import numpy as np

from rwjax.errors import LogError, counted, printable
from rwjax.link.channels import channels, check_board, pwm_of
from rwjax.link.stream import WRAP, Stretch, read_stream
from rwjax.logs.sheet import FEWEST
from rwjax.logs.write import write_log
from rwjax.planning.experiment import REST_S, TICK_HZ, length_in
from rwjax.rig.model import Rig
from rwjax.text_files import read_text

COLUMNS = {"axis": "yaw_counts", "wheel": "wheel_counts"}
"""Columns of a log by what the encoder sits on."""
UNMARKED = 1
"""Ticks at the end of an experiment that a board plays and does not mark as played."""


def columns(stretch: Stretch, rig: Rig) -> dict[str, np.ndarray]:
    """A stretch as the columns of a log.

    Args:
        stretch: The stretch, `n` samples.
        rig: The rig that hung on the board.

    Returns:
        Columns (n,) by name, in the units of their names; time counts from the first sample, in the board's ticks. There
        is no `supply_V` where the battery ever reads 0, as it does on a board that is fed over USB alone.

    Raises:
        RigError: Where the rig file says nothing about pulses or counts.
    """
    pwm, (output, encoders) = pwm_of(rig), channels(rig)
    return {
        "time_s": (stretch.tick - stretch.tick[0]) / _hertz(stretch),
        "voltage_V": np.round((stretch.pulse[:, output] / 2.0 - pwm.neutral_us) * pwm.volts_per_us, 9),
        **{COLUMNS[who]: stretch.count[:, k] for who, k in encoders.items()},
        **({"supply_V": stretch.battery / 1000.0} if stretch.battery.all() else {}),
    }


def _hertz(stretch: Stretch) -> int:
    return stretch.hello.tick_hz if stretch.hello else TICK_HZ


def refuse_existing(*paths: Path) -> None:
    """Checks that files are not there yet.

    Args:
        *paths: The files.

    Raises:
        LogError: For the first that is there.
    """
    for path in paths:
        if path.exists():
            raise LogError(f"{path}: exists already; a recording never replaces another, give a new name with -o")


def write_logs(raw: Path, rig: Rig, output: Path) -> tuple[list[Path], list[str]]:
    """Writes the logs in a raw stream. Of an experiment, they hold the part that was played.

    Args:
        raw: The raw stream (`.raw`); notes come from the file beside it (`.notes`).
        rig: The rig that hung on the board.
        output: Name of the log; where the stream falls into several stretches, `output-1`, `output-2` and so on.

    Returns:
        The logs that were written, and remarks on what was lost or left out.

    Raises:
        LogError: Where the stream cannot be read, has no time, or one of the logs is there already; then none is written.
        RigError: Where the board was set up for another rig; then none is written.
    """
    pwm_of(rig)
    notes = read_notes(raw.with_suffix(".notes"))
    all_found, damaged = read_stream(raw)
    hellos = dict.fromkeys(s.hello for s in all_found if s.hello)
    if any(hello.tick_hz == 0 for hello in hellos):
        raise LogError(f"{raw}: the board says that it ticks 0 times a second; is this its stream, and undamaged?")
    counts = list(dict.fromkeys(remark for hello in hellos for remark in check_board(hello, rig)))
    found, left_out = _worth_a_log(all_found, "experiment" in notes)
    ended = _early_end(all_found, notes.get("experiment", ""))
    remarks = [*counts, *left_out, *(f"the run ended {end}" for end in ended)]
    if damaged:
        remarks.append(counted(damaged, "damaged frame"))
    notes = _noted(notes, counts=counts, ended=ended)
    names = [output] if len(found) == 1 else [numbered(output, k + 1) for k in range(len(found))]
    refuse_existing(*names)
    for name, stretch in zip(names, found, strict=True):
        remarks += _write(name, stretch, rig, notes)
    return names, remarks


def _worth_a_log(found: list[Stretch], experiment: bool) -> tuple[list[Stretch], list[str]]:
    """The stretches that become logs, of an experiment what was played, and remarks on the others."""
    played, remarks = [s.only(s.playing) if s.playing.any() else s for s in found], []
    if experiment:
        played = [s for s in played if s.playing.any()]
        if idle := len(found) - len(played):
            remarks.append(_left_out(idle, "in which nothing was played"))
    long = [s for s in played if len(s.tick) >= FEWEST]
    if short := len(played) - len(long):
        remarks.append(_left_out(short, f"of under {FEWEST} samples"))
    return long, remarks


def _left_out(number: int, which: str) -> str:
    return f"{counted(number, 'stretch', 'es')} {which} {'is' if number == 1 else 'are'} left out"


def _early_end(found: list[Stretch], experiment: str) -> list[str]:
    """When a run ended, in words, where that was before the end of its experiment; nothing where that is not known.

    Samples may be lost at either end, so the run may have lasted from the idle sample before it to the idle one behind it.
    """
    length, starts = length_in(experiment), [s for s in _starts(found) if any(one.playing.any() for one in s)]
    if length is None or len(starts) != 1:
        return []
    (own,) = starts
    tick = np.concatenate([(s.tick - own[0].tick[0]) % WRAP for s in own])
    first, last = np.flatnonzero(np.concatenate([s.playing for s in own]))[[0, -1]]
    seen = tick[last] - tick[first] + 1
    before = tick[first] - tick[first - 1] - 1 if first else 0
    behind = tick[last + 1] - tick[last] - 1 if last + 1 < len(tick) else 0
    longest, hertz, wanted = seen + before + behind, _hertz(own[-1]), REST_S + length
    if longest + UNMARKED >= round(hertz * wanted):
        return []
    return [f"early, after {'at most ' * bool(longest > seen)}{longest / hertz:g} s of {wanted:g} s"]


def _starts(found: list[Stretch]) -> list[list[Stretch]]:
    """The stretches of each start of the board."""
    starts: list[list[Stretch]] = []
    for one in found:
        if starts and _same_start(starts[-1][-1], one):
            starts[-1].append(one)
        else:
            starts.append([one])
    return starts


def _same_start(earlier: Stretch, later: Stretch) -> bool:
    """Whether the board has not started anew between two stretches, by what it said of itself and by its ticks."""
    numbers = {s.hello.nonce for s in (earlier, later) if s.hello}
    return len(numbers) < 2 and bool((later.tick[0] - earlier.tick[-1]) % WRAP < WRAP // 2)


def _write(path: Path, stretch: Stretch, rig: Rig, notes: dict[str, str]) -> list[str]:
    """Writes one stretch as a log; remarks on its gaps and on what went wrong on the board."""
    about = notes | {"firmware": f"{stretch.hello.firmware:08x}"} if stretch.hello else notes
    table = columns(stretch, rig)
    no_supply = [] if "supply_V" in table else [f"{path.name}: the battery reads 0 V, so `supply_V` is left out"]
    gaps = [f"{counted(n, 'sample')} before {table['time_s'][k]:.2f} s" for k, n in stretch.gaps()]
    troubles = stretch.troubles()
    write_log(path, table, _noted(about, gap=gaps, board=troubles))
    return [
        *(f"{path.name}: gap of {gap}" for gap in gaps),
        *(f"{path.name}: the board: {trouble}" for trouble in troubles),
        *no_supply,
    ]


def _noted(notes: dict[str, str], **more: list[str]) -> dict[str, str]:
    """Notes with more of them, behind what somebody has noted under the same keys."""
    return notes | {key: "; ".join([*filter(None, [notes.get(key)]), *said]) for key, said in more.items() if said}


def numbered(output: Path, k: int) -> Path:
    """The name of one of several logs.

    Args:
        output: The name that a single log would have.
        k: Number of the log, from 1.

    Returns:
        `run-2.csv` for the second of `run.csv`.
    """
    return output.with_stem(f"{output.stem}-{k}")


def read_notes(path: Path) -> dict[str, str]:
    """The notes beside a raw stream, lines `key: value`. Other lines are passed over.

    Args:
        path: The file (`.notes`), which need not be there.

    Returns:
        Notes by key.

    Raises:
        LogError: Where the file is there and cannot be read.
    """
    if not path.exists():
        return {}
    pairs = (re.sub(r"^[\s#]+", "", line).partition(":") for line in read_text(path, LogError).split("\n"))
    return {printable(key.strip()): value.strip() for key, colon, value in pairs if colon and key.strip()}
