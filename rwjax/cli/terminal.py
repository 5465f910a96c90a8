"""What the commands print: lines without control characters, whatever a name holds, and documents as the bytes of a file."""

import os
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from typing import Any

from rwjax.errors import InputError, printable_lines

MOST_LISTED = 8
"""Names of logs that are said one by one."""


def begin() -> None:
    """From here on a character that stdout or stderr has no code for stands as its escape."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # neither closed nor a program's own
            stream.reconfigure(errors="backslashreplace")


def say(text: str) -> None:
    """Prints lines of a result on stdout.

    Args:
        text: the lines, with names from files as they are.

    Raises:
        InputError: stdout cannot be written.
    """
    with _to_stdout():
        print(printable_lines(text), file=sys.stdout)


def next_command(*words: object, segments: float | None = None, force: bool = False) -> str:
    """The line that suggests the next command.

    Args:
        words: what comes after `rwjax`: a command, files and options.
        segments: `--segments` that was given and holds for the next command, too [s].
        force: whether `--force` was.

    Returns:
        The line, as a shell takes it.
    """
    options = [*([] if segments is None else ["--segments", f"{segments:g}"]), *(["--force"] if force else [])]
    return f"next: {shlex.join(['rwjax', *map(str, words), *options])}"


def document(text: str) -> None:
    """Prints a file's text on stdout: the bytes that the file would have, on a terminal its lines.

    Args:
        text: the whole text.

    Raises:
        InputError: stdout cannot be written.
    """
    if sys.stdout is None or sys.stdout.isatty():
        say(text.removesuffix("\n"))
        return
    with _to_stdout():
        sys.stdout.flush()
        sys.stdout.buffer.write(text.encode("utf-8", "backslashreplace"))


def tell(*lines: str) -> None:
    """Prints lines about a result, or instead of one, on stderr. Where that cannot be written, they are lost.

    Args:
        lines: the lines, with names from files as they are.
    """
    if (stream := sys.stderr) is not None:
        try:
            for line in lines:
                print(printable_lines(line), file=stream)
        except OSError:
            forget(stream)


def note(*notes: object) -> None:
    """Prints notes on stderr.

    Args:
        notes: a line each, without the word `note`.
    """
    tell(*(f"note: {text}" for text in notes))


def end() -> None:
    """Writes what waits to be written on stdout.

    Raises:
        InputError: stdout cannot be written.
    """
    if sys.stdout is not None:
        with _to_stdout():
            sys.stdout.flush()


def forget(stream: Any) -> None:
    """Lets go what waits to be written on a stream that cannot be written; the program's end would try it again.

    Args:
        stream: stdout or stderr; None for one that was closed when the program began.
    """
    if stream is None:
        return
    with suppress(OSError):
        number, nowhere = stream.fileno(), os.open(os.devnull, os.O_WRONLY)
        if nowhere != number:  # else it was closed meanwhile
            os.dup2(nowhere, number)
            os.close(nowhere)


@contextmanager
def _to_stdout() -> Iterator[None]:
    """Raises `InputError` where stdout cannot be written. Where nobody reads it any more, the program ends, with status 1."""
    try:
        yield
    except OSError as bad:
        forget(sys.stdout)
        if isinstance(bad, BrokenPipeError):
            sys.exit(1)
        raise InputError(f"stdout: cannot be written: {bad.strerror}; write to another place") from None


def listed(names: Sequence[str]) -> str:
    """Names one by one, or how many there are where they would fill the screen.

    Args:
        names: The names of logs.

    Returns:
        The words.
    """
    return ", ".join(names) if len(names) <= MOST_LISTED else f"{len(names)} logs, {names[0]} to {names[-1]}"
