"""Files read and written whole, with errors that name the file and the remedy."""

import os
import re
import stat
import time
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import Any

from rwjax.errors import InputError, alike, nearest

LONGEST_STEM = 40
"""Characters of a file's name that the name of its temporary one repeats, so that this is no longer than a name may be."""
DEAD_AFTER = 3600.0
"""How long nothing has changed in a temporary file or folder that is taken for one of a killed process [s]. That its process is not
seen does not do: it may run in another container, or on another machine that shares the folder."""
MOST_BESIDE = 2000
"""Files of a folder among which one is sought that is spelled like a missing one."""
MOST_TOML, LONGEST_TOML_LINE = 250_000, 4_000
"""Characters of a TOML file and of one of its lines: files made by hand or by rwjax are far shorter, and a key of thousands of parts
takes minutes to read. Python reads no whole number of more than 4300 digits."""


def read_text(path: str | os.PathLike[str], error: type[InputError]) -> str:
    r"""The text of a UTF-8 file without byte order mark, every line ended by `\n`.

    Args:
        path: The file.
        error: Class of the error to raise.

    Returns:
        The whole text.

    Raises:
        InputError: As `error`, where the file cannot be read or is not UTF-8.
    """
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as bad:
        line = bad.object.count(b"\n", 0, bad.start) + 1
        raise error(f"{path}:{line}: byte {bad.object[bad.start]:#04x} is not UTF-8; save the file as UTF-8") from None
    except OSError as bad:
        raise error(cannot_be_read(path, bad)) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def cannot_be_read(path: str | os.PathLike[str], bad: OSError) -> str:
    """Why a file cannot be read, and what to give in its place.

    Args:
        path: The file.
        bad: What the system says.

    Returns:
        One line; it names the file beside it that is spelled like one that is missing.
    """
    said, advice = f"{path}: cannot be read: {bad.strerror}", "give the path of a readable file"
    if isinstance(bad, FileNotFoundError):
        beside, files = Path(path).parent, list[str]()
        with suppress(OSError):
            files = [entry.name for entry in islice(beside.iterdir(), MOST_BESIDE) if entry.is_file()]
        if files and alike(Path(path).name, [name := nearest(Path(path).name, files)]):
            advice = f"beside it lies {beside / name}"
    return f"{said}; {advice}"


def parse_toml(text: str) -> dict[str, Any]:
    """The values of a TOML text of a size that a person or rwjax writes.

    Args:
        text: The text.

    Returns:
        Tables within tables.

    Raises:
        ValueError: Where the text is no TOML or too long, with `(at line N` where one line is to blame.
    """
    import tomllib  # with the first such file: most of the start of a command is imports

    if len(text) > MOST_TOML:
        raise ValueError(f"{len(text)} characters, and such a file has {MOST_TOML} at most")
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > LONGEST_TOML_LINE:
            raise ValueError(f"{len(line)} characters on one line, {LONGEST_TOML_LINE} at most (at line {number})")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("tables or lists stand too deep within one another") from None


def write_text(path: str | os.PathLike[str], text: str, error: type[InputError]) -> None:
    r"""Writes a UTF-8 file whole or not at all, as `write_files` does.

    Args:
        path: The file; a link is followed.
        text: Its whole content. What UTF-8 has no code for, from a file's name that is none, stands as `\udcff`.
        error: Class of the error to raise.

    Raises:
        InputError: As `error`, where the file cannot be written.
    """
    write_files({os.fspath(path): text.encode("utf-8", "backslashreplace")}, error)


