"""Log files of any layout read, each to a checked `Log` in SI."""

import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from rwjax.errors import OF_PATH, InputError, LogError, printable, refuses_other_types
from rwjax.logs.fields import fields_of
from rwjax.logs.log import Log
from rwjax.logs.read_sheet import read_sheet
from rwjax.logs.text_sheet import NO_HEADER, NoHeader
from rwjax.rig.model import Rig


@refuses_other_types
def read_logs(
    paths: Iterable[str | os.PathLike[str]] | str | os.PathLike[str], rig: Rig, outputs_required: bool = True
) -> tuple[Log, ...]:
    """Several logs of one rig.

    Args:
        paths: The files, or one alone.
        rig: The rig that was logged.
        outputs_required: Whether a log without any measured output is an error.

    Returns:
        The logs in the order given, each with a name of its own; logs of the same file name are called by their paths.

    Raises:
        LogError: As `read_log`, and where the same file is named twice.
        InputError: The rig is none, or a path is.
    """
    named = [paths] if isinstance(paths, str | os.PathLike) else list(paths)
    if others := [path for path in named if not isinstance(path, str | os.PathLike)]:
        raise InputError(f"read_logs: `paths` holds a `{type(others[0]).__name__}`; it {OF_PATH}, or several in a list")
    given = [Path(path) for path in named]
    for path, times in Counter(os.path.realpath(path) for path in given).items():
        if times > 1:
            raise LogError(f"{path}: named {times} times; name each log once")
    logs = [read_log(path, rig, outputs_required) for path in given]
    return tuple(replace(log, name=name) for log, name in zip(logs, _names(given), strict=True))


def _names(paths: Sequence[Path]) -> list[str]:
    """A name for each log, of characters that are printed: its file's, its path's where others are called so, or that with a number."""
    files, whole = ([printable(str(name)) for name in each] for each in ((path.name for path in paths), paths))
    names = [file if files.count(file) == 1 else path for file, path in zip(files, whole, strict=True)]
    # of two paths that are printed alike, the later one is numbered
    return [f"{name} ({names[:k].count(name) + 1})" if name in names[:k] else name for k, name in enumerate(names)]


@refuses_other_types
def read_log(path: str | os.PathLike[str], rig: Rig, outputs_required: bool = True) -> Log:
    """One run, from a log file of rwjax's layout, of the thesis's, or of any that `[columns]` of the rig file describes.

    Args:
        path: The file.
        rig: The rig that was logged.
        outputs_required: Whether a log without any measured output is an error.

    Returns:
        The log in SI.

    Raises:
        LogError: With file, line, what is wrong and what would be right.
        InputError: The rig is none, or the path is.
    """
    try:
        sheet = read_sheet(path)
    except NoHeader:
        if not rig.sources:
            raise
        names = ",".join(source.column for source in rig.sources.values())
        raise NoHeader(
            f"{path}: {NO_HEADER}; the first row has to hold the columns that [columns] names: `{names}`"
        ) from None
    return Log(printable(Path(path).name), **fields_of(sheet, rig, outputs_required))
