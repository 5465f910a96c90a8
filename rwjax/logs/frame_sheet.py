"""A data frame of pandas or polars as a table."""

from typing import Any

from rwjax.errors import LogError, printable
from rwjax.logs.array_sheet import ArraySheet


def frame_sheet(frame: Any, name: str) -> ArraySheet:
    """A data frame as a table of its columns; an index with a name is one of them.

    Args:
        frame: Data frame of pandas, polars or any other library whose columns numpy can hold.
        name: What messages call it.

    Returns:
        The table.

    Raises:
        LogError: For what is no data frame.
    """
    try:
        if (index := getattr(getattr(frame, "index", None), "name", None)) is not None:
            frame = frame.reset_index(drop=index in frame.columns)
        names = list(frame.columns)
        columns = {printable(f"{each}"): frame[each].to_numpy() for each in names}
    except (AttributeError, TypeError, KeyError):
        raise LogError(f"{name}: a {type(frame).__name__} is no data frame; give one of pandas or polars") from None
    return ArraySheet(name, {}, list(columns), columns, "row")
