"""Figures as PNG files."""

import io
from pathlib import Path

from matplotlib.figure import Figure

from rwjax.errors import InputError
from rwjax.report.style import any_letters
from rwjax.text_files import write_files

DOTS_PER_INCH = 130


def png_of(figure: Figure) -> bytes:
    """A figure as the content of a file.

    Args:
        figure: what is drawn.

    Returns:
        The bytes.
    """
    buffer = io.BytesIO()
    with any_letters():
        figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
    return buffer.getvalue()


def write_png(figure: Figure, path: Path) -> Path:
    """Writes a figure into a file, whole or not at all.

    Args:
        figure: what is written.
        path: file to write.

    Returns:
        The path.

    Raises:
        InputError: the file cannot be written.
    """
    write_files({str(path): png_of(figure)}, InputError)
    return path
