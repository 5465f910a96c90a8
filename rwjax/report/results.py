"""The files of a diagnosis in a folder: its JSON, the corrected rig, the page with its figures, the record, and the next experiment."""

from pathlib import Path

from rwjax.diagnosis.record import RECORD, record
from rwjax.diagnosis.result import Diagnosis
from rwjax.errors import InputError
from rwjax.planning.files import clear_next, write_next
from rwjax.report.answer import json_text
from rwjax.report.html import FIGURES, REPORT, corrected_text, is_page, write_report
from rwjax.text_files import write_files, write_text

JSON, CORRECTED = "diagnosis.json", "corrected.toml"
"""Names of the files that programs read."""


def write_results(d: Diagnosis, folder: Path) -> dict[str, Path]:
    """Writes all files of a diagnosis.

    Args:
        d: the diagnosis.
        folder: folder of the results, which exists.

    Returns:
        Paths of what a user opens first, by what they are.

    Raises:
        InputError: a file cannot be written, or a number of the result is not finite.
    """
    write_answer(d, folder)
    report, plan = write_report(d, folder), write_next(folder, d.proposal)
    return ({"plan of the next experiment": plan} if plan is not None else {}) | {"report": report}


def write_answer(d: Diagnosis, folder: Path) -> None:
    """Writes what programs read of a diagnosis, which takes no time: its JSON, the corrected rig and the record.

    From the record the page can be drawn later (`rwjax report`).

    Args:
        d: the diagnosis.
        folder: folder of the results, which exists.

    Raises:
        InputError: a file cannot be written, or a number of the result is not finite.
    """
    write_text(folder / JSON, answer_of(d) + "\n", InputError)
    write_text(folder / CORRECTED, corrected_text(d), InputError)
    write_files({str(folder / RECORD): record(d)}, InputError)


def answer_of(d: Diagnosis) -> str:
    """What `diagnosis.json` holds.

    Args:
        d: the diagnosis.

    Returns:
        The text.

    Raises:
        InputError: a number is not finite.
    """
    return json_text(d.json(), indent=1)


def clear_results(folder: Path) -> None:
    """Removes an earlier diagnosis, with the plan of its next experiment; what else a user has put there or edited stays.

    Args:
        folder: folder of the results.
    """
    page = [REPORT] if is_page(folder / REPORT) else []
    for name in (JSON, RECORD, CORRECTED, *page, *(f"{figure}.png" for figure in FIGURES)):
        (folder / name).unlink(missing_ok=True)
    clear_next(folder)
