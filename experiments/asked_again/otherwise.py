"""The same rig and the same logs, written down otherwise: nothing of what they say of the rig changes.

There are two exceptions. The first guess of a free number says where a fit begins and not what is true. Twice the counts also say that rounding
is half as large as it was.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tomlkit
from tomlkit import TOMLDocument

COUNTS = 2
"""Times as many counts, of as many counts a turn."""
LATER = 1000.0  # s
FACTOR = 2.0
"""Between a first guess and the one of the file at most."""
TURNS_OVER = ("voltage_V", "yaw_", "wheel_", "current_A", "position_m")
"""Beginnings of the columns that change their sign where the axis is counted the other way round."""


class Written(NamedTuple):
    """A log file: its notes, the names of its columns, and its values `(time, columns)`."""

    notes: list[str]
    columns: list[str]
    values: np.ndarray

    def times(self, factor: float, *beginnings: str) -> "Written":
        """The same with the columns of which the names begin so multiplied by a factor."""
        scaled = [factor if name.startswith(beginnings) else 1.0 for name in self.columns]
        return self._replace(values=self.values * np.array(scaled))


class Question(NamedTuple):
    """A rig file and the log files by name, in the order in which they are given."""

    rig: TOMLDocument
    logs: dict[str, Written]

    def each(self, change: Callable[[Written], Written]) -> "Question":
        """The same with every log changed."""
        return self._replace(logs={name: change(log) for name, log in self.logs.items()})


def read_question(rig: Path, logs: list[Path]) -> Question:
    """A question from its files."""
    found = {}
    for path in logs:
        lines = path.read_text().splitlines()
        notes = [line for line in lines if line.startswith("#")]
        header, *rows = [line for line in lines if not line.startswith("#")]
        values = np.array([[float(cell or "nan") for cell in row.split(",")] for row in rows])
        found[path.name] = Written(notes, header.split(","), values)
    return Question(tomlkit.parse(rig.read_text()), found)


def write_question(question: Question, folder: Path) -> tuple[Path, list[Path]]:
    """Writes a question's files into a folder; they sort in the order in which they are given."""
    (rig := folder / "rig.toml").write_text(tomlkit.dumps(question.rig))
    paths = []
    for k, (name, log) in enumerate(question.logs.items()):
        rows = [",".join("" if np.isnan(v) else f"{v:.12g}" for v in row) for row in log.values]
        paths.append(folder / f"{k:02d}_{name}")
        paths[-1].write_text("\n".join([*log.notes, ",".join(log.columns), *rows, ""]))
    return rig, paths


def _copy(question: Question) -> Question:
    return question._replace(rig=tomlkit.parse(tomlkit.dumps(question.rig)))


def other_guesses(question: Question, seed: int) -> Question:
    """Other first guesses of the free numbers, within a factor of two of those of the file."""
    other, rng = _copy(question), np.random.default_rng(seed)
    for name in question.rig.get("fit", {}).get("free", []):
        *tables, key = name.split(".")
        table = other.rig
        for part in tables:
            table = table.get(part, {})
        if isinstance(table.get(key), int | float):
            table[key] = float(table[key]) * float(FACTOR ** rng.uniform(-1.0, 1.0))
    return other


def turned_over(question: Question) -> Question:
    """The axis counted the other way round, with the command and all that it drives."""
    other = _copy(question).each(lambda log: log.times(-1.0, *TURNS_OVER))
    gravity = other.rig.get("axis", {}).get("gravity", {})
    if "angle" in gravity:
        gravity["angle"] = -float(gravity["angle"])
    return other


def later(question: Question) -> Question:
    """A clock that was started earlier."""
    return question.each(
        lambda log: log._replace(values=log.values + np.array([LATER * (name == "time_s") for name in log.columns]))
    )


def the_other_way_round(question: Question) -> Question:
    """The logs in reverse order."""
    return question._replace(logs=dict(reversed(question.logs.items())))


def in_other_units(question: Question) -> Question:
    """Time in milliseconds, angles in degrees, speeds in turns a minute, as `[columns]` says."""
    other, units = _copy(question), {"time_s": ("ms", 1e3), "yaw_rad": ("deg", 180.0 / np.pi)}
    units |= {"yaw_rad_s": ("deg/s", 180.0 / np.pi), "wheel_rad_s": ("rpm", 30.0 / np.pi)}
    held = {name for log in question.logs.values() for name in log.columns}
    table = other.rig.setdefault("columns", tomlkit.table())
    for name in sorted(held):
        line = tomlkit.inline_table()
        line["column"] = f"my {name}" if name in units else name
        if name in units:
            line["unit"] = units[name][0]
        table[name] = line
    other = other.each(
        lambda log: log._replace(
            values=log.values * np.array([units[name][1] if name in units else 1.0 for name in log.columns])
        )
    )
    return other.each(
        lambda log: log._replace(columns=[f"my {name}" if name in units else name for name in log.columns])
    )


def finer_counts(question: Question) -> Question:
    """Twice the counts of twice the counts a turn."""
    other = _copy(question).each(lambda log: log.times(COUNTS, "yaw_counts", "wheel_counts"))
    for name in ("encoder", "wheel_encoder"):
        if name in other.rig:
            other.rig[name]["counts_per_rev"] = COUNTS * other.rig[name]["counts_per_rev"]
    return other


def defaults_said(question: Question) -> Question:
    """Keys that say what is taken without them."""
    other = _copy(question)
    if "motor" in other.rig:
        other.rig["motor"].setdefault("inductance", 0.0)
    if "gravity" in other.rig.get("axis", {}):
        other.rig["axis"]["gravity"].setdefault("angle", 0.0)
    other.rig.setdefault("name", "rig")
    return other


WAYS: dict[str, Callable[[Question], Question]] = {
    "other first guesses": lambda q: other_guesses(q, 1),
    "yet other first guesses": lambda q: other_guesses(q, 2),
    "counted the other way round": turned_over,
    "a clock started earlier": later,
    "logs in reverse order": the_other_way_round,
    "other units": in_other_units,
    "twice the counts": finer_counts,
    "defaults said": defaults_said,
}
"""Ways to ask the same question, by what differs."""
