"""The gate of every result: what is no finite number is neither printed nor written."""

import json
import math
from collections.abc import Mapping
from typing import Any

from rwjax.errors import InputError


def json_text(answer: Mapping[str, Any], indent: int | None = None) -> str:
    r"""A result as JSON text, made before anything of it is printed or written.

    Args:
        answer: the result as plain objects; what a result may lack is None.
        indent: blanks by which each level is indented; without it, the text is one line.

    Returns:
        The text. What UTF-8 has no code for, from a file's name that is none, stands as `\udcff`.

    Raises:
        InputError: a number is not finite; the message names its key.
    """
    return json.dumps(_checked(answer, ""), indent=indent, allow_nan=False)


def check_finite(answer: Mapping[str, Any]) -> None:
    """Checks what is printed or written otherwise than as JSON.

    Args:
        answer: numbers as plain objects, by the names that the user knows them by.

    Raises:
        InputError: a number is not finite; the message names its key.
    """
    _checked(answer, "")


def _checked(value: Any, key: str) -> Any:
    """The value, in plain objects of finite numbers and text that UTF-8 has codes for; `key` names it."""
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(
            f"the result's `{key}` would be {value}, which is no finite number; "
            "check the rig file's numbers and units, and the logs' columns"
        )
    if isinstance(value, str):
        return value.encode("utf-8", "backslashreplace").decode()
    if isinstance(value, Mapping):
        return {_checked(name, key): _checked(one, f"{key}.{name}".lstrip(".")) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_checked(one, key) for one in value]
    return value
