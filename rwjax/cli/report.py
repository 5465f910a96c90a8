"""The command `report`: the page of a diagnosis, drawn again."""

from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.options import Quiet
from rwjax.cli.progress import progress
from rwjax.cli.terminal import say

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="folder of a diagnosis", show_default=False)]


def report(folder: Folder, quiet: Quiet = False) -> None:
    """Draw the page and the figures of a diagnosis again, from what DIR holds. Needs no rig file and no log.

    Example: `rwjax report diagnosis`
    """
    from rwjax.diagnosis.record import read_diagnosis
    from rwjax.report.html import check_page, write_report

    check_page(folder)
    found = read_diagnosis(folder)
    with progress(quiet) as show:
        show("drawing")
        page = write_report(found, folder)
    say(f"report: {page}")
