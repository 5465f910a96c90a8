"""The results of a fleet on disk: Parquet files that are added as rows come, and one of all rows in the end.

A row is found by its rig, its session and the state of its files. So a run that was killed goes on where it was, and a rig whose logs
have changed is done again. Of two rows the later one counts.
"""

import fcntl
import io
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import polars as pl

from rwjax import __version__
from rwjax.errors import InputError, printable
from rwjax.fleet.plan import FleetPlan, Job
from rwjax.text_files import read_text, write_files, write_text

RESULTS, PARTS, ABOUT, REPORTS, LOCK = "results.parquet", "parts", "fleet.json", "reports", "lock"
"""All rows; the folder of those that came since; what they are results of; the folder of reports; what the writing process holds."""


def schema() -> dict[str, Any]:
    """Columns of the results.

    Returns:
        Type of each by its name; what a command does not give is null.
    """
    number = pl.Struct({"name": pl.String, "value": pl.Float64, "standard_error": pl.Float64})
    return {
        **{name: pl.String for name in ("rig", "when", "command", "inputs", "status", "line")},
        "seconds": pl.Float64,
        "verdict": pl.String,
        "effects": pl.List(pl.String),
        "signal": pl.String,
        **{name: pl.Float64 for name in ("before", "after", "floor", "closed")},
        "numbers": pl.List(number),
        "covariance": pl.List(pl.Float64),
        "misfit": pl.Float64,
        "answer": pl.String,
    }


class Store:
    """The folder of a fleet's results, which one process writes at a time: it holds it as a context.

    Args:
        folder: Its path; it is made where it is not there.
        plan: What the results are of.

    Raises:
        InputError: The folder cannot be made, another process writes it, or it holds results of another command, of other options or of
            another version.
    """

    def __init__(self, folder: Path, plan: FleetPlan) -> None:
        self.folder = folder
        about = json.dumps({"command": plan.command, "options": plan.options, "rwjax": __version__}, sort_keys=True)
        try:
            (folder / PARTS).mkdir(parents=True, exist_ok=True)
            self._held = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise InputError(f"{folder}: cannot make this folder ({error.strerror}); give another with -o") from None
        try:
            self._hold()
            if (folder / ABOUT).exists():
                if (old := read_text(folder / ABOUT, InputError)) != about:
                    raise InputError(
                        f"{folder}: holds results of {_in_words(old)}, not of {_in_words(about)}; give another folder with -o"
                    )
            else:
                write_text(folder / ABOUT, about, InputError)
        except InputError:
            os.close(self._held)
            raise
        self._added = max((int(path.stem) for path in self._parts()), default=0)

    def _hold(self) -> None:
        try:
            fcntl.flock(self._held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"{self.folder}: another process writes results there; wait for it, or give another with -o"
            ) from None
        except OSError:
            pass  # a file system without locks

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, *error: object) -> None:
        os.close(self._held)

    def _parts(self) -> list[Path]:
        return sorted(path for path in (self.folder / PARTS).glob("*.parquet") if path.stem.isdigit())

    def add(self, rows: Sequence[dict[str, Any]]) -> None:
        """Adds rows.

        Args:
            rows: The rows.

        Raises:
            InputError: They cannot be written.
        """
        if rows:
            self._added += 1
            _write(pl.DataFrame(list(rows), schema=schema()), self.folder / PARTS / f"{self._added:09d}.parquet")

    def left(self, jobs: Sequence[Job]) -> list[Job]:
        """Jobs that are not done, or were done with other files than there are now.

        Args:
            jobs: The jobs.

        Returns:
            Those that are left, in the same order.

        Raises:
            InputError: A file of the folder is none of this program's.
        """
        names = ("rig", "when", "inputs", "status")
        rows = _latest([_read(path, names) for path in (self.folder / RESULTS, *self._parts())], names)
        done = set(rows.filter(status="done").select(names[:3]).iter_rows())
        return [job for job in jobs if (job.rig, job.when, job.inputs()) not in done]

    def gathered(self) -> pl.DataFrame:
        """Writes all rows into one file, in the place of those that came since.

        Returns:
            The latest row of each rig and session, sorted by both.

        Raises:
            InputError: They cannot be written, or a file of the folder is none of this program's.
        """
        parts, names = self._parts(), tuple(schema())
        found = _latest([_read(path, names) for path in (self.folder / RESULTS, *parts)], names).sort("rig", "when")
        if parts or not (self.folder / RESULTS).exists():
            _write(found, self.folder / RESULTS)
            for part in parts:
                part.unlink(missing_ok=True)
        return found


def _in_words(about: str) -> str:
    """What results are of, as a plan has it."""
    try:
        held = json.loads(about)
        options = [f"{name} = {json.dumps(value)}" for name, value in held["options"].items()]
        return ", ".join([f'command = "{held["command"]}"', *options, f"rwjax {held['rwjax']}"])
    except (ValueError, KeyError, TypeError, AttributeError):
        return "what rwjax did not write"


def _read(path: Path, names: tuple[str, ...]) -> pl.DataFrame:
    """Some columns of a file; of one that is not there, none of their rows."""
    wanted: Any = {name: kind for name, kind in schema().items() if name in names}
    if not path.exists():
        return pl.DataFrame(schema=wanted)
    try:
        return pl.read_parquet(path, columns=list(wanted)).cast(wanted)
    except (OSError, pl.exceptions.PolarsError) as bad:
        said = printable(str(bad).split("\n")[0])
        raise InputError(f"{path}: is no table of results: {said}; remove it, and its rigs are done again") from None


def _latest(tables: Sequence[pl.DataFrame], names: tuple[str, ...]) -> pl.DataFrame:
    """The latest row of each rig and session, in the order in which they came."""
    columns = [name for name in schema() if name in names]
    return pl.concat(one.select(columns) for one in tables).unique(["rig", "when"], keep="last", maintain_order=True)


def _write(table: pl.DataFrame, path: Path) -> None:
    """Writes a table whole or not at all."""
    file = io.BytesIO()
    table.write_parquet(file)
    write_files({str(path): file.getvalue()}, InputError)