def write_files(contents: Mapping[str, bytes], error: type[InputError]) -> None:
    """Writes files that belong together: each whole or not at all, and none unless there is room for all.

    Every content goes to a temporary file beside its target, and these are renamed when all are complete. So a full disk, an
    error or the end of the process leaves a file as it was or as it should be; for a loss of power that is up to the file
    system. A file that is there keeps its permissions. What is no plain file (such as `/dev/stdout`) is written to and
    never replaced.

    Args:
        contents: Bytes of each file by its path; a link is followed.
        error: Class of the error to raise.

    Raises:
        InputError: As `error`, where a file cannot be written.
    """
    staged: dict[Path, tuple[str, Path]] = {}
    try:
        for path, content in contents.items():
            with _named(path, error):
                target = _file(path, error)
                if target.exists() and not target.is_file():
                    target.write_bytes(content)
                    continue
                temporary = beside(target)
                staged[temporary] = path, target
                _stage(temporary, target, content)
        for temporary, (path, target) in staged.items():
            with _named(path, error):
                temporary.replace(target)
    finally:
        for temporary in staged:
            temporary.unlink(missing_ok=True)


def check_writable(path: str | os.PathLike[str], error: type[InputError]) -> None:
    """Checks that a file can be written, before the work for it begins.

    Args:
        path: The file.
        error: Class of the error to raise.

    Raises:
        InputError: As `error`, with what `write_files` would say.
    """
    with _named(path, error):
        target = _file(path, error)
        if not target.exists() or target.is_file():
            trial = beside(target)
            try:
                _stage(trial, target, b"")
            finally:
                trial.unlink(missing_ok=True)


def beside(target: Path) -> Path:
    """A new name for what is to take a target's place, in the same folder. Files that a killed process left there are removed.

    Args:
        target: Path of the file or the folder.

    Returns:
        The path, at which there is nothing.
    """
    for left in left_over(target, DEAD_AFTER):
        with suppress(OSError):  # a folder, or somebody else's
            left.unlink()
    return target.with_name(f"{_prefix(target)}.{os.getpid()}.{os.urandom(4).hex()}.new")


def left_over(target: Path, seconds: float) -> Iterator[Path]:
    """What processes that were killed have left beside a target.

    Args:
        target: Path of the file or the folder.
        seconds: How long nothing has changed in it at least [s].

    Yields:
        Paths that `beside` gave to processes that are not seen any more.
    """
    name = re.compile(rf"{re.escape(_prefix(target))}\.(\d{{1,9}})\.[0-9a-f]+\.(new|old)")
    found = []
    with suppress(OSError), os.scandir(target.parent) as entries:  # a folder may be writable and not readable
        found = [(Path(entry.path), match) for entry in entries if (match := name.fullmatch(entry.name))]
    for path, match in found:
        with suppress(FileNotFoundError):  # settled by another process
            if not _runs(int(match[1])) and time.time() - path.lstat().st_ctime >= seconds:
                yield path


def _prefix(target: Path) -> str:
    """How the names of a target's temporary files begin: with a part of its name that is never too long, and a sum of all of it."""
    return f".{target.name[:LONGEST_STEM]}.{zlib.crc32(os.fsencode(target.name)):08x}"


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # somebody else's
        return True
    return True


def _file(path: str | os.PathLike[str], error: type[InputError]) -> Path:
    """Where a path leads, itself where that is no plain file. Raises `InputError` for a folder."""
    if os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path):
        return Path(path)  # what it leads to may have no path, as a pipe behind `/dev/stdout`
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise error(f"{path}: is a folder; give the path of a file")
    return target


def _stage(temporary: Path, target: Path, content: bytes) -> None:
    """Writes a file anew, with the permissions of its target if that is there, else those of any new file."""
    new = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    with open(new, "wb") as file:
        file.write(content)
    if target.exists():
        with suppress(OSError):  # a file system without permissions
            os.chmod(temporary, stat.S_IMODE(target.stat().st_mode))


@contextmanager
def _named(path: str | os.PathLike[str], error: type[InputError]) -> Iterator[None]:
    """Raises what the system says as the caller's error, with the file and the remedy."""
    try:
        yield
    except OSError as bad:
        if isinstance(bad, FileNotFoundError) and not (folder := Path(path).absolute().parent).is_dir():
            raise error(f"{path}: cannot be written: there is no folder {folder}; make it first") from None
        why = "no file can be made there" if isinstance(bad, FileNotFoundError) else bad.strerror
        raise error(f"{path}: cannot be written: {why}; give a path in a writable folder") from None
