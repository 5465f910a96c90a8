"""Command line: reads the arguments, calls the library, prints. The one place that prints and exits."""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from typer.exceptions import Abort, TyperException

from rwjax import __version__
from rwjax.cli import interrupt, link, loop, moves, plan, region
from rwjax.cli.options import Json, Quiet, RigFile, keep_input, of_file, results
from rwjax.errors import InputError

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",  # the default takes units, such as [s], for markup
    help="Fit models of reaction-wheel rigs to logs, and find out why the simulation is off.",
)


def _say_version(wanted: bool) -> bool:
    if wanted:
        print(f"rwjax {__version__}")
        raise typer.Exit
    return wanted


@app.callback()
def _before_the_command(
    version: Annotated[
        bool, typer.Option("--version", callback=_say_version, is_eager=True, help="print the version")
    ] = False,
) -> None:
    pass


LogFiles = Annotated[list[Path], typer.Argument(metavar="LOG…", help="log files (CSV)", show_default=False)]


FEWEST_DRAWS = 40


class FitMethod(StrEnum):
    """Ways to fit that write a rig file."""

    E2E = "end-to-end"
    TWO_STAGE = "two-stage"


@contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[str], None]]:
    """A spinner with the latest step and the time since the start on a terminal, nothing otherwise."""
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield lambda text: None
        return
    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True) as shown:
        task = shown.add_task("reading", total=None)
        yield lambda text: shown.update(task, description=text)


