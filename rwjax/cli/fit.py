"""The command `fit`: estimates the free numbers of a rig file from logs."""

from collections.abc import Callable, Sequence
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.ask_first import GO_ON, Force, ask_first
from rwjax.cli.interrupt import unanswered
from rwjax.cli.options import Json, LogFiles, Quiet, RigFile, Segments, check_file, check_segments, of_file
from rwjax.cli.progress import progress
from rwjax.cli.solver import SolverName, SolverOption, Width, solver_of
from rwjax.cli.terminal import document, listed, next_command, note, say
from rwjax.errors import InputError
from rwjax.report.answer import json_text

if TYPE_CHECKING:
    from rwjax.fitting.fit import RigFit
    from rwjax.logs.log import Log
    from rwjax.methods.identified import Identified
    from rwjax.rig.model import Rig

FEWEST_DRAWS = 40
"""Refits below which percentiles of a bootstrap say nothing."""


class FitMethod(StrEnum):
    """Ways to fit that write a rig file."""

    E2E = "end-to-end"
    TWO_STAGE = "two-stage"
    LIMIT_SPEEDS = "limit-speeds"


Method = Annotated[
    FitMethod,
    typer.Option(
        help="as in the thesis: two-stage: friction from coast-downs; limit-speeds: the motor from steady speeds"
    ),
]
Bootstrap = Annotated[
    int, typer.Option(min=0, metavar="N", help="95 % intervals by N refits to resampled stretches (end-to-end)")
]
Output = Annotated[Path | None, typer.Option("-o", metavar="FITTED.toml", help="stdout without it")]


def fit(
    rig_file: RigFile,
    log_files: LogFiles,
    method: Method = FitMethod.E2E,
    bootstrap: Bootstrap = 0,
    solver: SolverOption = SolverName.EXACT,
    smooth: Width = None,
    segments: Segments = None,
    output: Output = None,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Estimate the free numbers of RIG from the logs; writes the fitted rig file.

    Example: `rwjax fit rig.toml logs/*.csv -o fitted.toml`
    """
    from rwjax.errors import RigError
    from rwjax.fitting.questions.guesses import about_guesses
    from rwjax.fitting.segments import with_segments
    from rwjax.logs.read import read_logs
    from rwjax.rig.write import write_rig
    from rwjax.text_files import write_text

    check_segments(segments)
    if output is not None:
        check_file(output, rig_file, *log_files)
    with unanswered(), progress(quiet, lines=True) as show:
        read, identify = _chosen(method, bootstrap, solver, smooth, segments, show)
        rig = read(rig_file)
        logs = read_logs(log_files, rig)
        show("looking at the logs")
        logs = with_segments(rig, logs, segments)
        asked = ask_first(rig, logs, force)
        show("fitting")
        with of_file(rig_file, RigError):
            result = identify(rig, logs)
    if not force:
        _check_told(rig, result)
    answer, text = json_text(result.json(), indent=1), write_rig(result.rig)
    if output is not None:
        write_text(output, text, InputError)
    if as_json:
        document(answer + "\n")
    elif output is None:
        document(text)
    else:
        fitted = listed([log.name for log in logs if not log.validate])
        ahead = _next(result, output, log_files, segments=segments, force=force)
        say("\n".join([*_estimates(result), f"fitted to {fitted}; written to {output}", ahead]))
    note(*dict.fromkeys([*asked.notes, *rig.cautions, *about_guesses(rig), *result.notes]))
    if asked.questions and output is not None:
        note(f"{output} is written even so; its numbers are those of the logs as they are")


def _next(
    result: "RigFit | Identified", output: Path, log_files: "Sequence[Path]", *, segments: float | None, force: bool
) -> str:
    """The command to use the fitted rig file with, or to ask what it lacks."""
    from rwjax.fitting.rig_fit import RigFit

    if isinstance(result, RigFit) and result.lacks_something:
        return next_command("diagnose", output, *log_files, segments=segments, force=force)
    return next_command("predict", output, *log_files, *_ahead(result, output, log_files), segments=segments)


def _check_told(rig: "Rig", result: "RigFit | Identified") -> None:
    """Raises `InputError` for estimates that ran away, or that the logs do not tell: no rig file is written."""
    from rwjax.fitting.ran_away import runaway_words
    from rwjax.fitting.rig_fit import RigFit

    if found := runaway_words(rig, result.rig):
        raise InputError("; ".join([*found, GO_ON]))
    if isinstance(result, RigFit) and not result.tells_something:
        names = listed(result.rig.free)
        raise InputError(
            f"these logs tell nothing of {names}: use runs in which the command changes and the rig moves; {GO_ON}"
        )


def _chosen(
    method: FitMethod,
    bootstrap: int,
    solver: SolverName,
    smooth: float | None,
    segments: float | None,
    show: "Callable[[str], None]",
) -> "tuple[Callable[[Path], Rig], Callable[[Rig, Sequence[Log]], RigFit | Identified]]":
    """The functions that read the rig file and that fit. Raises `InputError` for options that the method does not have."""
    if method is not FitMethod.E2E and (solver is not SolverName.EXACT or smooth is not None):
        raise InputError(f"--solver and --smooth: the method {method} simulates nothing; leave them out")
    if method is not FitMethod.E2E and segments is not None:
        raise InputError(f"--segments: the method {method} has no free run; leave the option out")
    if method is FitMethod.TWO_STAGE:
        from rwjax.methods.two_stage import two_stage
        from rwjax.rig.read import read_one_axis_rig

        if bootstrap:
            raise InputError("--bootstrap: the two-stage method always makes its own; leave the option out")
        return read_one_axis_rig, two_stage
    if method is FitMethod.LIMIT_SPEEDS:
        from rwjax.methods.limit_speeds import limit_speeds
        from rwjax.rig.read import read_one_axis_rig

        if bootstrap:
            raise InputError("--bootstrap: the limit-speed method has errors of its own; leave the option out")
        return read_one_axis_rig, limit_speeds
    from rwjax.fitting.fit import fit as estimate
    from rwjax.rig.read import read_rig

    if 0 < bootstrap < FEWEST_DRAWS:
        raise InputError(f"--bootstrap {bootstrap}: percentiles need at least {FEWEST_DRAWS} refits; 200 is usual")
    return read_rig, partial(estimate, bootstrap=bootstrap, solver=solver_of(solver, smooth), progress=show)


def _ahead(result: "RigFit | Identified", output: Path, log_files: "Sequence[Path]") -> list[object]:
    """The options of `predict`: of one log it writes beside the fitted rig file; a smooth solver is the one of the fit."""
    from rwjax.fitting.rig_fit import RigFit

    options: list[object] = ["-o", output.with_name("predicted.csv")] if len(log_files) == 1 else []
    if isinstance(result, RigFit) and (solver := result.fit.problem.solver).smooth:
        options += ["--solver", solver.name, "--smooth", f"{solver.sign_width:.6g}"]
    return options


def _estimates(result: "RigFit | Identified") -> list[str]:
    lines = []
    for name in result.rig.free:
        error = result.rig.standard_error.get(name)
        spread = "" if error is None else f" ± {error:.2g}"
        if words := result.interval_words(name):
            spread += f" ({words})"
        lines.append(f"{name} = {result.rig.values[name]:.6g}{spread}")
    return lines + result.of_runs()
