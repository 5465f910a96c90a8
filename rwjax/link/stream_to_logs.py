"""Logs made of a raw stream: its stretches in the columns of a log file, with notes on what was lost."""

import re
from pathlib import Path

import numpy as np

from rwjax.errors import LogError, printable
from rwjax.link.channels import channels, check_board, pwm_of
from rwjax.link.stream import MOST_LOST, WRAP, Stretch, counted, read_stream
from rwjax.logs.sheet import FEWEST
from rwjax.logs.write import write_log
from rwjax.planning.experiment import REST_S, TICK_HZ, length_in
from rwjax.rig.model import Rig
from rwjax.text_files import read_text

COLUMNS = {"axis": "yaw_counts", "wheel": "wheel_counts"}
"""Columns of a log by what the encoder sits on."""


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
    hertz = stretch.hello.tick_hz if stretch.hello else TICK_HZ
    return {
        "time_s": (stretch.tick - stretch.tick[0]) / hertz,
        "voltage_V": np.round((stretch.pulse[:, output] / 2.0 - pwm.neutral_us) * pwm.volts_per_us, 9),
        **{COLUMNS[who]: stretch.count[:, k] for who, k in encoders.items()},
        **({"supply_V": stretch.battery / 1000.0} if stretch.battery.all() else {}),
    }


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
    notes |= {key: "; ".join(said) for key, said in (("counts", counts), ("ended", ended)) if said}
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
    """When a run ended, in words, where that was before the end of its experiment; nothing where that is not known."""
    playing, length = [s for s in found if s.playing.any()], length_in(experiment)
    if not playing or length is None:
        return []
    first, last = playing[0], playing[-1]
    ticks = int(last.tick[last.playing][-1] - first.tick[first.playing][0]) % WRAP + 1
    hertz, wanted = first.hello.tick_hz if first.hello else TICK_HZ, REST_S + length
    if ticks + 2 * MOST_LOST >= hertz * wanted:  # samples may have been lost at either end
        return []
    return [f"early, after {ticks / hertz:g} s of {wanted:g} s"]


def _write(path: Path, stretch: Stretch, rig: Rig, notes: dict[str, str]) -> list[str]:
    """Writes one stretch as a log; remarks on its gaps and on what went wrong on the board."""
    about = notes | {"firmware": f"{stretch.hello.firmware:08x}"} if stretch.hello else notes
    table = columns(stretch, rig)
    no_supply = [] if "supply_V" in table else [f"{path.name}: the battery reads 0 V, so `supply_V` is left out"]
    gaps = [f"{counted(n, 'sample')} before {table['time_s'][k]:.2f} s" for k, n in stretch.gaps()]
    troubles = stretch.troubles()
    said = {"gap": "; ".join(gaps), "board": "; ".join(troubles)}
    write_log(path, table, about | {key: value for key, value in said.items() if value})
    return [
        *(f"{path.name}: gap of {gap}" for gap in gaps),
        *(f"{path.name}: the board: {trouble}" for trouble in troubles),
        *no_supply,
    ]


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
