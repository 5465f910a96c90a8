"""The region of stabilising gains: columns and what the figure shows."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.control.controller import LoopTiming
from rwjax.control.criteria import ContinuousPoles, SampledPoles
from rwjax.control.linear import linearised
from rwjax.control.region import Region
from rwjax.control.transfer import transfer
from rwjax.report.region import draw_region, region_columns
from tests.systems import platform

KP, KD = np.array([0.0, 5.0, 10.0]), np.array([0.0, 2.0])
STABLE = np.array([[False, False], [False, True], [False, True]])


@pytest.fixture
def region() -> Region:
    """Of a platform of 0.1 kg m² and 0.4 N m/V: s² + (0.2 + 4 kd) s + 4 kp, for poles left of -0.5."""
    rig = platform("viscous = 0.02")
    return Region(rig, ContinuousPoles(0.5), KP, KD, STABLE, transfer(linearised(rig)))


def sampled(region: Region) -> Region:
    """The same pairs of a loop that is sampled."""
    return replace(region, criterion=SampledPoles(0.5, LoopTiming(0.01)))


def test_columns_belong_to_their_pair(region: Region) -> None:
    columns = region_columns(region, {"share of plants": np.arange(6.0).reshape(3, 2)})
    assert list(columns) == ["kp", "kd", "stable", "share_of_plants"]
    assert columns["kp"].tolist() == [0.0, 0.0, 5.0, 5.0, 10.0, 10.0] and columns["kd"].tolist() == [0.0, 2.0] * 3
    assert columns["stable"].tolist() == [0, 0, 0, 1, 0, 1] and columns["share_of_plants"].tolist() == [*range(6)]


def test_the_boundaries_are_those_of_the_polynomial(region: Region) -> None:
    (ax,) = draw_region(region, {}).axes
    pair, real = ax.lines
    assert pair.get_label() == "a pair of poles at −0.5 ± jω" and real.get_label() == "a real pole at −0.5"
    kp, kd = (np.asarray(v) for v in (real.get_xdata(), real.get_ydata()))
    assert 0.25 - 0.5 * (0.2 + 4.0 * kd) + 4.0 * kp == pytest.approx(0.0, abs=1e-12)
    kp, kd = (np.asarray(v) for v in (pair.get_xdata(), pair.get_ydata()))
    assert kd == pytest.approx((1.0 - 0.2) / 4.0)  # the sum of the poles is -1
    assert np.ma.masked_invalid(ax.collections[0].get_array()).mask.tolist() == (~STABLE.T).tolist()
    assert ax.get_title() == "33.3 % of these gains put every pole left of −0.5 1/s"


def test_a_sampled_loop_has_no_such_boundaries(region: Region) -> None:
    (ax,) = draw_region(sampled(region), {}).axes
    assert len(ax.lines) == 0 and ax.get_legend() is None


def test_what_stands_beside_is_dotted_where_it_falls_below_all(region: Region) -> None:
    beside = {"without friction": np.ones((3, 2)), "share of plants": np.where(STABLE, 1.0, 0.3)}
    (ax,) = draw_region(region, beside).axes
    first, *others = [text.get_text() for text in ax.get_legend().get_texts()]
    assert first == "all plants drawn" and "without friction" not in others


def test_one_row_of_gains_is_drawn_as_points(region: Region) -> None:
    row = replace(sampled(region), kp=KP[1:2], stable=STABLE[1:2])
    (ax,) = draw_region(row, {}).axes
    assert [list(ax.lines[0].get_xdata()), list(ax.lines[0].get_ydata())] == [[5.0], [2.0]]
