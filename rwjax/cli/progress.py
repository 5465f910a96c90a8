"""What a command shows of its progress."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

from rwjax.cli.terminal import tell

EVERY_S = 5.0
"""Seconds between two lines where stderr is no terminal."""


@contextmanager
def progress(quiet: bool, *, lines: bool = False) -> Iterator[Callable[[str], None]]:
    """A spinner with the latest step and the time since the start, on a terminal; elsewhere nothing, or a line for a new step.

    Args:
        quiet: whether the user wants none.
        lines: whether lines are wanted where there is no terminal.

    Yields:
        Function that takes the step that begins, in words, on any thread.
    """
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if quiet or not (console.is_terminal or lines):
        yield lambda text: None
        return
    if not console.is_terminal:
        with _lines() as show:
            yield show
        return
    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True) as shown:
        task = shown.add_task("reading", total=None)
        yield lambda text: shown.update(task, description=text)


@contextmanager
def _lines() -> Iterator[Callable[[str], None]]:
    """The latest step as a line on stderr, looked at every `EVERY_S`: an estimate that is told again would be wrong by then."""
    latest, ended = [""], Event()

    def say() -> None:
        said = ""
        while not ended.wait(EVERY_S):
            if latest[0] != said:
                tell(said := latest[0])

    thread = Thread(target=say, daemon=True)
    thread.start()
    try:
        yield lambda text: latest.__setitem__(0, text)
    finally:
        ended.set()
        thread.join()
