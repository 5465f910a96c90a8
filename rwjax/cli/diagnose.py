"""The command `diagnose`: where the gap between a rig file and the logs lies, and which effect causes it."""

from collections.abc import Callable, Sequence
from math import isinf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.ask_first import Force, ask_first
from rwjax.cli.interrupt import STATUS, first, unanswered
from rwjax.cli.options import Json, LogFiles, Quiet, RigFile, Segments, check_segments, positive
from rwjax.cli.progress import progress
from rwjax.cli.result_folder import ResultFolder
from rwjax.cli.terminal import document, next_command, note, say

if TYPE_CHECKING:
    from rwjax.diagnosis.result import Diagnosis

BUDGET_S = 120.0
"""Time that a search may take [s]."""
LONGER = 4.0
"""Times the budget that is advised after a search that did not come to its end [1]."""
BudgetS = Annotated[
    float,
    typer.Option(
        "--budget", metavar="SECONDS", help="time [s] after which the search gives its answer so far; inf: none"
    ),
]
Only = Annotated[
    list[str] | None,
    typer.Option(
        "--only", metavar="NAME…", help="compare these candidates alone, by their names under ranking in diagnosis.json"
    ),
]
Without = Annotated[list[str] | None, typer.Option("--without", metavar="NAME…", help="leave these candidates out")]
Output = Annotated[Path, typer.Option("-o", metavar="DIR", help="folder of the results")]


def diagnose(
    rig_file: RigFile,
    log_files: LogFiles,
    segments: Segments = None,
    budget: BudgetS = BUDGET_S,
    only: Only = None,
    without: Without = None,
    output: Output = Path("diagnosis"),
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Where the gap between RIG and the logs lies, which effect causes it, how far it closes.

    Example: `rwjax diagnose rig.toml logs/*.csv -o diagnosis`
    """
    from rwjax.diagnosis.budget import Budget
    from rwjax.diagnosis.diagnosis import diagnose as run
    from rwjax.fitting import garbage, processes
    from rwjax.fitting.questions.guesses import about_guesses
    from rwjax.fitting.segments import with_segments
    from rwjax.logs.read import read_logs
    from rwjax.report.html import check_page
    from rwjax.report.results import clear_results
    from rwjax.rig.read import read_rig

    check_segments(segments)
    positive(budget=budget)
    with unanswered() as answered, progress(quiet, lines=True) as show:
        limit, rig = Budget(budget), read_rig(rig_file)
        logs = read_logs(log_files, rig)
        target = ResultFolder(output, clear_results, (rig_file, *log_files))
        target.check()
        check_page(output)
        with processes.Team() as team, first(limit.stop), garbage.seldom_collected():
            show("looking at the logs")
            logs = with_segments(rig, logs, segments)
            asked = ask_first(rig, logs, force)
            result = run(rig, logs, only=only or (), without=without or (), budget=limit, team=team, progress=show)
            answered()
            written = _written(result, target, show)
    if as_json:
        from rwjax.report.results import answer_of

        document(answer_of(result) + "\n")
    else:
        files = [f"  {name}: {output / path}" for name, path in written.items()]
        ahead = _ahead(result, rig_file, log_files, output, segments=segments, force=force)
        again = "diagnose", rig_file, *log_files, "-o", output, *_with_more_time(budget, only, without)
        silent = result.complete or limit.stopped or isinf(budget)  # else its budget has ended it
        ahead += [] if silent else [next_command(*again, segments=segments, force=force)]
        say("\n".join([str(result), *_of_errors(result), *files, *ahead]))
    note(*asked.notes, *about_guesses(result.corrected))
    if limit.stopped:
        raise typer.Exit(STATUS)


def _ahead(
    result: "Diagnosis", rig_file: Path, log_files: Sequence[Path], output: Path, *, segments: float | None, force: bool
) -> list[str]:
    """What to do with the corrected rig file."""
    from rwjax.diagnosis.verdict import CLAIMS
    from rwjax.report.results import CORRECTED

    if result.verdict in CLAIMS:
        fit = "fit", output / CORRECTED, *log_files, "-o", output / "fitted.toml"
        return [next_command(*fit, segments=segments, force=force)]
    if result.verdict == "unknown":
        return [f"  {output / CORRECTED}: with {_held(result)}; go on from {rig_file}"]
    return []


def _written(result: "Diagnosis", target: ResultFolder, show: Callable[[str], None]) -> dict[str, Path]:
    """Writes a diagnosis; paths within the folder of what a user opens first. Whatever ends the drawing of the page, the answer is there."""
    from rwjax.errors import InputError
    from rwjax.report.results import write_answer, write_results

    show("writing the answer")
    with target.renewed() as folder:
        write_answer(result, folder)
    show("drawing the report")
    try:
        with target.renewed() as folder:
            return {name: path.relative_to(folder) for name, path in write_results(result, folder).items()}
    except (KeyboardInterrupt, InputError):
        note(f"{target.path} holds the answer, and no page of it yet; {next_command('report', target.path)}")
        raise


def _of_errors(result: "Diagnosis") -> list[str]:
    """A line on the standard errors, where they are those of a model that is known not to be whole."""
    from rwjax.report.html import too_tight

    return [f"  note: {words}"] if (words := too_tight(result)) else []


def _held(result: "Diagnosis") -> str:
    """What the corrected rig file of a diagnosis that claims nothing holds."""
    return "what leads, which is not claimed" if result.effects else "only the rig's own numbers, fitted again"


def _with_more_time(budget: float, only: list[str] | None, without: list[str] | None) -> list[str]:
    """The options of a diagnosis of the same candidates with a longer budget."""
    given = {"--only": only or (), "--without": without or ()}
    names = [word for option, names in given.items() for name in names for word in (option, name)]
    return ["--budget", f"{LONGER * budget:g}", *names]
