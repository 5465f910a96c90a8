"""The results of a fleet on disk: Parquet files that are added as rows come, and one of all rows in the end.

A row is found by its rig, its session and the state of its files. So a run that was killed goes on where it was, and a rig whose logs
have changed is done again. Of two rows the later one counts.
"""

import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rwjax import __version__
from rwjax.errors import InputError
from rwjax.fleet.plan import FleetPlan, Job
from rwjax.text_files import read_text, write_files, write_text

if TYPE_CHECKING:
    import polars as pl

RESULTS, PARTS, ABOUT, REPORTS = "results.parquet", "parts", "fleet.json", "reports"
"""All rows; the folder of those that came since; what they are results of; the folder of reports."""


def schema() -> "pl.Schema":
    """Columns of the results.

    Returns:
        Type of each by its name; what a command does not give is null.
    """
    import polars as pl

    number = pl.Struct({"name": pl.String, "value": pl.Float64, "standard_error": pl.Float64})
    columns = {
        "rig": pl.String,
        "when": pl.String,
        "command": pl.String,
        "inputs": pl.String,
        "status": pl.String,
        "line": pl.String,
        "seconds": pl.Float64,
        "verdict": pl.String,
        "effects": pl.List(pl.String),
        "signal": pl.String,
        "before": pl.Float64,
        "after": pl.Float64,
        "floor": pl.Float64,
        "closed": pl.Float64,
        "numbers": pl.List(number),
        "covariance": pl.List(pl.Float64),
        "misfit": pl.Float64,
        "answer": pl.String,
    }
    return pl.Schema(columns)


class Store:
    """The folder of a fleet's results. One process writes it.

    Args:
        folder: Its path; it is made where it is not there.
        plan: What the results are of.

    Raises:
        InputError: The folder cannot be made, or holds results of another command, of other options or of another version.
    """

    def __init__(self, folder: Path, plan: FleetPlan) -> None:
        self.folder = folder
        about = json.dumps({"command": plan.command, "options": plan.options, "rwjax": __version__}, sort_keys=True)
        try:
            (folder / PARTS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot make this folder ({error.strerror}); give another with -o") from None
        if (folder / ABOUT).exists():
            if (old := read_text(folder / ABOUT, InputError)) != about:
                raise InputError(f"{folder}: holds results of {old}, not of {about}; give another folder with -o")
        else:
            write_text(folder / ABOUT, about, InputError)
        self._added = max((int(path.stem) for path in self._parts()), default=0)

    def _parts(self) -> list[Path]:
        return sorted(path for path in (self.folder / PARTS).glob("*.parquet") if path.stem.isdigit())

    def add(self, rows: Sequence[dict[str, Any]]) -> None:
        """Adds rows.

        Args:
            rows: The rows.

        Raises:
            InputError: They cannot be written.
        """
        import polars as pl

        if rows:
            self._added += 1
            _write(pl.DataFrame(list(rows), schema=schema()), self.folder / PARTS / f"{self._added:09d}.parquet")

    def rows(self) -> "pl.DataFrame":
        """All rows, the latest of each rig and session.

        Returns:
            The table, sorted by rig and session.

        Raises:
            InputError: A file is none of this program's.
        """
        import polars as pl

        files = [path for path in (self.folder / RESULTS, *self._parts()) if path.exists()]
        tables = []
        for path in files:
            try:
                tables.append(pl.read_parquet(path).cast(schema()))
            except (OSError, pl.exceptions.PolarsError) as bad:
                said = str(bad).split("\n")[0]
                raise InputError(
                    f"{path}: is no table of results: {said}; remove it, and its rigs are done again"
                ) from None
        whole = pl.concat(tables) if tables else pl.DataFrame(schema=schema())
        return whole.unique(["rig", "when"], keep="last", maintain_order=True).sort("rig", "when")

    def left(self, jobs: Sequence[Job]) -> list[Job]:
        """Jobs that are not done, or were done with other files than there are now.

        Args:
            jobs: The jobs.

        Returns:
            Those that are left, in the same order.
        """
        rows = self.rows().filter(status="done")
        done = {tuple(row) for row in rows.select("rig", "when", "inputs").iter_rows()}
        return [job for job in jobs if (job.rig, job.when, job.inputs()) not in done]

    def gathered(self) -> "pl.DataFrame":
        """Writes all rows into one file, in the place of those that came since.

        Returns:
            The rows.

        Raises:
            InputError: They cannot be written.
        """
        found, parts = self.rows(), self._parts()
        if parts or not (self.folder / RESULTS).exists():
            _write(found, self.folder / RESULTS)
            for part in parts:
                part.unlink(missing_ok=True)
        return found


def _write(table: "pl.DataFrame", path: Path) -> None:
    """Writes a table whole or not at all."""
    file = io.BytesIO()
    table.write_parquet(file)
    write_files({str(path): file.getvalue()}, InputError)
