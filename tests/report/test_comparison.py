"""The comparison of methods as a figure."""

from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.colors import to_hex

from rwjax.methods.comparison import METHODS, Comparison, Row
from rwjax.report.comparison import draw_comparison, write_figure
from rwjax.report.style import AFTER, FLOOR
from tests.systems import platform


@pytest.fixture
def comparison() -> Comparison:
    rig = platform()
    fitted = replace(rig, standard_error={"axis.inertia": 0.00123})
    rows = (
        Row(METHODS[0], fitted, {"yaw_rad": 0.0125}, 1.26, ("a note",)),
        Row(METHODS[1], rig, {"yaw_rad": 0.5}, 0.04, ()),
        Row(METHODS[2], None, {}, 0.0, ("cannot be used",)),
    )
    return Comparison(rig, rows, {"yaw_rad": 0.01}, "marked")


def test_the_figure_has_a_bar_for_each_method_that_could_be_used(comparison: Comparison) -> None:
    (ax,) = draw_comparison(comparison).axes
    assert [(bar.get_width(), to_hex(bar.get_facecolor())) for bar in ax.patches] == [(0.0125, AFTER), (0.5, AFTER)]
    (floor,) = ax.lines
    assert list(floor.get_xdata()) == [0.01, 0.01] and floor.get_color() == FLOOR
    assert [label.get_text() for label in ax.get_yticklabels()] == ["end-to-end", "smooth"]
    assert ax.get_xlabel() == "free-run RMS, yaw ψ [rad]" and ax.get_xscale() == "log"


def test_the_figure_is_written(comparison: Comparison, tmp_path: Path) -> None:
    assert write_figure(comparison, tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")