@app.command()
def fit(
    rig: RigFile,
    logs: LogFiles,
    method: Annotated[
        FitMethod, typer.Option(help="two-stage: friction from coast-downs, as in the thesis")
    ] = FitMethod.E2E,
    bootstrap: Annotated[
        int, typer.Option(min=0, metavar="N", help="95 % intervals by N refits to resampled stretches (end-to-end)")
    ] = 0,
    output: Annotated[Path | None, typer.Option("-o", metavar="FITTED.toml", help="stdout without it")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Estimate the free numbers of RIG from the logs; writes the fitted rig file."""
    from rwjax.errors import RigError
    from rwjax.fitting.unit_check import Question
    from rwjax.logs.read import read_logs
    from rwjax.rig.write import write_rig
    from rwjax.text_files import write_text

    if method is FitMethod.TWO_STAGE:
        from rwjax.methods.two_stage import two_stage as identify
        from rwjax.rig.read import read_one_axis_rig as read_rig

        if bootstrap:
            raise InputError("--bootstrap: the two-stage method always makes its own; leave the option out")
    else:
        from rwjax.fitting.fit import fit
        from rwjax.rig.read import read_rig

        if 0 < bootstrap < FEWEST_DRAWS:
            raise InputError(f"--bootstrap {bootstrap}: percentiles need at least {FEWEST_DRAWS} refits; 200 is usual")
        identify = partial(fit, bootstrap=bootstrap)

    if output is not None:
        keep_input(output, rig, *logs)
    with _progress(quiet) as progress:
        believed = read_rig(rig)
        records = read_logs(logs, believed)
        progress("fitting")
        with of_file(rig, RigError):
            result = identify(believed, records)
    text = write_rig(result.rig)
    if output is not None:
        write_text(output, text, InputError)
    if as_json:
        print(json.dumps(result.json(), indent=1))
    elif output is None:
        print(text, end="")
    else:
        for name in result.rig.free:
            error = result.rig.standard_error.get(name)
            spread = "" if error is None else f" ± {error:.2g}"
            if name in result.interval:
                spread += " (95 %: {:.6g} to {:.6g})".format(*result.interval[name])
            print(f"{name} = {result.rig.values[name]:.6g}{spread}")
        for line in result.of_runs():
            print(line)
        print(f"fitted to {', '.join(log.name for log in records if not log.validate)}; written to {output}")
    for note in result.notes:
        print(f"note: {note}", file=sys.stderr)
    if output is not None and any(isinstance(note, Question) for note in result.notes):
        print(f"note: {output} is written even so; its numbers are those of the readings as they are", file=sys.stderr)


@app.command()
def predict(
    rig: RigFile,
    log: Annotated[Path, typer.Argument(metavar="LOG", help="log file (CSV)", show_default=False)],
    output: Annotated[Path | None, typer.Option("-o", metavar="PRED.csv", help="stdout without it")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Free run of RIG under the log's input, from the first 0.5 s of the log; writes a CSV at the log's times. A log
    without readings, only `time_s` and the voltage, starts at rest at 0."""
    import numpy as np

    from rwjax.fitting.predict import predict
    from rwjax.fitting.unit_check import check_readings
    from rwjax.logs.columns import unit_of
    from rwjax.logs.read import read_log
    from rwjax.rig.read import read_rig
    from rwjax.text_files import write_text

    believed = read_rig(rig)
    record = read_log(log, believed, outputs_required=False)
    with _progress(quiet) as progress:
        progress("simulating")
        columns = predict(believed, record).columns
    if not all(np.isfinite(v).all() for v in columns.values()):
        raise InputError(
            f"{rig}: the simulation of {log} leaves the range of numbers; check the rig's numbers and units"
        )
    rows = zip(*columns.values(), strict=True)
    lines = (",".join([repr(float(row[0])), *(f"{v:.10g}" for v in row[1:])]) for row in rows)
    text = "\n".join([",".join(columns), *lines, ""])
    if output is not None:
        keep_input(output, rig, log)
        write_text(output, text, InputError)
    if as_json:
        print(
            json.dumps({"schema": "rwjax.prediction/1", **{name: list(map(float, v)) for name, v in columns.items()}})
        )
    elif output is None:
        print(text, end="")
    else:
        for name, measured in record.outputs.items():
            error = float(np.sqrt(np.nanmean((measured - columns[name]) ** 2)))
            size, unit = float(np.sqrt(np.nanmean(measured**2))), unit_of(name)
            print(f"{name}: RMS error {error:.4g} {unit} of a signal of RMS {size:.4g} {unit}")
        print(f"written to {output}")
    for question in check_readings([(record, columns)]):
        print(f"note: {question}", file=sys.stderr)


@app.command()
def compare(
    rig: RigFile,
    logs: LogFiles,
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the results")] = Path("comparison"),
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

    believed = read_one_axis_rig(rig)
    records = read_logs(logs, believed)
    with results(output) as folder, _progress(quiet) as progress:
        with of_file(rig, RigError):
            result = run(believed, records, progress)
        answer, text = json.dumps(result.json(), indent=1, allow_nan=False), table(result)
        write_text(folder / "comparison.json", answer + "\n", InputError)
        write_text(folder / "comparison.txt", text, InputError)
        figure = write_figure(result, folder / "comparison.png")
    if as_json:
        print(answer)
    else:
        print(text + f"figure: {figure}")


@app.command()
def diagnose(
    rig: RigFile,
    logs: LogFiles,
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the results")] = Path("diagnosis"),
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

    believed = read_rig(rig)
    records = read_logs(logs, believed)
    with results(output) as folder, _progress(quiet) as progress:
        result = run(believed, records, progress=progress)
        progress("writing the report")
        answer = json.dumps(result.json(), indent=1, allow_nan=False)
        write_text(folder / "diagnosis.json", answer + "\n", InputError)
        write_text(folder / "corrected.toml", write_rig(result.corrected), InputError)
        report = write_report(result, folder)
        plan = write_next(folder, result.proposal)
    if as_json:
        print(answer)
    else:
        print(result)
        if plan is not None:
            print(f"  plan of the next experiment: {plan}")
        print(f"  report: {report}")


for command in (region.region, *loop.COMMANDS, *moves.COMMANDS, plan.plan):
    app.command()(command)


link.add_to(app)


def main() -> None:
    """Entry point: one line and status 2 for unusable input."""
    try:
        interrupt.started()
        status = app(sys.argv[1:] or ["--help"], standalone_mode=False)
        if status == interrupt.STATUS:  # typer makes an exit of Ctrl-C
            raise KeyboardInterrupt
        sys.exit(status)
    except InputError as error:
        print(f"rwjax: {error}", file=sys.stderr)
        sys.exit(2)
    except TyperException as error:  # arguments that do not fit the command
        what = " ".join(error.format_message().split())
        if what:
            print(f"rwjax: {what} (`rwjax COMMAND --help` lists what is right)", file=sys.stderr)
        sys.exit(error.exit_code)
    except (KeyboardInterrupt, Abort):
        interrupt.leave()
