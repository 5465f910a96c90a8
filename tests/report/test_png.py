"""Figures as PNG files."""

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from rwjax.errors import InputError
from rwjax.report.png import DOTS_PER_INCH, write_png


def test_a_file_has_the_figures_size(tmp_path: Path) -> None:
    written = write_png(Figure(figsize=(2.0, 1.0)), tmp_path / "a.png").read_bytes()
    assert written.startswith(b"\x89PNG")
    width, height = (int.from_bytes(written[k : k + 4], "big") for k in (16, 20))  # of the header's first part
    assert (width, height) == (2 * DOTS_PER_INCH, DOTS_PER_INCH)


def test_a_path_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="absent/a.png: cannot be written: there is no folder .*absent; make it first"):
        write_png(Figure(), tmp_path / "absent" / "a.png")
