"""Maps over gains, manoeuvres and wheel sizes: columns and what the figures show."""

import numpy as np
import pytest

from rwjax.control.open_loop import Trajectory
from rwjax.control.response import Response
from rwjax.control.ring import Ring
from rwjax.control.sizing import LIMITS, WheelBudget
from rwjax.report.control import (
    MAPS,
    course_columns,
    draw_courses,
    draw_maps,
    draw_sizes,
    response_columns,
    size_columns,
)

KP, KD = np.array([1.0, 2.0, 3.0]), np.array([10.0, 20.0])


def responses(settling: float = 0.5) -> Response:
    """Fields over `KP` and `KD`, each a number of its own plus 10 p + d; one pair never settles."""
    index = 10.0 * np.arange(3)[:, None] + np.arange(2)
    fields = {name: k + 0.01 * index for k, name in enumerate(Response._fields)}
    fields["settling"] = np.full((3, 2), settling)
    fields["settling"][0, 0] = np.inf
    return Response(**fields)


def test_columns_of_a_sweep_belong_to_their_pair() -> None:
    columns = response_columns(KP, KD, responses())
    assert list(columns) == ["kp", "kd", *MAPS]
    assert columns["kp"].tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0] and columns["kd"].tolist() == [10.0, 20.0] * 3
    assert columns["error_rad"][3] == responses().error[1, 1] and columns["settling_s"].tolist() == [np.inf] + [0.5] * 5


def test_maps_have_their_units_and_a_hole_where_nothing_settles() -> None:
    figure = draw_maps(KP, KD, responses(), "steps")
    axes = [ax for ax in figure.axes if ax.get_title()]
    assert [ax.get_title() for ax in axes] == [label for _, label, _ in MAPS.values()]
    overshoot, settling, error = (np.ma.masked_invalid(ax.collections[0].get_array()) for ax in axes[:3])
    assert overshoot[1, 2] == pytest.approx(100.0 * responses().overshoot[2, 1])  # rows are kd, columns kp
    assert settling.mask[0, 0] and settling.mask.sum() == 1
    assert error[0, 1] == pytest.approx(np.degrees(responses().error[1, 0]))


def test_a_map_without_a_value_says_never() -> None:
    ax = draw_maps(KP, KD, responses(settling=np.inf), "steps").axes[1]
    assert [text.get_text() for text in ax.texts] == ["never"]


def test_one_row_of_gains_is_drawn_as_points() -> None:
    found = Response(*(field[:, :1] for field in responses()))
    points = draw_maps(KP, KD[:1], found, "steps").axes[0].collections[0]
    assert np.asarray(points.get_offsets()).tolist() == [[1.0, 10.0], [2.0, 10.0], [3.0, 10.0]]


def course(scale: float) -> Trajectory:
    values = {name: scale * (k + np.arange(3.0)) for k, name in enumerate(Trajectory._fields)}
    return Trajectory(**values | {"holds": np.zeros((3, 2))})


def test_a_course_has_the_columns_of_a_log() -> None:
    found = course(2.0)
    columns = course_columns(found)
    assert list(columns) == ["time_s", "voltage_V", "yaw_rad", "yaw_rad_s", "wheel_rad_s", "current_A"]
    assert columns["voltage_V"].tolist() == found.command.tolist() and columns["yaw_rad"].tolist() == [2.0, 4.0, 6.0]


def test_courses_are_lines_in_degrees_and_si() -> None:
    figure = draw_courses({"fast": course(1.0), "slow": course(2.0)}, "a turn")
    angle, wheel = figure.axes[:2]
    fast, slow = angle.lines[:2]
    assert np.asarray(slow.get_ydata()) == pytest.approx(np.degrees(course(2.0).angle))
    assert np.asarray(wheel.lines[0].get_ydata()).tolist() == course(1.0).wheel.tolist()
    assert fast.get_color() != slow.get_color()
    assert [text.get_text() for text in angle.get_legend().get_texts()] == ["fast", "slow"]


def sizes() -> tuple[Ring, WheelBudget]:
    """Six rings, the smallest of which never gets there."""
    ring = Ring(
        np.array([[0.02], [0.03], [0.05]]), 0.8 * np.array([[0.02], [0.03], [0.05]]), np.array([[0.001, 0.002]])
    )
    time = np.array([[np.inf, 4.0], [3.0, 2.0], [2.0, 1.0]])
    limit = np.array([[3, 0], [0, 1], [1, 2]])
    return ring, WheelBudget(np.ones((3, 2)), 0.1, 0.5, 0.02, time, limit, 0.0)


def test_columns_of_sizes_name_the_limit() -> None:
    ring, found = sizes()
    columns = size_columns(ring, found)
    assert columns["radius_m"].tolist() == [0.02, 0.02, 0.03, 0.03, 0.05, 0.05]
    assert columns["thickness_m"].tolist() == [0.001, 0.002] * 3
    assert columns["mass_kg"][3] == pytest.approx(2700.0 * np.pi * 0.36 * 0.03**2 * 0.002)
    assert columns["limit"].tolist() == [LIMITS[k] for k in (3, 0, 0, 1, 1, 2)]


def test_the_wanted_time_is_a_line_among_the_sizes() -> None:
    ring, found = sizes()
    left, right = draw_sizes(ring, found, 2.5, "rings").axes[:2]
    times = np.ma.masked_invalid(left.collections[0].get_array())
    assert times.mask[0, 0] and times[1, 2] == 1.0 and len(left.collections) == 2
    assert np.asarray(right.collections[0].get_array()).tolist() == found.limit.T.tolist()
    assert len(draw_sizes(ring, found, 9.0, "rings").axes[0].collections) == 1  # all that turn do so sooner
