"""Figures of a diagnosis: what their lines, bars and words say."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from rwjax.logs.log import Segments
from rwjax.report import plots
from rwjax.report.style import AFTER, BEFORE, FLOOR
from tests.report import diagnosed as by_hand
from tests.report.diagnosed import diagnosed


@pytest.fixture
def ax() -> Axes:
    return Figure().subplots()


def bars(ax: Axes) -> list[tuple[float, str]]:
    """Length and colour of every bar, the first one first."""
    return [(bar.get_width(), to_hex(bar.get_facecolor())) for bar in ax.patches]


def ticks(ax: Axes) -> list[str]:
    return [label.get_text() for label in ax.get_yticklabels()]


def test_the_motion_of_the_worst_run_stands_beside_both_simulations(ax: Axes) -> None:
    found = diagnosed()
    worse = found.before.error | {1: {"yaw_rad": np.full(50, 2.0 * by_hand.BEFORE)}}
    plots.plot_motion(diagnosed(before=replace(found.before, error=worse)), ax)
    measured, before, after = (np.asarray(line.get_ydata()) for line in ax.lines)
    assert np.all(measured == found.logs[1].outputs["yaw_rad"]) and "b " in ax.get_title(loc="left")
    assert np.allclose(measured - before, 2.0 * by_hand.BEFORE) and np.allclose(measured - after, by_hand.AFTER)
    assert [t.get_text() for t in ax.get_legend().get_texts()] == ["measured", "rig as it is", "with the effects"]


def test_runs_follow_each_other_before_and_after(ax: Axes) -> None:
    assert plots.plot_runs(diagnosed(), ax) is ax
    lines = [line for line in ax.lines if len(line.get_xdata()) == 50]
    assert [to_hex(line.get_color()) for line in lines] == [BEFORE, AFTER] * 2
    assert np.all(np.asarray(lines[0].get_ydata()) == by_hand.BEFORE)
    assert np.all(np.asarray(lines[3].get_ydata()) == by_hand.AFTER)
    assert np.max(lines[0].get_xdata()) < np.min(lines[2].get_xdata())
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["rig as it is", "with the effects"]
    assert ax.get_ylabel() == "measured − predicted yaw ψ [rad]"


def test_segments_of_a_run_keep_their_own_times(ax: Axes) -> None:
    first, second = diagnosed().logs[:2]
    step = first.time[1] - first.time[0]
    second = replace(second, time=first.time + 30 * step, segments=Segments(1.0, "as asked for", number=1))
    plots.plot_runs(diagnosed(logs=(first, second), effects=()), ax)
    one, other = (np.asarray(line.get_xdata()) for line in ax.lines if len(line.get_xdata()) == 50)
    assert np.allclose(other - one, 30 * step)  # they overlap, as the second begins in its first 0.5 s
    assert len(ax.texts) == 1  # one run


def test_without_effects_there_is_one_line_a_run(ax: Axes) -> None:
    plots.plot_runs(diagnosed(effects=()), ax)
    assert len([line for line in ax.lines if len(line.get_xdata()) == 50]) == 2


def test_the_waterfall_ends_above_the_floor(ax: Axes) -> None:
    plots.plot_waterfall(diagnosed(), ax)
    points = ax.collections[-1]
    assert [list(at) for at in np.asarray(points.get_offsets())] == [[by_hand.BEFORE, 0.0], [by_hand.AFTER, 1.0]]
    assert [to_hex(colour) for colour in points.get_facecolor()] == [BEFORE, AFTER] and ax.get_xscale() == "log"
    (floor,) = ax.lines
    assert list(floor.get_xdata()) == [by_hand.FLOOR] * 2 and floor.get_color() == FLOOR
    assert ticks(ax) == ["rig as it is", "+ dry friction"]
    assert [text.get_text() for text in ax.texts] == ["0.5", "0.11", "floor 0.1"]


def test_the_missing_torque_lies_on_its_bins_medians(ax: Axes) -> None:
    plots.plot_missing(diagnosed(), ax)
    samples, median, zero = ax.lines
    assert len(samples.get_xdata()) == plots.MOST_POINTS + 1000  # every one of 5000: the stride is whole
    x, y = (np.asarray(v) for v in (median.get_xdata(), median.get_ydata()))
    assert len(x) == plots.BINS and np.array_equal(y[np.abs(x) > 0.1], 0.2 * np.sign(x[np.abs(x) > 0.1]))
    assert list(zero.get_ydata()) == [0.0, 0.0] and ax.get_xlabel() == "yaw rate ψ' [rad/s]"


def test_the_ranking_speaks_of_effects_in_words(ax: Axes) -> None:
    plots.plot_ranking(diagnosed(), ax)
    assert bars(ax) == [(0.9, AFTER), (0.1, AFTER)] and ticks(ax) == ["dry friction", "nothing"]


def test_the_coordinate_that_explains_most_stands_out(ax: Axes) -> None:
    plots.plot_shares(diagnosed(), ax)
    assert bars(ax) == [(0.8, AFTER), (0.1, FLOOR)] and ticks(ax) == ["yaw rate", "time"]
