"""Programs on disk: each file appears whole or not at all, and its name holds all that the program depends on."""

import hashlib
import os
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path

import jax

from rwjax.cache_folder import has_room, trim_now_and_then

TRACED = ("jax", "equinox", "diffrax", "optimistix", "lineax", "llvmlite")
"""Distributions whose code becomes part of a program."""
DIGEST = 32
"""Bytes of the check sum before a program in its file. It shows that a file was torn; against somebody who can write the folder there is
`rwjax/cache_folder.py`."""


@cache
def _origin() -> str:
    """What a program depends on besides its arguments: the library's source and the versions of what is built on."""
    source = hashlib.sha256()
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        source.update(path.read_bytes())
    return f"{source.hexdigest()} {[version(name) for name in TRACED]} {jax.default_backend()}"


def file_of(kind: str, name: str, key: object) -> Path | None:
    """Where a program is kept.

    Args:
        kind: What kind of program it is, the beginning of the file's name.
        name: Name of the function that was traced.
        key: What else the program depends on.

    Returns:
        The file; None where no programs are kept.
    """
    folder = getattr(jax.config, "jax_compilation_cache_dir", None)
    if not folder:
        return None
    digest = hashlib.sha256(f"{_origin()} {name} {key}".encode()).hexdigest()
    return Path(folder) / f"{kind}-{name}-{digest}"


def read(path: Path | None) -> bytearray | None:
    """What `write` put there.

    Args:
        path: The file.

    Returns:
        The program; None where nothing is, or not all of it.
    """
    try:
        content = path.read_bytes() if path else b""
    except OSError:
        return None
    digest, data = content[:DIGEST], content[DIGEST:]
    return bytearray(data) if data and hashlib.sha256(data).digest() == digest else None


def write(path: Path | None, data: bytes | bytearray) -> None:
    """Puts a program into its file, whole or not at all; a full or read-only disk costs time and nothing else.

    Args:
        path: The file; None where no programs are kept.
        data: The program.
    """
    if path is None:
        return
    new = path.with_suffix(f".{os.getpid()}")
    trim_now_and_then(path.parent)
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        if not has_room(path.parent):
            return
        try:
            new.write_bytes(hashlib.sha256(data).digest() + data)
            new.replace(path)
        finally:
            new.unlink(missing_ok=True)
