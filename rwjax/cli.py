"""Command line: reads the arguments, calls the library, prints. The one place that prints and exits."""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from rwjax.errors import InputError

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Fit models of reaction-wheel rigs to logs, and find out why the simulation is off.",
)

RigFile = Annotated[Path, typer.Argument(metavar="RIG", help="rig file (TOML)", show_default=False)]
LogFiles = Annotated[list[Path], typer.Argument(metavar="LOG…", help="log files (CSV)", show_default=False)]
Json = Annotated[bool, typer.Option("--json", help="print the result as JSON on stdout")]
Quiet = Annotated[bool, typer.Option("--quiet", help="no progress")]


@contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[str], None]]:
    """A spinner with the latest step on a terminal, nothing otherwise."""
    from rich.console import Console

    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield lambda text: None
        return
    with console.status("reading") as status:
        yield lambda text: status.update(text)


def _folder(path: Path) -> Path:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot make this folder ({error.strerror}); give another with -o") from None
    return path


@app.command()
def fit(
    rig: RigFile,
    logs: LogFiles,
    output: Annotated[Path | None, typer.Option("-o", metavar="FITTED.toml", help="stdout without it")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Estimate the free numbers of RIG from the logs; writes the fitted rig file."""
    from rwjax.errors import write_text
    from rwjax.fit.rig_fit import fit_rig
    from rwjax.log import read_logs
    from rwjax.rig import read_rig, write_rig

    with _progress(quiet) as progress:
        believed = read_rig(rig)
        records = read_logs(logs, believed)
        progress("fitting")
        result = fit_rig(believed, records)
    text = write_rig(result.rig)
    if output is not None:
        write_text(output, text, InputError)
    if as_json:
        print(json.dumps(result.json(), indent=1))
    elif output is None:
        print(text, end="")
    for note in result.uncertainty.notes:
        print(f"note: {note}", file=sys.stderr)


@app.command()
def predict(
    rig: RigFile,
    log: Annotated[Path, typer.Argument(metavar="LOG", help="log file (CSV)", show_default=False)],
    output: Annotated[Path | None, typer.Option("-o", metavar="PRED.csv", help="stdout without it")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Free run of RIG under the log's input, from the first 0.5 s of the log; writes a CSV at the log's times."""
    from rwjax.errors import write_text
    from rwjax.log import read_log
    from rwjax.predict import predict_log
    from rwjax.rig import read_rig

    believed = read_rig(rig)
    record = read_log(log, believed, outputs_required=False)
    with _progress(quiet) as progress:
        progress("simulating")
        columns = predict_log(believed, record)
    if as_json:
        print(
            json.dumps({"schema": "rwjax.prediction/1", **{name: list(map(float, v)) for name, v in columns.items()}})
        )
        return
    rows = zip(*columns.values(), strict=True)
    text = ",".join(columns) + "\n" + "".join(",".join(f"{v:.10g}" for v in row) + "\n" for row in rows)
    if output is not None:
        write_text(output, text, InputError)
    else:
        print(text, end="")


@app.command()
def diagnose(
    rig: RigFile,
    logs: LogFiles,
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the results")] = Path("diagnosis"),
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Where the gap between RIG and the logs lies, which effect causes it, how far it closes."""
    from rwjax.diagnose.diagnosis import diagnose as run
    from rwjax.errors import write_text
    from rwjax.log import read_logs
    from rwjax.report.html import write_report
    from rwjax.report.words import text
    from rwjax.rig import read_rig, write_rig

    believed = read_rig(rig)
    records = read_logs(logs, believed)
    folder = _folder(output)
    with _progress(quiet) as progress:
        result = run(believed, records, progress)
        progress("writing the report")
        answer = json.dumps(result.json(), indent=1, allow_nan=False)
        write_text(folder / "diagnosis.json", answer + "\n", InputError)
        write_text(folder / "corrected.toml", write_rig(result.corrected), InputError)
        report = write_report(result, folder)
    if as_json:
        print(answer)
    else:
        print("\n".join(text(result)))
        print(f"  report: {report}")


def main() -> None:
    """Entry point: one line and status 2 for unusable input."""
    try:
        app()
    except InputError as error:
        print(f"rwjax: {error}", file=sys.stderr)
        sys.exit(2)
