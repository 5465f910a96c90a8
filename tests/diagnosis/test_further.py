"""What may be claimed of a choice: where a law outside the list may stand for a name, and where something holds a part of the rig."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from rwjax import diagnose
from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.further import Further, may_be_claimed
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.judged import Judged, errors_of_the_rig
from rwjax.diagnosis.layout import laid_out
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.outside_laws import OutsideLaw
from rwjax.diagnosis.partial import Claim, Holding
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.forward_backward import ForwardBackward
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.diagnosis.settings import PartialSettings, Settings
from rwjax.logs.log import Log
from tests.diagnosis.several_runs import RIG, TIME, run_of
from tests.systems import platform, record, run, wheel

DRY, STRIBECK, BIAS = (Hypothesis((name,)) for name in ("axis.coulomb", "axis.stribeck", "axis.bias_torque"))
TRUTH = {DRY: {"axis.coulomb": {"M_c": 0.06}}, BIAS: {"axis.bias_torque": {"T": 0.02}}}
STIFF = replace(platform("viscous = 0.4"), free=("axis.inertia", "axis.friction.viscous"))
OUTSIDE = "rwjax.diagnosis.further.doing_as_well"


def claimed_of(truth: Hypothesis, alternatives: Sequence[Hypothesis], *beside: str) -> Further:
    """What may be claimed of a name that explains its runs, where some sets stand beside it."""
    layout = laid_out(RIG, [run_of(k, TRUTH[truth]) for k in range(3)])
    fits = ModelFits.of(RIG, layout.logs, layout.train)
    fits(NOTHING)
    fits.start_from_first_readings()
    choice = ForwardBackward().choose(fits, (*truth.names, *STRIBECK.names))
    assert choice.best == truth
    judged = Judged(fits, layout, errors_of_the_rig(fits, layout), "yaw_rad")
    return may_be_claimed(judged, replace(choice, alternatives=tuple(alternatives)), (*truth.names, *beside))


@pytest.mark.parametrize("alternatives", [(), (STRIBECK,)])
def test_a_law_is_asked_of_what_stands_beside_the_choice_too(
    alternatives: tuple[Hypothesis, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(OUTSIDE, lambda fits, asked: list(asked))
    found = claimed_of(BIAS, alternatives)
    assert found.complete and {*found.refused} == {name for e in alternatives for name in e.names}
    assert found.outside == tuple(e for one in alternatives for e in (one, Hypothesis(("axis.growing_stiction",))))


@pytest.mark.parametrize(("better_by", "stands"), [(1.0, True), (50.0, False)])
def test_a_law_takes_a_claim_that_is_its_special_case_away_where_it_is_needed(
    better_by: float, stands: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def found_better(fits: ModelFits, asked: Sequence[OutsideLaw]) -> list[OutsideLaw]:
        monkeypatch.setattr("rwjax.diagnosis.further.ModelComparison.gain", lambda self, larger, smaller: better_by)
        return list(asked)

    monkeypatch.setattr(OUTSIDE, found_better)
    found = claimed_of(DRY, (STRIBECK,))
    assert found.complete and {*found.refused} == (set() if stands else {*STRIBECK.names})


def test_errors_are_judged_anew_behind_the_fits_of_a_law(monkeypatch: pytest.MonkeyPatch) -> None:
    def moved(fits: ModelFits, asked: Sequence[OutsideLaw]) -> list[OutsideLaw]:
        better = fits(BIAS)
        worse = replace(better, theta=better.theta * np.where(np.arange(len(better.theta)) == 0, 1.2, 1.0))
        fits.put(BIAS, worse, ended=True)
        return []

    before = claimed_of(BIAS, ()).judged.rms(BIAS)
    monkeypatch.setattr(OUTSIDE, moved)
    assert claimed_of(BIAS, (STRIBECK,)).judged.rms(BIAS) > 1.5 * before


def test_nothing_is_claimed_where_the_budget_ends_before_a_law_was_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    def ended(fits: ModelFits, asked: Sequence[OutsideLaw]) -> list[OutsideLaw]:
        raise Stopped

    monkeypatch.setattr(OUTSIDE, ended)
    assert claimed_of(BIAS, ()).complete and not claimed_of(BIAS, (STRIBECK,)).complete
    held = Holding(Claim(DRY, (STRIBECK,), ()), {})
    monkeypatch.setattr("rwjax.diagnosis.further.claimed", lambda search, choice: held)
    found = diagnose(RIG, [run_of(k, TRUTH[DRY], disturbed=0.05) for k in range(3)], only=["axis.coulomb"])
    assert (found.verdict, found.complete) == ("unknown", False)  # nor in part


@pytest.mark.parametrize(
    ("settled", "holds"), [(True, True), pytest.param(True, False, marks=pytest.mark.slow), (False, False)]
)
def test_where_the_budget_ends_the_search_for_more_what_holds_of_a_settled_choice_is_claimed(
    settled: bool, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def ended(self: FurtherSearch, begin: Hypothesis) -> Choice:
        self.settled = self.chosen(begin, self.rivals(begin)) if settled else None
        raise Stopped

    monkeypatch.setattr(FurtherSearch, "go_on", ended)
    if settled and not holds:
        monkeypatch.setattr("rwjax.diagnosis.further.claimed", lambda search, choice: Holding(None, {}))
    logs = [run_of(k, TRUTH[DRY], disturbed=0.05) for k in range(3)]
    found = diagnose(RIG, logs, only=["axis.coulomb", "axis.spring"])
    assert not found.complete and found.untried == () and found.effects == DRY.names
    assert found.verdict == ("partial" if holds else "unknown")
    told = "ended the search for what is missing beside dry friction" if holds else "and nothing is"
    assert any(told in remark for remark in found.remarks)
    assert ("; the search for the rest was ended" in found.sentence) == holds
    assert found.sentence.startswith("Only in part" if holds else "Unfinished")
    assert found.next_experiment.startswith("none before the search has come to its end")
    assert [rung.names for rung in found.waterfall] == [(), DRY.names]


@pytest.mark.parametrize("closes", [True, False])
def test_a_search_that_was_ended_claims_no_more_than_a_part_and_says_of_none_that_it_holds(
    closes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The held-out runs are explained, and the fitted ones keep a visible part; or what holds closes too little."""

    def ended(self: FurtherSearch, begin: Hypothesis) -> Choice:
        self.settled = self.chosen(begin, self.rivals(begin))
        raise Stopped

    monkeypatch.setattr(FurtherSearch, "go_on", ended)
    monkeypatch.setattr("rwjax.diagnosis.further.ModelComparison.leaves_visible", lambda self, e: True)
    monkeypatch.setattr("rwjax.diagnosis.further.ModelComparison.leaves_something", lambda self, e: True)
    settings = Settings() if closes else Settings(partial=PartialSettings(closes=2.0))
    found = diagnose(RIG, [run_of(k, TRUTH[DRY]) for k in range(3)], only=["axis.coulomb"], settings=settings)
    assert (found.verdict, found.complete) == ("partial" if closes else "unknown", False)
    assert any("which holds by what was compared" in remark for remark in found.remarks) == closes
    assert (found.left is not None and 0.0 <= found.left.share < 0.01) == closes


