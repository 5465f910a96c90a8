"""The command `compare`: every identification method on the same logs."""

import json
from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.options import Json, LogFiles, Quiet, RigFile, of_file, results
from rwjax.cli.progress import progress
from rwjax.errors import InputError

Output = Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the results")]


def compare(
    rig_file: RigFile,
    log_files: LogFiles,
    output: Output = Path("comparison"),
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Every identification method on the same logs, judged on the same held-out data."""
    from rwjax.errors import RigError
    from rwjax.logs.read import read_logs
    from rwjax.methods.comparison import compare as run
    from rwjax.report.comparison import table, write_figure
    from rwjax.rig.read import read_one_axis_rig
    from rwjax.text_files import write_text

    rig = read_one_axis_rig(rig_file)
    logs = read_logs(log_files, rig)
    with results(output) as folder, progress(quiet) as show:
        with of_file(rig_file, RigError):
            result = run(rig, logs, show)
        answer, text = json.dumps(result.json(), indent=1, allow_nan=False), table(result)
        write_text(folder / "comparison.json", answer + "\n", InputError)
        write_text(folder / "comparison.txt", text, InputError)
        figure = write_figure(result, folder / "comparison.png")
    print(answer if as_json else text + f"figure: {figure}")
