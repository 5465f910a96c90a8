"""What is said of arguments that do not fit a command: the option, what was given, what would be right."""

import re
from collections.abc import Container

from typer.exceptions import TyperException

WORDS = {"°": "degrees", "s": "seconds"}
"""Units whose sign is hard to type or to see, in words."""


def wrong_argument(error: TyperException, given: str, commands: Container[str]) -> str:
    """A line on arguments that do not fit.

    Args:
        error: what the parser says.
        given: the first argument, which names a command if the user got that far.
        commands: names of all commands.

    Returns:
        What is wrong and what would be right, on one line; "" where the parser says nothing.
    """
    said = " ".join((_wrong_value(error) or error.format_message()).split())
    command = f" {given}" if given in commands else ""
    return said and f"{said} (`rwjax{command} --help` lists what is right)"


def _wrong_value(error: TyperException) -> str:
    """The line on an option whose value cannot be read, from what pydantic says of it; "" for any other error."""
    of_pydantic, option = getattr(error.__cause__, "errors", None), getattr(error, "param", None)
    if option is None or of_pydantic is None:
        return ""
    found = of_pydantic()[0]
    what = found["msg"].removeprefix("Value error, ").partition(", unable to")[0]
    what = what.replace("Input should be a valid", "has to be a").replace("a integer", "a whole number")
    if " is not one of " in what:
        what = "has to be one of " + what.partition(" is not one of ")[2].replace("'", "").rstrip(".")
    what = what.replace("Input should be", "has to be")
    unit = re.search(r"\[(.+?)\]", getattr(option, "help", None) or "")
    in_unit = f" in {WORDS.get(unit[1], unit[1])}" if unit and what.endswith("number") else ""
    return f"{max(option.opts, key=len)} {found['input']}: {what}{in_unit}"
