"""Comparison beside a remainder that is coloured noise: what readings say beside the ones before, not what squares of slow motions do."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.coloured_comparison import ColouredComparison
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.information_criterion import residuals
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.settings import PartialSettings, Settings
from tests.diagnosis.several_runs import run_of, searched

DRY, SPRING, CURVED = (Hypothesis((name,)) for name in ("axis.coulomb", "axis.spring", "axis.stribeck"))
FRICTION = {"axis.coulomb": {"M_c": 0.06}}


def test_a_true_name_is_likelier_beside_a_motion_that_nothing_explains_and_one_that_follows_the_motion_is_not() -> None:
    """A spring happens to follow the random walks of three runs: it removes nine tenths of what is left, of which little is independent."""
    both = DRY.plus("axis.spring")
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY, both)
    compare = ColouredComparison(search.fits)
    assert compare.excess(both) < 0.15 * compare.excess(DRY)
    assert compare.likelier(DRY, NOTHING) and not compare.likelier(both, DRY)
    assert ModelComparison(search.fits).likelier(
        both, DRY
    )  # as if the residual of the larger set were all that is slow


def test_the_gain_is_that_of_innovations_less_half_the_logarithm_of_the_readings_for_every_number() -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(2)], DRY)
    search.fits.settings = replace(Settings(), partial=PartialSettings(order=3))
    total, count = 0.0, 0
    for e, sign in ((DRY, 1.0), (NOTHING, -1.0)):
        series = residuals(search.fits.known(e), [0, 1])["yaw_rad"]
        now = np.concatenate([r[3:] for r in series])
        before = np.concatenate([np.stack([r[2:-1], r[1:-2], r[:-3]], axis=1) for r in series])
        a = np.linalg.solve(before.T @ before, before.T @ now)
        count = len(now)
        total -= sign * 0.5 * count * np.log(np.mean((now - before @ a) ** 2))
    gain = ColouredComparison(search.fits).gain(DRY, NOTHING)
    assert gain == pytest.approx(total - 0.5 * np.log(count), rel=1e-6) and gain > 100.0


@pytest.mark.parametrize(("needed", "by_reading", "enough"), [(1.0, 1e-3, True), (1e9, 1e-3, False), (1.0, 1e3, False)])
def test_a_name_has_to_gain_enough_altogether_and_by_the_reading(
    needed: float, by_reading: float, enough: bool
) -> None:
    search = searched([run_of(k, FRICTION) for k in range(2)], DRY)
    search.fits.settings = replace(Settings(), partial=PartialSettings(needed=needed, needed_by_reading=by_reading))
    assert ColouredComparison(search.fits).likelier(DRY, NOTHING) == enough


@pytest.mark.parametrize(("says", "enough"), [(6.0, True), (4.0, False)])
def test_squares_with_the_fewer_independent_readings_of_both_residuals_have_to_say_so_too(
    says: float, enough: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = searched([run_of(k, FRICTION) for k in range(2)], DRY)
    compare, readings = ColouredComparison(search.fits), list[dict[str, float]]()

    def criterion(e: Hypothesis, effective: dict[str, float]) -> float:
        readings.append(effective)
        return says if e.names else 0.0

    monkeypatch.setattr(compare, "criterion", criterion)
    monkeypatch.setattr(compare, "effective", lambda e: {"yaw_rad": 40.0 if e.names else 30.0})
    assert compare.likelier(DRY, NOTHING) == enough
    assert readings == [{"yaw_rad": 30.0}] * 2


@pytest.mark.parametrize(("holes", "alone", "enough"), [(0, 1e9, True), (3, 10.0, True), (3, 1e9, False)])
def test_between_holes_where_no_reading_follows_enough_others_the_squares_decide(
    holes: int, alone: float, enough: bool
) -> None:
    logs = [run_of(k, FRICTION) for k in range(2)]
    if holes:
        kept = [np.arange(len(log.time)) % holes > 0 for log in logs]
        logs = [
            replace(log, outputs={"yaw_rad": np.where(at, log.outputs["yaw_rad"], np.nan)})
            for log, at in zip(logs, kept, strict=True)
        ]
    search = searched(logs, DRY)
    search.fits.settings = replace(Settings(), partial=PartialSettings(needed_of_squares_alone=alone))
    assert ColouredComparison(search.fits).likelier(DRY, NOTHING) == enough


def test_what_a_prior_says_against_a_number_counts_against_the_gain(monkeypatch: pytest.MonkeyPatch) -> None:
    search = searched([run_of(k, FRICTION) for k in range(2)], DRY)
    before, named = ColouredComparison(search.fits).gain(DRY, NOTHING), search.fits.known(DRY)
    against = {id(named.theta): 7.0}
    monkeypatch.setattr(type(named.problem), "prior_cost", lambda self, theta: (against.get(id(theta), 0.0), None))
    assert ColouredComparison(search.fits).gain(DRY, NOTHING) == pytest.approx(before - 7.0)


def test_a_better_fit_is_asked_anew() -> None:
    search = searched([run_of(k, FRICTION) for k in range(2)], DRY)
    compare, named = ColouredComparison(search.fits), search.fits.known(DRY)
    assert compare.gain(DRY, NOTHING) > 100.0
    as_it_is = search.fits.known(NOTHING).evaluation.residual
    search.fits.put(DRY, replace(named, evaluation=named.evaluation._replace(residual=as_it_is)))
    assert compare.gain(DRY, NOTHING) < 0.0


def test_a_number_of_form_costs_one_and_what_left_the_range_of_numbers_gains_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = searched([run_of(k, FRICTION) for k in range(2)], DRY, CURVED)
    compare, likelihood = ColouredComparison(search.fits), {NOTHING: -3.0, DRY: -1.0, CURVED: -1.0}
    monkeypatch.setattr("rwjax.diagnosis.coloured_comparison.log_likelihood", lambda fitted, *_: (1000, of[id(fitted)]))
    of = {id(search.fits.known(e)): mean for e, mean in likelihood.items()}
    (numbers, form), (fewer, less) = (3, 1), (1, 0)  # M_c, M_e and v_s with the form n, and M_c alone
    assert compare.gain(DRY, NOTHING) == pytest.approx(2000.0 - 0.5 * np.log(1000.0))
    cost = 0.5 * (numbers - fewer) * np.log(1000.0) + (form - less)
    assert compare.gain(CURVED, DRY) == pytest.approx(-cost)
    of[id(search.fits.known(CURVED))] = -np.inf
    assert ColouredComparison(search.fits).gain(CURVED, DRY) == -np.inf
