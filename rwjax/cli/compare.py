"""The command `compare`: every identification method on the same logs."""

from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.ask_first import Force, ask_first
from rwjax.cli.options import Json, LogFiles, Quiet, RigFile, Segments, check_segments, of_file
from rwjax.cli.progress import progress
from rwjax.cli.result_folder import ResultFolder
from rwjax.cli.solver import SolverName, SolverOption, Width, solver_of
from rwjax.cli.terminal import document, note, say
from rwjax.errors import InputError
from rwjax.report.answer import json_text

Output = Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the results")]


def compare(
    rig_file: RigFile,
    log_files: LogFiles,
    solver: SolverOption = SolverName.EXACT,
    smooth: Width = None,
    segments: Segments = None,
    output: Output = Path("comparison"),
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Every identification method on the same logs, judged on the same held-out data by the free run of one solver.

    Example: `rwjax compare rig.toml logs/*.csv`
    """
    from rwjax.errors import RigError
    from rwjax.fitting.segments import with_segments
    from rwjax.logs.read import read_logs
    from rwjax.methods.comparison import compare as run
    from rwjax.report.comparison import write_figure
    from rwjax.rig.read import read_one_axis_rig
    from rwjax.text_files import write_text

    check_segments(segments)
    by = solver_of(solver, smooth)
    rig = read_one_axis_rig(rig_file)
    logs = read_logs(log_files, rig)
    target = ResultFolder(output, _clear, (rig_file, *log_files))
    target.check()
    with progress(quiet, lines=True) as show:
        show("looking at the logs")
        logs = with_segments(rig, logs, segments)
        asked = ask_first(rig, logs, force)
        with of_file(rig_file, RigError):
            result = run(rig, logs, show, solver=by)
        if all(row.rig is None for row in result.rows):
            raise InputError(f"{rig_file}: no method can be used on these logs; {'; '.join(result.rows[0].notes)}")
        answer = json_text(result.json(), indent=1)
        with target.renewed() as folder:
            write_text(folder / "comparison.json", answer + "\n", InputError)
            write_text(folder / "comparison.txt", f"{result}\n", InputError)
            write_figure(result, folder / "comparison.png")
    if as_json:
        document(answer + "\n")
    else:
        say(f"{result}\nfigure: {output / 'comparison.png'}")
    note(*asked.notes)


def _clear(folder: Path) -> None:
    """Removes an earlier comparison."""
    for ending in ("json", "txt", "png"):
        (folder / f"comparison.{ending}").unlink(missing_ok=True)
