"""The folder of compiled programs: where it lies, who can change it, how large it grows.

JAX's compiled programs, the traced ones of `simulation/program_cache.py` and the machine code of `lowering/kept.py` lie in it, and what
`simulation/exponential_step.py` keeps of a plant. Programs are executed. Whoever can write the folder, or put another in its place, can
run code as the user who reads it. So a folder that others can change is not used. If the user named it, that is an error: the user meant it and can put it right. The default folder is left out with a
note: nobody asked for it, and without it a command takes longer and gives the same.
"""

import os
import re
import shutil
import stat
from contextlib import suppress
from itertools import count
from pathlib import Path
from random import randrange
from typing import NamedTuple

from platformdirs import user_cache_dir

from rwjax.errors import InputError

VARIABLE = "JAX_COMPILATION_CACHE_DIR"
"""Names the folder; empty, no program is kept. It is JAX's own variable."""
MOST_BYTES = 1_000_000_000
"""Of the folder's programs. Of more, the least recently used are removed: those of an older version of the library go that way too."""
WRITES_BETWEEN_TRIMS = 100
"""Programs that a process writes until it looks again at the size of their folder. To list a full one takes a second, so that a process
looks first after a number of writes drawn at random: most that write little never look."""
LEAST_FREE_BYTES = 100_000_000
"""Left on the disk: with less, JAX writes no program, since one that is cut off would never be written again."""
PROGRAM = re.compile(r"((traced|lowered|kept)-\w+-[0-9a-f]{64}(\.\w+)?|\w+-[0-9a-f]{64}-(cache|atime))", re.ASCII)
"""Names of the files that the library and JAX write. No other file of the folder is ever touched."""


_written = count(randrange(WRITES_BETWEEN_TRIMS))


class Program(NamedTuple):
    """A file of the folder."""

    path: Path
    size: int
    """[bytes]"""
    used: float
    """When it was last read or written, as far as the disk notes it [s since 1970]."""


def place() -> Path | None:
    """The folder of programs, whether it exists or not.

    Returns:
        That of the variable, else `rwjax` in the user's cache folder. None if the variable is empty, or if the user has no home.
    """
    named = os.environ.get(VARIABLE)
    if named is not None:
        return Path(named).absolute() if named else None
    try:
        return Path(user_cache_dir("rwjax")).absolute()
    except RuntimeError:  # neither HOME nor an entry of the user
        return None


def opened(folder: Path) -> bool:
    """Makes a folder for the user alone (mode 700), with all above it, unless it is there.

    Args:
        folder: The folder of programs.

    Returns:
        Whether there is such a folder now. There is none below a file, on a read-only disk or where the user may not write.

    Raises:
        InputError: Others can change it.
    """
    try:
        for missing in reversed([path for path in (folder, *folder.parents) if not path.exists()]):
            with suppress(FileExistsError):  # another process was faster
                missing.mkdir(mode=0o700)
        weak = weak_point(folder) if folder.is_dir() else None
    except OSError:
        return False
    if weak:
        raise InputError(
            f"{folder}: holds programs that are executed, and {weak}; name a folder of your own in {VARIABLE}, "
            f"or run `rwjax cache clear` and take the right to write from all others (chmod go-w)"
        )
    return folder.is_dir()


def weak_point(folder: Path) -> str | None:
    """What lets others change a folder, or put another in its place.

    Every folder and every link on its path has to belong to the user or to root. No other user may write one of them. Above the last
    a folder like `/tmp` is safe, in which each user may rename only what is their own, and so is one that only the user's own group can write.
    Access lists beyond the mode are not looked at.

    Args:
        folder: An existing folder.

    Returns:
        The end of a sentence that names the weak place, or None.

    Raises:
        OSError: The path cannot be followed.
    """
    here, ahead = Path("/"), [*reversed(folder.absolute().parts)]
    while ahead:
        here /= ahead.pop()
        status = here.lstat()
        if status.st_uid not in (0, os.geteuid()):
            return f"{here} belongs to user {status.st_uid}"
        if stat.S_ISLNK(status.st_mode):
            ahead += reversed(Path(os.readlink(here)).parts)
            here = here.parent
        elif _others_write(status, above=bool(ahead)):
            return f"others can write {here} (mode {stat.S_IMODE(status.st_mode):o})"
    return None


def _others_write(status: os.stat_result, above: bool) -> bool:
    """Whether others can write a folder, or, where another is above it on the path, replace what is in it."""
    mode = status.st_mode
    if above and (mode & stat.S_ISVTX or (not mode & stat.S_IWOTH and _of_one(status.st_gid))):
        return False
    return bool(mode & (stat.S_IWGRP | stat.S_IWOTH))


def _of_one(group: int) -> bool:
    """Whether a group is the one that many systems make for each user alone, and let write by default."""
    import grp
    import pwd

    try:
        user, found = pwd.getpwuid(os.geteuid()), grp.getgrgid(group)
    except KeyError:
        return False
    return user.pw_gid == group and found.gr_name == user.pw_name and {*found.gr_mem} <= {user.pw_name}


def has_room(folder: Path) -> bool:
    """Whether programs can be written.

    Args:
        folder: An existing folder.

    Returns:
        False on a read-only or nearly full disk.
    """
    return os.access(folder, os.W_OK) and shutil.disk_usage(folder).free >= LEAST_FREE_BYTES


def programs(folder: Path) -> list[Program]:
    """The programs in a folder.

    Args:
        folder: Where they lie.

    Returns:
        Those least recently used first; none if there is no such folder.

    Raises:
        InputError: The folder cannot be read.
    """
    found = []
    try:
        with suppress(FileNotFoundError, NotADirectoryError), os.scandir(folder) as entries:
            for entry in entries:
                with suppress(FileNotFoundError):  # another process removed it
                    status = entry.stat(follow_symlinks=False)
                    if PROGRAM.fullmatch(entry.name) and stat.S_ISREG(status.st_mode):
                        found.append(Program(Path(entry.path), status.st_size, max(status.st_atime, status.st_mtime)))
    except OSError as bad:
        raise InputError(f"{folder}: cannot be read: {bad.strerror}; name a folder of your own in {VARIABLE}") from None
    return sorted(found, key=lambda program: program.used)


def trim(folder: Path, most: int = MOST_BYTES) -> None:
    """Removes the least recently used programs beyond a limit; several processes may do so at the same time.

    Args:
        folder: Where they lie.
        most: What may stay [bytes].
    """
    with suppress(InputError, OSError):
        found = programs(folder)
        size = sum(program.size for program in found)
        for program in found:
            if size <= most:
                break
            program.path.unlink(missing_ok=True)
            size -= program.size


def trim_now_and_then(folder: Path) -> None:
    """Trims a folder at one of this process's first writes, drawn at random, and every so many later.

    Args:
        folder: Where the program goes.
    """
    if next(_written) % WRITES_BETWEEN_TRIMS == 0:
        trim(folder)


def clear(folder: Path) -> list[Program]:
    """Removes all programs, and no other file.

    Args:
        folder: Where they lie.

    Returns:
        What was removed.

    Raises:
        InputError: They cannot be read or removed.
    """
    found = programs(folder)
    try:
        for program in found:
            program.path.unlink(missing_ok=True)
    except OSError as bad:
        raise InputError(f"{folder}: cannot be emptied: {bad.strerror}; name another folder in {VARIABLE}") from None
    return found
