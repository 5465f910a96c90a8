"""The command line's entry point, and its commands in the order in which `--help` lists them."""

import os
import sys
from typing import Annotated

import typer
from typer.exceptions import Abort, TyperException
from typer.main import get_command

from rwjax import __version__
from rwjax.cli import interrupt, terminal
from rwjax.cli.cache import cache
from rwjax.cli.check import check
from rwjax.cli.compare import compare
from rwjax.cli.data import data
from rwjax.cli.decode import decode
from rwjax.cli.diagnose import diagnose
from rwjax.cli.dump import dump
from rwjax.cli.export import export
from rwjax.cli.fit import fit
from rwjax.cli.fleet import fleet
from rwjax.cli.import_logs import import_logs
from rwjax.cli.init import init
from rwjax.cli.monitor import monitor
from rwjax.cli.options import one_name_each
from rwjax.cli.plan import plan
from rwjax.cli.predict import predict
from rwjax.cli.record import record
from rwjax.cli.region import region
from rwjax.cli.report import report
from rwjax.cli.run_experiment import run_experiment
from rwjax.cli.size import size
from rwjax.cli.slew import slew
from rwjax.cli.sweep import sweep
from rwjax.cli.tune import tune
from rwjax.cli.usage import wrong_argument
from rwjax.errors import InputError, one_line

app = typer.Typer(
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",  # the default takes units, such as [s], for markup
    help="Fit models of motors, wheels, axes and servo joints to logs, and find out why the simulation is off.",
)


def _say_version(wanted: bool) -> bool:
    if wanted:
        terminal.say(f"rwjax {__version__}")
        raise typer.Exit
    return wanted


@app.callback()
def _before_the_command(
    version: Annotated[
        bool, typer.Option("--version", callback=_say_version, is_eager=True, help="print the version")
    ] = False,
) -> None:
    pass


COMMANDS = (
    *(init, import_logs, check, fit, predict, compare, diagnose, report, fleet, export),
    *(region, sweep, tune, slew, dump, size),
    *(plan, record, run_experiment, monitor, decode),
    *(data, cache),
)
for command in COMMANDS:
    app.command("import" if command is import_logs else None)(command)  # `import` is a word of Python's


def main() -> None:
    """Runs the command that the program's arguments name.

    Raises:
        SystemExit: always; status 2, after one line on stderr, for input that cannot be used.
    """
    terminal.begin()
    # equinox checks values by calling back to Python, and a program that does so cannot be kept on disk. Here nothing needs its
    # checks: a run that fails is seen by its readings. A user who wants them sets the variable.
    os.environ.setdefault("EQX_ON_ERROR", "off")
    if "JAX_PLATFORM_NAME" not in os.environ:  # JAX's older variable, which names a device among those there are
        # Nothing that was timed is faster on a GPU (docs/performance.md), and to begin it takes a second and its memory.
        os.environ.setdefault("JAX_PLATFORMS", "cpu")
    try:
        status = app(one_name_each(sys.argv[1:]) or ["--help"], standalone_mode=False)
        if status == interrupt.STATUS:  # typer makes an exit of Ctrl-C
            raise KeyboardInterrupt
        terminal.end()
        interrupt.end()
        sys.exit(status)
    except InputError as error:
        terminal.tell(f"rwjax: {error}")
        sys.exit(2)
    except OSError as error:  # help on a full disk
        terminal.forget(sys.stdout)
        what = ": ".join(str(part) for part in (error.filename, error.strerror or error) if part is not None)
        terminal.tell(f"rwjax: the system refuses: {one_line(what)}; free room, or give other files")
        sys.exit(2)
    except TyperException as error:  # arguments that do not fit the command
        if what := wrong_argument(error, "".join(sys.argv[1:2]), getattr(get_command(app), "commands", ())):
            terminal.tell(f"rwjax: {one_line(what)}")
        sys.exit(error.exit_code)
    except (KeyboardInterrupt, Abort):
        interrupt.leave()
