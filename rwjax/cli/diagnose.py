"""The command `diagnose`: where the gap between a rig file and the logs lies, and which effect causes it."""

import json
from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.options import Json, LogFiles, Quiet, RigFile, results
from rwjax.cli.progress import progress
from rwjax.errors import InputError

Output = Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the results")]


def diagnose(
    rig_file: RigFile,
    log_files: LogFiles,
    output: Output = Path("diagnosis"),
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Where the gap between RIG and the logs lies, which effect causes it, how far it closes."""
    from rwjax.diagnosis.diagnosis import diagnose as run
    from rwjax.logs.read import read_logs
    from rwjax.planning.files import write_next
    from rwjax.report.html import write_report
    from rwjax.rig.read import read_rig
    from rwjax.rig.write import write_rig
    from rwjax.text_files import write_text

    rig = read_rig(rig_file)
    logs = read_logs(log_files, rig)
    with results(output) as folder, progress(quiet) as show:
        result = run(rig, logs, progress=show)
        show("writing the report")
        answer = json.dumps(result.json(), indent=1, allow_nan=False)
        write_text(folder / "diagnosis.json", answer + "\n", InputError)
        write_text(folder / "corrected.toml", write_rig(result.corrected), InputError)
        report = write_report(result, folder)
        plan = write_next(folder, result.proposal)
    if as_json:
        print(answer)
        return
    print(result)
    if plan is not None:
        print(f"  plan of the next experiment: {plan}")
    print(f"  report: {report}")
