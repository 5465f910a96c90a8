"""What is said when a file is unusable, and the helpers that every reader and writer of files needs."""

import difflib
import os
from collections.abc import Iterable
from pathlib import Path


class InputError(ValueError):
    """The input is unusable. One line: file, line or key, what is wrong, what would be right."""

    def __init__(self, message: str):
        super().__init__("\\n".join(message.splitlines()))  # a name may hold a line break; the message stays one line


class RigError(InputError):
    """A rig file (TOML) that cannot be used."""


class LogError(InputError):
    """A log file (CSV), or a set of logs, that cannot be used."""


def nearest(name: str, valid: Iterable[str]) -> str:
    """The entry of `valid` (not empty) that is spelled most like `name`."""
    return difflib.get_close_matches(name, list(valid), n=1, cutoff=0.0)[0]


def alike(name: str, valid: Iterable[str]) -> bool:
    """Whether `name` is so like one of `valid` that it may be a slip of the pen."""
    return bool(difflib.get_close_matches(name, list(valid), n=1, cutoff=0.75))


def read_text(path: str | os.PathLike[str], error: type[InputError]) -> str:
    r"""The text of a UTF-8 file, no byte order mark, lines ending in `\n`; `error` if it cannot be read."""
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as bad:
        line = bad.object.count(b"\n", 0, bad.start) + 1
        raise error(f"{path}:{line}: byte {bad.object[bad.start]:#04x} is not UTF-8; save the file as UTF-8") from None
    except OSError as bad:
        raise error(f"{path}: cannot be read: {bad.strerror}; give the path of a readable file") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def write_text(path: str | os.PathLike[str], text: str, error: type[InputError]) -> None:
    """Writes a file whole or not at all (a temporary file beside it, renamed); `error` if that fails."""
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise error(f"{path}: is a folder; give the path of a file")
    try:
        if target.exists() and not target.is_file():  # /dev/stdout and its like are written to, never replaced
            target.write_text(text, encoding="utf-8")
            return
        temporary = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            temporary.write_text(text, encoding="utf-8")
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)
    except FileNotFoundError:
        raise error(f"{path}: cannot be written: there is no folder {target.parent}; make it first") from None
    except OSError as bad:
        raise error(f"{path}: cannot be written: {bad.strerror}; give a path in a writable folder") from None
