"""The folder of a command's results, built aside and exchanged whole: at its path there is the old one or the new one.

Where the system cannot exchange two folders at once, there is none for the moment between two renames. Who is killed just then
leaves the old one beside it, and the next command puts that back.
"""

import errno
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from rwjax.cli.terminal import note
from rwjax.errors import InputError
from rwjax.text_files import DEAD_AFTER, beside, left_over

MOST_FILES = 10_000
"""Files in a folder beyond which it is taken for one that is none of results; each of them is linked into the new folder."""
HERE, SWAP = -100, 2
"""Of the system's calls that exchange two folders: paths are those of the process; exchange."""
ROUNDS = 5
"""How often the old folder is emptied again, because a file came in before it was gone."""
NO_SWAP = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP)
"""What a system or a file system says that cannot exchange two folders at once."""
NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.EMLINK, errno.ENOSYS, errno.EACCES)
"""What one says that cannot give this file a second name; it is copied then."""


@dataclass(frozen=True)
class ResultFolder:
    """A folder that holds a command's results, and what else a user has put there, which stays.

    Attributes:
        path: The folder that the user wants; a link to one stays a link.
        clear: Removes the files of an earlier result of this command from a folder.
        inputs: Files that the command reads, none of which is replaced.
    """

    path: Path
    clear: Callable[[Path], None]
    inputs: tuple[Path, ...]

    def check(self) -> None:
        """Settles what killed processes have left, and tries all but the exchange, before the work begins.

        Raises:
            InputError: The folder cannot be replaced, or that would replace an input.
        """
        _settle_left_over(Path(os.path.realpath(self.path)))
        with self._aside() as (target, new):
            self._copy(target, new)

    @contextmanager
    def renewed(self) -> Iterator[Path]:
        """A folder with what the user has put into the old one; after the block it takes the old one's place.

        Yields:
            Path of the folder, for the results.

        Raises:
            InputError: The folder cannot be replaced, or that would replace an input. The old one stays then.
        """
        with self._aside() as (target, new):
            kept = self._copy(target, new)
            try:
                yield new
            except InputError as error:
                raise type(error)(str(error).replace(str(new), str(self.path))) from None
            self._spare_inputs(target, new, kept)
            if _exchange(new, target):
                self._carry_over(new, target, kept)

    @contextmanager
    def _aside(self) -> Iterator[tuple[Path, Path]]:
        """The folder's true path, and a new one beside it. That is gone unless exchanged, as are folders made for nothing."""
        made: list[Path] = []
        new = None
        try:
            target = Path(os.path.realpath(self.path))
            self._check_place(target)
            made = [folder for folder in target.parents if not folder.exists()]
            target.parent.mkdir(parents=True, exist_ok=True)
            new = _made_beside(target)
            yield target, new
        except OSError as bad:
            raise InputError(
                f"{self.path}: cannot make this folder ({bad.strerror or bad}); give another with -o"
            ) from None
        finally:
            if new is not None:
                _remove_unexchanged(new)
            for folder in made:
                with suppress(OSError):  # it holds the results
                    folder.rmdir()

    def _check_place(self, target: Path) -> None:
        """Raises `InputError` for a folder that cannot be exchanged, or should not be."""
        own = "give a folder of its own with -o"
        if not target.exists():
            return
        if not target.is_dir():
            raise InputError(f"{self.path}: is a file, and a folder is wanted; give another with -o")
        if target in (here := Path(os.getcwd()), *here.parents):
            raise InputError(f"{self.path}: holds the folder that you are in, and is replaced as a whole; {own}")
        if os.path.ismount(target):
            raise InputError(f"{self.path}: is where a file system begins, which cannot be replaced; {own}")
        if not os.access(target, os.W_OK | os.X_OK):
            raise InputError(f"{self.path}: cannot be written: Permission denied; give a writable folder with -o")
        if any(True for _ in islice(_files(target), MOST_FILES, None)):
            raise InputError(f"{self.path}: holds more than {MOST_FILES} files besides results; {own}")

    def _copy(self, target: Path, new: Path) -> dict[str, int]:
        """Links what the folder holds, but no earlier result, into the new one; the number of each file by its name."""
        while target.exists():
            old = os.open(target, os.O_RDONLY)  # held, so that no other folder gets its number
            try:
                _link_all(target, new)
                _copy_rights(target, new)
                if os.path.samestat(os.fstat(old), os.stat(target)):
                    break
            finally:
                os.close(old)
            _empty(new)  # another process has exchanged it meanwhile
        self.clear(new)
        kept = {name: os.lstat(new / name).st_ino for name in _files(new)}
        self._spare_inputs(target, new, kept)
        return kept

    def _spare_inputs(self, target: Path, new: Path, kept: dict[str, int]) -> None:
        """Raises `InputError` where an input lies in the folder and the new one has it no more, or another one."""
        for path in self.inputs:
            for true in (Path(os.path.realpath(path)), Path(os.path.realpath(path.parent), path.name)):
                name = str(true.relative_to(target)) if true.is_relative_to(target) else None
                if name and not (os.path.lexists(new / name) and os.lstat(new / name).st_ino == kept.get(name)):
                    raise InputError(
                        f"{path}: is an input, and the results would replace it; give another folder with -o"
                    )

    def _carry_over(self, old: Path, target: Path, kept: dict[str, int]) -> None:
        """Empties the old folder; what has come into it since it was copied, except another process's results, is taken over."""
        with suppress(OSError):
            for _ in range(ROUNDS):
                self.clear(old)
                _unlock(old)
                for name in list(_files(old)):
                    there, late = target / name, os.lstat(old / name).st_ino
                    now = os.lstat(there).st_ino if os.path.lexists(there) else None
                    if now != late and now in (None, kept.get(name)):
                        there.parent.mkdir(parents=True, exist_ok=True)
                        os.replace(old / name, there)
                    elif now == late or name in kept:  # else it came in under a result's name, and stays
                        os.unlink(old / name)
                for path, _, _ in os.walk(old, topdown=False):
                    with suppress(OSError):  # a file has come in
                        os.rmdir(path)
                if not old.exists():
                    return
        _tell_of(old, target)


