"""Figures as PNG files."""

import io
from pathlib import Path

from matplotlib.figure import Figure

from rwjax.errors import InputError

DOTS_PER_INCH = 130


def write_png(figure: Figure, path: Path) -> Path:
    """Writes a figure into a file.

    Args:
        figure: what is written.
        path: file to write.

    Returns:
        The path.

    Raises:
        InputError: the file cannot be written.
    """
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
    try:
        path.write_bytes(buffer.getvalue())
    except OSError as bad:
        raise InputError(f"{path}: cannot be written: {bad.strerror}; give a path in a writable folder") from None
    return path
