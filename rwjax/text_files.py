"""Text files read and written whole, with errors that name the file and the remedy."""

import os
import tomllib
from pathlib import Path
from typing import Any

from rwjax.errors import InputError

MOST_TOML, LONGEST_TOML_LINE = 250_000, 10_000
"""Characters of a TOML file and of one of its lines: files made by hand or by rwjax are far shorter, and a key of thousands of parts
takes minutes to read."""


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
        raise error(f"{path}: cannot be read: {bad.strerror}; give the path of a readable file") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def parse_toml(text: str) -> dict[str, Any]:
    """The values of a TOML text of a size that a person or rwjax writes.

    Args:
        text: The text.

    Returns:
        Tables within tables.

    Raises:
        ValueError: Where the text is no TOML or too long, with `(at line N` where one line is to blame.
        RecursionError: Where tables or lists stand too deep within one another.
    """
    if len(text) > MOST_TOML:
        raise ValueError(f"{len(text)} characters, and such a file has {MOST_TOML} at most")
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > LONGEST_TOML_LINE:
            raise ValueError(f"{len(line)} characters on one line, {LONGEST_TOML_LINE} at most (at line {number})")
    return tomllib.loads(text)


def write_text(path: str | os.PathLike[str], text: str, error: type[InputError]) -> None:
    """Writes a UTF-8 file whole or not at all.

    The text goes to a temporary file beside the target, which is then renamed. What is no plain file
    (such as `/dev/stdout`) is written to and never replaced.

    Args:
        path: The file; a link is followed.
        text: Its whole content.
        error: Class of the error to raise.

    Raises:
        InputError: As `error`, where the file cannot be written.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise error(f"{path}: is a folder; give the path of a file")
    try:
        if target.exists() and not target.is_file():
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