def _settle_left_over(target: Path) -> None:
    """Puts a folder back that a killed process has moved aside, and removes the new ones that were not finished.

    A folder that was exchanged is the old one. It stays: only its own command could tell old results in it from what a user has
    put in during the exchange.
    """
    for left in left_over(target, 0.0):
        if left.suffix == ".old" and not target.exists():
            with suppress(OSError):
                left.rename(target)
    for left in left_over(target, DEAD_AFTER):
        _remove_unexchanged(left)
        if left.exists():
            _tell_of(left, target)


def _tell_of(old: Path, target: Path) -> None:
    note(
        f"{old} is what {target} was before; what came in while it was replaced may be there alone: look, and remove it"
    )


def _files(folder: Path) -> Iterator[str]:
    """Names within a folder of all that it holds, at any depth, except folders."""
    for path, folders, names in os.walk(folder):
        for name in (*names, *(name for name in folders if os.path.islink(os.path.join(path, name)))):
            yield os.path.relpath(os.path.join(path, name), folder)


def _link_all(folder: Path, copy: Path) -> None:
    """Makes every file of a folder a file of another one, too, and every folder in it anew; links stay links."""
    for name in os.listdir(folder):
        old, new = folder / name, copy / name
        with suppress(FileNotFoundError):  # removed meanwhile
            if old.is_dir() and not old.is_symlink():
                new.mkdir()
                _link_all(old, new)
                _copy_rights(old, new)
                continue
            try:
                os.link(old, new, follow_symlinks=False)
            except OSError as bad:
                if bad.errno not in NO_LINKS:
                    raise
                shutil.copy2(old, new, follow_symlinks=False)


def _unlock(folder: Path) -> None:
    """Makes the folders within a folder writable, so that they can be emptied."""
    for path, folders, _ in os.walk(folder):
        for name in folders:
            if not os.path.islink(inner := os.path.join(path, name)):
                with suppress(OSError):
                    os.chmod(inner, 0o700)


def _copy_rights(old: Path, new: Path) -> None:
    """Gives a folder the group, the permissions and the times of another one."""
    with suppress(OSError):  # not a group of this user
        os.chown(new, -1, old.stat().st_gid)
    shutil.copystat(old, new)


def _empty(folder: Path) -> None:
    """Removes what a folder holds, as far as possible."""
    _unlock(folder)
    for inner in folder.iterdir():
        if inner.is_dir() and not inner.is_symlink():
            shutil.rmtree(inner, ignore_errors=True)
        else:
            inner.unlink(missing_ok=True)


def _remove_unexchanged(new: Path) -> None:
    """Removes a folder that nobody has seen at the target's path: its name holds its own number, or it is empty."""
    with suppress(OSError):
        if new.name.split(".")[-2] == _number(new):
            _empty(new)
        new.rmdir()


def _made_beside(target: Path) -> Path:
    """A new folder. Its name holds its own number, until it is exchanged: then the folder of that name has another one."""
    new = beside(target)
    new.mkdir()
    return new.rename(new.with_name(".".join([*new.name.split(".")[:-2], _number(new), "new"])))


def _number(folder: Path) -> str:
    return f"{folder.stat().st_ino:x}"


def _exchange(new: Path, target: Path) -> bool:
    """Puts a folder into another one's place; whether there was one, which then is where the new one was."""
    while True:
        if target.exists():
            with suppress(FileNotFoundError):  # another process moves it just now
                _swap(new, target)
                return True
        else:
            try:
                new.rename(target)
                return False
            except OSError as bad:
                if bad.errno not in (errno.ENOTEMPTY, errno.EEXIST):  # made by another process just now
                    raise
        if not new.exists():
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(new))


def _swap(new: Path, target: Path) -> None:
    """Exchanges two folders: at once where the system can do that, else one after the other."""
    import ctypes  # with the first exchange: most of the start of a command is imports

    system, paths = ctypes.CDLL(None, use_errno=True), (os.fsencode(new), os.fsencode(target))
    if hasattr(system, "renameat2"):
        failed = system.renameat2(HERE, paths[0], HERE, paths[1], SWAP)
    elif hasattr(system, "renamex_np"):
        failed = system.renamex_np(*paths, SWAP)
    else:
        failed = None
    if failed == 0:
        return
    number = ctypes.get_errno()
    if failed is not None and number not in NO_SWAP:
        raise OSError(number, os.strerror(number), str(target))
    old = new.with_suffix(".old")
    target.rename(old)
    try:
        new.rename(target)
    except OSError:
        old.rename(target)
        raise
    old.rename(new)
