"""Three kinds of interval."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log
from rwjax.fitting import intervals
from rwjax.fitting.bootstrap import bootstrap
from rwjax.fitting.fit import fit
from rwjax.fitting.intervals import interval_words
from rwjax.fitting.profile import interval
from rwjax.fitting.uncertainty import uncertainty
from rwjax.plant.from_rig import SMALLEST
from rwjax.rig.model import Rig
from tests.fitting.logs import ALL, FREE, log_of
from tests.systems import platform


def test_three_kinds_of_interval_agree_where_the_sum_of_squares_is_a_parabola() -> None:
    truth = platform(free=FREE)
    found = fit(truth, [log_of(truth, noise=1e-3)])
    drawn = np.percentile(bootstrap(found.fit, 60), (2.5, 97.5), axis=0).T
    for k, name in enumerate(found.fit.free):
        error = found.uncertainty.standard_error[name]
        low, high = found.interval[name]
        number = int(found.fit.coordinates.index[k])
        assert interval(found.fit, number, float(found.uncertainty.inflation[k]), error) == pytest.approx(
            (low, high), abs=0.05 * error
        )
        assert 0.5 < (drawn[k, 1] - drawn[k, 0]) / (high - low) < 1.6, name  # 60 draws of 24 stretches
        assert low < truth.values[name] < high, name


def test_numbers_that_only_scale_together_have_no_interval() -> None:
    rig = platform(free=ALL)
    found = fit(rig, [log_of(rig, noise=1e-3)])
    assert {ends[1] for ends in found.interval.values()} == {np.inf}


def test_an_open_end_is_said_in_words() -> None:
    said = [interval_words(*ends, 3) for ends in ((1.0, 2.0), (1.0, np.inf), (-np.inf, 2.0), (np.nan, np.nan))]
    assert said == ["95 %: 1 to 2", "95 %: above 1", "95 %: below 2", "95 %: any value"]


def test_an_end_that_only_the_limits_of_a_number_make_is_said_to_be_open() -> None:
    said = [
        interval_words(*ends, 3, allowed)
        for ends, allowed in (
            ((0.5, 2.0), (0.5, 2.0)),
            ((0.7, 2.0), (0.5, 2.0)),
            ((0.5, 1.0), (0.5, 2.0)),
            ((0.7, 1.0), (0.5, 2.0)),
            ((SMALLEST, np.inf), (SMALLEST, np.inf)),
            ((SMALLEST, 1.0), (SMALLEST, np.inf)),
            ((0.0, 1.0), (0.0, np.inf)),  # friction is never negative: an end as good as any
            ((-np.inf, 1.0), (0.0, np.inf)),
        )
    ]
    assert said == [
        "95 %: any value of those allowed, 0.5 to 2",
        "95 %: above 0.7, up to all that is allowed, 2",
        "95 %: below 1, down to all that is allowed, 0.5",
        "95 %: 0.7 to 1",
        "95 %: any value",
        "95 %: below 1",
        "95 %: 0 to 1",
        "95 %: below 1",
    ]


def held_at_zero() -> tuple[Rig, Log]:
    """A rig whose dry friction ends on its bound, and its log."""
    truth = platform("viscous = 0.02\ncoulomb = 0.0", free=FREE)
    return truth.with_values({"axis.friction.coulomb": 0.01}), log_of(truth, noise=1e-3)


def test_what_takes_long_is_heard_of() -> None:
    rig, log = held_at_zero()
    heard: list[str] = []
    fit(rig, [log], progress=heard.append)
    assert heard[0].startswith("fitting, start 1 of")
    assert "how far axis.friction.coulomb may go, 3 of 3 numbers" in heard


def test_a_profile_that_takes_too_long_is_left_to_the_standard_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(intervals, "MOST_TIME", 0.0)
    rig, log = held_at_zero()
    found = fit(rig, [log])
    k, name = 2, "axis.friction.coulomb"
    low, high = found.fit.coordinates.bounds[k]
    assert low <= found.interval[name][0] < found.interval[name][1] <= high
    (note,) = [note for note in found.notes if "there is no profile" in note]  # one, however many numbers it is about
    assert f"{name}: a standard error says little" in note
    assert not any("by its profile" in note for note in found.notes)


def test_the_profile_of_a_fit_in_other_time_steps_tells_the_same_ends() -> None:
    rig, log = held_at_zero()
    coarse, fine = fit(rig, [log]), fit(rig, [log], refine=2)
    ends, notes = intervals.intervals(fine.fit, fine.uncertainty, 0, lambda text: None, coarse.fit)
    assert fine.fit.problem.batch.h[0] < coarse.fit.problem.batch.h[0]
    assert any("axis.friction.coulomb" in note and "by its profile" in note for note in notes)
    for name, (low, high) in fine.interval.items():
        assert ends[name] == pytest.approx((low, high), abs=0.02 * (high - low)), name


def test_a_profile_in_coarse_steps_that_does_not_hold_the_estimate_is_made_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig, log = held_at_zero()
    found = fit(rig, [log]).fit
    rough, errors = replace(found, steps=0), uncertainty(found)
    value = float(found.theta[found.coordinates.index[2]])
    for of_rough, wanted in (
        ((value - 1.0, value + 1.0), (value - 1.0, value + 1.0)),
        ((value, np.inf), (value, np.inf)),
        ((value + 1.0, value + 2.0), (value - 3.0, value + 3.0)),
        ((value - 2.0, value - 1.0), (value - 3.0, value + 3.0)),
    ):
        ends = {id(rough): of_rough, id(found): (value - 3.0, value + 3.0)}
        monkeypatch.setattr(intervals, "interval", lambda of, *rest, ends=ends: ends[id(of)])
        told, _ = intervals.intervals(found, errors, 0, lambda text: None, rough)
        assert told["axis.friction.coulomb"] == wanted