@pytest.mark.parametrize("no", ["", "far", "unsure", "still"])
def test_nothing_is_claimed_where_an_output_stands_still_by_a_number_that_ran_away(
    no: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    away, far, unsure, held = ("axis.inertia",), no != "far", no != "unsure", not no
    monkeypatch.setattr("rwjax.diagnosis.further.stands_still", lambda fitted, limits: no != "still")
    monkeypatch.setattr("rwjax.diagnosis.further.diverged_numbers", lambda rig, fitted, limits: away if far else ())
    monkeypatch.setattr("rwjax.diagnosis.further.ran_away", lambda rig, fitted: away if unsure else ())
    found = claimed_of(DRY, ())
    assert found.complete and found.held == (away if held else ())
    assert {*found.refused} == ({*DRY.names} if held else set())


def of_a_drive_that_lags(early: float) -> list[Log]:
    """Runs whose readings are stamped some time [s] too early, as the sampling of a rig may have it."""
    logs, rng = [], np.random.default_rng(0)
    for k in range(3):
        command = np.where(TIME > 0.6, (2.0 + k) * np.sign(np.sin((0.8 + 0.3 * k) * TIME)), 0.0)
        asked = record(TIME, command, dict.fromkeys(("yaw_rad", "yaw_rad_s"), np.zeros(len(TIME))))
        y = run(STIFF, asked, {}, effects={"drive.lag": {"T": 0.12}})
        angle = y["yaw_rad"] + early * y["yaw_rad_s"] + rng.normal(0.0, 1e-3, len(TIME))
        logs.append(replace(record(TIME, command, {"yaw_rad": angle}), name=f"{k}.csv"))
    return logs


@pytest.mark.parametrize("early", [pytest.param(0.0, marks=pytest.mark.slow), 1e-3])
def test_a_law_of_fewer_numbers_that_leaves_as_little_stands_beside_the_choice_whatever_the_evidence(
    early: float,
) -> None:
    found = diagnose(STIFF, of_a_drive_that_lags(early), only=("drive.lag", "axis.flexible_coupling"))
    assert found.verdict == ("ambiguous" if early else "effect")
    assert "drive.lag" in {name for names in (found.effects, *found.alternatives) for name in names}


def test_a_number_that_the_file_only_guesses_takes_no_claim_away() -> None:
    guessed = replace(RIG.with_values({"axis.friction.viscous": 1e-9}), free=("axis.friction.viscous",))
    logs = [run_of(k, {"axis.coulomb": {"M_c": 0.06}}) for k in range(3)]
    found = diagnose(guessed, logs, only=["axis.coulomb"])
    assert found.corrected.values["axis.friction.viscous"] > 1e5 * 1e-9
    assert found.effects == ("axis.coulomb",) and found.verdict in ("effect", "ambiguous") and not found.refused


def test_a_wheel_that_something_holds_is_not_explained_by_what_warms_up() -> None:
    rig, logs = replace(wheel(0.0), free=("wheel.inertia", "motor.friction")), []
    for k in range(3):
        command = np.where(TIME > 0.6, (0.6 + 0.2 * k) * np.sign(np.sin((0.8 + 0.2 * k) * TIME)), 0.0)
        truth = {"wheel.coulomb": {"M_c": 1.0}, "motor.heating": {"c": 0.05, "tau": 5.0}}
        y, rng = run(rig, record(TIME, command), {}, effects=truth), np.random.default_rng(k)
        outputs = {name: y[name] + rng.normal(0.0, 0.01, len(TIME)) for name in ("wheel_rad_s", "current_A")}
        logs.append(replace(record(TIME, command, outputs), name=f"{k}.csv"))
    found = diagnose(rig, logs, only=("motor.heating",))
    assert found.verdict == "unknown"
    assert "runs away, as where something holds a part" in found.refused["motor.heating"]
    assert found.next_experiment.startswith("runs in which what") and found.next_experiment.endswith("turns")


@pytest.mark.parametrize("holds", ["further", "first", "neither"])
def test_where_nothing_holds_beside_a_further_name_the_first_choice_is_asked_alone(
    holds: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What stands in for something small beside a name may take that name's place."""
    both, asked = DRY.plus(*BIAS.names), list[Hypothesis]()

    def claimed(search: FurtherSearch, choice: Choice) -> Holding:
        asked.append(choice.best)
        if holds == {both: "further", DRY: "first"}[choice.best]:
            return Holding(Claim(choice.best, (), ()), {})
        return Holding(None, dict.fromkeys(choice.best.names, "it is not needed"))

    monkeypatch.setattr("rwjax.diagnosis.further.claimed", claimed)
    for left in ("visible", "something"):
        monkeypatch.setattr(f"rwjax.diagnosis.further.ModelComparison.leaves_{left}", lambda *_: True)
    monkeypatch.setattr("rwjax.diagnosis.further.FurtherSearch.go_on", lambda self, begin: with_both(self))

    def with_both(search: FurtherSearch) -> Choice:
        search.halving.fit([both], DRY)
        return Choice(both)

    found = claimed_of(DRY, (), *BIAS.names)
    assert asked == ([both] if holds == "further" else [both, DRY])
    assert (found.claim and found.claim.named) == {"further": both, "first": DRY, "neither": None}[holds]
    assert {*found.refused} == {"further": set(), "first": {*BIAS.names}, "neither": {*both.names}}[holds]
    assert not found.judged.fits.by_start_rule  # first states are free where the search goes on
    assert not found.followed


def test_a_first_choice_that_another_explanation_beats_is_not_claimed_where_what_was_found_further_does_not_hold(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A bias is asked again where dry friction, which leaves less by far, is refused."""

    def claimed(search: FurtherSearch, choice: Choice) -> Holding:
        if choice.best == BIAS:
            return Holding(Claim(BIAS, (), ()), {})
        return Holding(None, dict.fromkeys(choice.best.names, "it is not needed"))

    layout = laid_out(RIG, [run_of(k, TRUTH[DRY]) for k in range(3)])
    fits = ModelFits.of(RIG, layout.logs, layout.train)
    fits(NOTHING)
    fits.start_from_first_readings()
    search = FurtherSearch(fits, (*BIAS.names, *DRY.names))
    search.halving.fit([DRY, BIAS], NOTHING)
    fits.finish([DRY, BIAS])
    monkeypatch.setattr("rwjax.diagnosis.further.claimed", claimed)
    monkeypatch.setattr("rwjax.diagnosis.further.FurtherSearch.go_on", lambda self, begin: self.chosen(DRY, []))
    judged = Judged(fits, layout, errors_of_the_rig(fits, layout), "yaw_rad")
    found = may_be_claimed(judged, Choice(BIAS, criterion={NOTHING: 0.0, BIAS: 1.0}), search.candidates)
    assert found.claim is None and {*found.refused} == {*BIAS.names, *DRY.names}
