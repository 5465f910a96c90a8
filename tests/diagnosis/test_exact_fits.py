"""Fits by exact derivatives."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from rwjax.diagnosis.budget import Budget, Stopped
from rwjax.diagnosis.exact_fits import fit_exactly, polish
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from rwjax.fitting.batched_runs import together
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import Problem
from rwjax.fitting.secant import residuals
from tests.diagnosis.simulated import fits_of, moved_to, true_log
from tests.systems import platform

NOTHING = Hypothesis()


@pytest.mark.slow
def test_a_fit_by_exact_derivatives_leaves_a_place_where_whole_runs_end() -> None:
    rig, named = platform("viscous = 0.02"), Hypothesis(("drive.saturation",))
    fits = fits_of(rig, true_log(rig, **{"drive.saturation": {"u_m": 0.9, "n": 2.0}}))
    SuccessiveHalving(fits).fit([named], NOTHING)
    moved_to(fits, named, {"drive.saturation.u_m": 0.7, "drive.saturation.n": 300.0})
    fit_exactly(fits, [named])
    found = fits.known(named)
    assert 2.0 * found.cost < 1.2 * found.problem.batch.readings
    assert [found.numbers()[f"drive.saturation.{name}"] for name in ("u_m", "n")] == pytest.approx([0.9, 2.0], rel=0.1)


@pytest.mark.slow
def test_exact_derivatives_take_several_and_leave_what_reaches_back_too_far() -> None:
    rig = platform("viscous = 0.02")
    several = [Hypothesis((name,)) for name in ("axis.coulomb", "sensor.delay", "axis.quadratic_drag")]
    fits = fits_of(rig, true_log(rig, **{"axis.quadratic_drag": {"c": 0.01}}))
    SuccessiveHalving(fits).fit(several, NOTHING)
    late, before = several[1], [fits.known(e) for e in several]
    fit_exactly(fits, several)
    after = [fits.known(e) for e in several]
    assert fits.known(late) is before[1]
    assert all(b.cost <= a.cost for a, b in zip(before, after, strict=True))
    fit_exactly(fits, several)
    assert all(fits.known(e) is f for e, f in zip(several, after, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "numbers"),
    [("axis.stribeck", {"M_c": 0.05, "M_e": 0.03, "v_s": 0.3, "n": 1.5}), ("sensor.delay", {"tau": 0.03})],
)
def test_a_fit_by_exact_derivatives_holds_the_residual_of_its_free_runs(effect: str, numbers: dict[str, float]) -> None:
    rig, named = platform("viscous = 0.02"), Hypothesis((effect,))
    fits = fits_of(rig, true_log(rig, **{effect: numbers}))
    SuccessiveHalving(fits).fit([named], NOTHING)
    fits.put(named, replace(fits.known(named), cost=np.inf))  # whatever is found now is taken
    fit_exactly(fits, [named])
    found = fits.known(named)
    free_run = together([residuals(found.problem, [found.theta], [found.start])])[0][0]
    assert found.evaluation.residual == pytest.approx(free_run, abs=1e-6)
    assert {name: found.numbers()[f"{effect}.{name}"] for name in numbers} == pytest.approx(numbers, rel=0.05)
    before = found.cost
    assert polish(fits, named).cost <= before and fits.ended(named)


def test_what_threads_begin_after_the_search_has_left_ends_with_that_search(monkeypatch: pytest.MonkeyPatch) -> None:
    rig, named, now = platform("viscous = 0.02"), Hypothesis(("axis.coulomb",)), [0.0]
    budget, left = Budget(10.0, lambda: now[0]), []

    def late(trial: Callable[..., Fit], problems: Sequence[Problem], begun: Sequence[Fit]) -> list[Fit]:
        left.append(partial(trial, problems[0], begun[0]))
        raise Stopped

    fits = fits_of(rig, true_log(rig, **{"axis.coulomb": {"M_c": 0.05}}))
    fits.headway.budget = budget
    SuccessiveHalving(fits).fit([named], NOTHING)
    monkeypatch.setattr("rwjax.diagnosis.exact_fits.on_threads", late)
    with suppress(Stopped), budget.searching():
        budget.keep(0.5)
        fit_exactly(fits, [named])
    now[0] += 6.0
    with budget.searching(), pytest.raises(Stopped):
        left[0]()
