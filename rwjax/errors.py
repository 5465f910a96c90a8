"""The errors that rwjax raises for unusable input, and the nearest valid name that their messages offer."""

import difflib
from collections.abc import Iterable


class InputError(ValueError):
    r"""The input is unusable.

    The message is one line: file, line or key, what is wrong, what would be right.

    Args:
        message: The text; a line break in it is written as `\n`, since a name in a file may hold one.
    """

    def __init__(self, message: str):
        super().__init__("\\n".join(message.splitlines()))


class RigError(InputError):
    """A rig file (TOML) that cannot be used."""


class LogError(InputError):
    """A log file (CSV), or a set of logs, that cannot be used."""


def nearest(name: str, valid: Iterable[str]) -> str:
    """The valid name that is spelled most like a given one.

    Args:
        name: What was given.
        valid: Names to choose from, at least one.

    Returns:
        One of `valid`, however unlike it is.
    """
    return difflib.get_close_matches(name, list(valid), n=1, cutoff=0.0)[0]


def alike(name: str, valid: Iterable[str]) -> bool:
    """Whether a name is spelled so like a valid one that it may be a typing mistake.

    Args:
        name: What was given.
        valid: Names to compare it with.

    Returns:
        True from a similarity of 0.75 on (`difflib.SequenceMatcher.ratio`).
    """
    return bool(difflib.get_close_matches(name, list(valid), n=1, cutoff=0.75))
