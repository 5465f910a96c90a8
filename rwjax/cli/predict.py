"""The command `predict`: the free run of a rig under a log's input."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import Json, LogFiles, Quiet, RigFile, Segments, check_file, check_segments, of_file
from rwjax.cli.progress import progress
from rwjax.cli.solver import SolverName, SolverOption, Width, solver_of
from rwjax.cli.terminal import document, note, say
from rwjax.errors import InputError
from rwjax.report.answer import check_finite, json_text

if TYPE_CHECKING:
    import numpy as np

    from rwjax.fitting.questions.likeness import Run

Output = Annotated[Path | None, typer.Option("-o", metavar="PRED.csv", help="stdout without it")]


def predict(
    rig_file: RigFile,
    log_files: LogFiles,
    solver: SolverOption = SolverName.EXACT,
    smooth: Width = None,
    segments: Segments = None,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Free run of RIG under the log's input, from the first 0.5 s of the log; writes a CSV at the log's times. A log without readings, only `time_s` and the command, starts at rest at 0. Of several logs the errors alone are told, of each, of all together and of those kept for validation.

    Example: `rwjax predict fitted.toml logs/triangle.csv -o predicted.csv`
    """
    from rwjax.fitting.predict import predict as free_run
    from rwjax.fitting.questions.likeness import Run
    from rwjax.fitting.questions.readings import about_readings
    from rwjax.fitting.segments import said, with_segments
    from rwjax.logs.read import read_logs
    from rwjax.rig.read import read_rig

    if len(log_files) > 1 and (output is not None or as_json):
        raise InputError(
            f"-o and --json are for one log, and {len(log_files)} are given: of several the errors are told"
        )
    if output is not None:
        check_file(output, rig_file, *log_files)
    check_segments(segments)
    by = solver_of(solver, smooth)
    rig, runs, lost = read_rig(rig_file), list[Run](), list[str]()
    logs = read_logs(log_files, rig, outputs_required=len(log_files) > 1)
    with progress(quiet) as show:
        show("looking at the logs")
        logs = with_segments(rig, logs, segments)
        for k, log in enumerate(logs, 1):
            show(f"simulating {log.name}, {k} of {len(logs)}")
            try:
                with of_file(rig_file):
                    runs.append(Run(log, free_run(rig, log, solver=by).columns))
            except InputError as error:
                if len(logs) == 1:
                    raise
                lost.append(str(error))
    if len(logs) == 1:
        _tell(runs[0], output, as_json=as_json)
    elif runs:
        _tell_several(runs)
    note(*rig.cautions, *by.notes(rig, logs), *said(logs), *about_readings(runs), *lost)
    if lost:
        raise InputError(
            f"{len(lost)} of {len(logs)} logs have no prediction, and count in no error; the notes say why"
        )


def _tell_several(runs: "Sequence[Run]") -> None:
    """Tells the errors of several logs: of each, of all together, and of those together that no fit takes where the others are fitted."""
    kept = [run for run in runs if run.log.validate]
    lines = [
        f"{run.log.name}{' (kept for validation)' if run.log.validate else ''}: {line}"
        for run in runs
        for line in _errors(run)
    ]
    lines += [f"all samples together: {line}" for line in _errors(*runs)]
    if 0 < len(kept) < len(runs):
        lines += [f"those kept for validation together: {line}" for line in _errors(*kept)]
    document("\n".join([*lines, ""]))


def _tell(run: "Run", output: Path | None, *, as_json: bool) -> None:
    """Tells the free run of one log."""
    from rwjax.text_files import write_text

    columns = run.simulated
    text, errors = _csv(columns), _errors(run)
    if output is not None:
        write_text(output, text, InputError)
    if as_json:
        values = {name: list(map(float, v)) for name, v in columns.items()}
        document(json_text({"schema": "rwjax.prediction/1", **values}) + "\n")
    elif output is None:
        document(text)
        note(*errors)
    else:
        say("\n".join([*errors, f"written to {output}"]))


def _csv(columns: "Mapping[str, np.ndarray]") -> str:
    """The columns as text, every digit of the first, the time, ten of the others."""
    rows = zip(*columns.values(), strict=True)
    lines = (",".join([repr(float(row[0])), *(f"{v:.10g}" for v in row[1:])]) for row in rows)
    return "\n".join([",".join(columns), *lines, ""])


def _errors(*runs: "Run") -> list[str]:
    """A line on the error of each output over all readings of all runs. Raises `InputError` where that leaves the range of numbers."""
    import numpy as np

    from rwjax.rig.columns import unit_of

    lines = []
    for name in dict.fromkeys(name for run in runs for name in run.log.outputs):
        read = [(run.log.outputs[name], run.simulated[name]) for run in runs if name in run.log.outputs]
        measured, found = (np.concatenate(one) for one in zip(*read, strict=True))
        with np.errstate(over="ignore"):
            error = float(np.sqrt(np.nanmean((measured - found) ** 2)))
            size, unit = float(np.sqrt(np.nanmean(measured**2))), unit_of(name)
        check_finite({f"RMS error of {name}": error, f"RMS of {name}": size})
        lines.append(f"{name}: RMS error {error:.4g} {unit} of a signal of RMS {size:.4g} {unit}")
    return lines
