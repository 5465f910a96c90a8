"""Partial: names that hold beside something that no effect explains, and imitations that do not."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.agreement import Amplitude, amplitudes
from rwjax.diagnosis.comparison_by_runs import ComparisonByRuns
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis, coordinate_of
from rwjax.diagnosis.left_out import LeftOut
from rwjax.diagnosis.partial import claimed, further_laws, why_not_in_every_run, why_not_of_its_form
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.diagnosis.settings import PartialSettings, SearchSettings, Settings
from tests.diagnosis.several_runs import RIG, run_of, searched

DRY, BIAS, OFFSET, SPRING = (
    Hypothesis((name,)) for name in ("axis.coulomb", "axis.bias_torque", "drive.bias", "axis.spring")
)
ANY = PartialSettings(
    as_much=1e9,
    needed=-1e9,
    needed_by_reading=-1e9,
    needed_of_squares=-1e9,
    sigmas=1e9,
    harms=np.inf,
    less_likely=np.inf,
)  # under which any rival stands
FRICTION = {"axis.coulomb": {"M_c": 0.06}}
PUSHED = {"axis.bias_torque": {"T": 0.02}}


def why_not(search: FurtherSearch, best: Hypothesis, name: str) -> str | None:
    by_runs = search.by_runs
    return why_not_in_every_run(by_runs, best, name) or why_not_of_its_form(by_runs, best, name)


@pytest.mark.slow
def test_a_true_name_holds_beside_a_motion_that_nothing_explains() -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY, BIAS, SPRING)
    assert search.comparison.excess(DRY) > 100.0  # far from the noise
    claim, refused = claimed(search, Choice(DRY))
    assert claim is not None and claim.named == DRY and claim.alternatives == () and not refused


@pytest.mark.slow
def test_a_name_of_which_every_run_asks_for_another_amount_does_not_hold() -> None:
    logs = [run_of(k, {"axis.bias_torque": {"T": torque}}) for k, torque in enumerate((0.02, 0.02, 0.08))]
    search = searched(logs, BIAS, SPRING)
    search.fits.settings = replace(
        Settings(), partial=PartialSettings(needed=-np.inf, needed_by_reading=-np.inf, needed_of_squares=-np.inf)
    )
    why = "runs or sizes of the command ask for different amounts of it"
    assert why_not(search, BIAS, "axis.bias_torque") == why
    assert claimed(search, Choice(BIAS)) == (None, {"axis.bias_torque": why})


def test_a_name_that_leaves_little_of_fitted_and_of_left_out_runs_is_needed_whatever_its_gain(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY, SPRING)
    search.fits.settings = replace(Settings(), partial=PartialSettings(needed=np.inf))
    coloured = "it is not needed beside a remainder that is coloured noise"
    assert why_not_in_every_run(search.by_runs, SPRING, "axis.spring") == coloured
    assert why_not_in_every_run(search.by_runs, DRY, "axis.coulomb") is None
    for excess in ("left_out.LeftOut.excess", "partial.ModelComparison.excess"):  # of the others it leaves as much
        with monkeypatch.context() as patched:
            patched.setattr(f"rwjax.diagnosis.{excess}", lambda *_: 1.0)
            assert why_not_in_every_run(search.by_runs, DRY, "axis.coulomb") == coloured


def test_a_name_that_explains_nearly_all_is_not_asked_for_by_each_run_in_the_same_amount_but_makes_none_worse(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    logs = [run_of(k, {"axis.bias_torque": {"T": torque}}) for k, torque in enumerate((0.02, 0.02, 0.08))]
    search = searched(logs, BIAS)
    search.fits.settings = replace(
        Settings(),
        partial=PartialSettings(needed=-np.inf, needed_by_reading=-np.inf, needed_of_squares=-np.inf, mostly=0.0),
    )
    differs = "runs or sizes of the command ask for different amounts of it"
    of_left_out, of_fitted = "left_out.LeftOut.excess", "partial.ModelComparison.excess"
    for fitted, left, worst, why in (
        (0.09, 0.09, 1.0, None),
        (0.1, 0.09, 1.0, differs),
        (0.09, 0.1, 1.0, differs),
        (0.09, 0.09, 1.2, differs),
    ):
        for excess, share in ((of_fitted, fitted), (of_left_out, left)):
            monkeypatch.setattr(f"rwjax.diagnosis.{excess}", lambda _, e, share=share: share if e.names else 1.0)
        squares = {False: {0: 1.0, 1: 1.0}, True: {0: 0.1, 1: worst}}
        monkeypatch.setattr("rwjax.diagnosis.left_out.LeftOut.__call__", lambda _, e, s=squares: s[bool(e.names)])
        assert why_not_in_every_run(search.by_runs, BIAS, "axis.bias_torque") == why


@pytest.mark.parametrize(
    ("odd", "weight", "fitted", "left", "followed", "needed", "holds"),
    [
        (0.5, 0.1, 0.49, 0.29, 1.3, 0.0, True),
        (0.0, 0.1, 0.49, 0.29, 0.3, 0.0, False),  # too unevenly
        (0.5, 0.15, 0.49, 0.29, 0.3, 0.0, False),
        (0.5, 0.1, 0.5, 0.29, 0.3, 0.0, False),
        (0.5, 0.1, 0.49, 0.3, 0.3, 0.0, False),
        (0.7, 0.19, 0.49, 0.29, 1.3, 0.0, True),
        (0.7, 0.2, 0.49, 0.29, 1.3, 0.0, False),  # the run that is followed worse holds a fifth of the change
        (0.5, 0.1, 0.49, 0.29, 0.3, np.inf, False),  # it gains too little altogether
    ],
)
def test_a_small_part_may_ask_for_another_amount_of_a_name_that_explains_most_of_left_out_runs(
    odd: float,
    weight: float,
    fitted: float,
    left: float,
    followed: float,
    needed: float,
    holds: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY)
    limits = PartialSettings(needed=needed, needed_by_reading=np.inf, needed_of_squares=-np.inf)
    search.fits.settings = replace(Settings(), partial=limits)
    rest = 0.5 * (1.0 - weight)
    asked = [Amplitude(odd, 0.01, weight, 0), Amplitude(1.0, 0.01, rest, 1), Amplitude(1.0, 0.01, rest, 2)]
    monkeypatch.setattr("rwjax.diagnosis.partial.amplitudes", lambda *_: asked)
    squares = {True: {0: followed, 1: 0.2, 2: 0.2}, False: dict.fromkeys(range(3), 1.0)}
    monkeypatch.setattr("rwjax.diagnosis.left_out.LeftOut.__call__", lambda _, e: squares[bool(e.names)])
    monkeypatch.setattr("rwjax.diagnosis.left_out.LeftOut.excess", lambda _, e: left if e.names else 1.0)
    monkeypatch.setattr(type(search.by_runs.in_sample), "excess", lambda _, e: fitted if e.names else 1.0)
    coloured = "it is not needed beside a remainder that is coloured noise"
    assert why_not_in_every_run(search.by_runs, DRY, "axis.coulomb") == (None if holds else coloured)
    asked[1:] = [Amplitude(1.0, 0.01, 1.0 - weight, 1)]  # one run alone tells the amplitude, and agrees
    if odd == 0.5:
        assert why_not_in_every_run(search.by_runs, DRY, "axis.coulomb") == coloured


def test_a_name_that_leaves_little_of_left_out_runs_is_asked_for_no_law(monkeypatch: pytest.MonkeyPatch) -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY)
    monkeypatch.setattr("rwjax.diagnosis.partial.law_left", lambda *_: 1.1)
    monkeypatch.setattr("rwjax.diagnosis.partial.ModelComparison.excess", lambda *_: 1.0)
    assert why_not_of_its_form(search.by_runs, DRY, "axis.coulomb") is None
    monkeypatch.setattr("rwjax.diagnosis.left_out.LeftOut.excess", lambda _, e: 0.09 if e.names else 1.0)
    assert why_not_of_its_form(search.by_runs, DRY, "axis.coulomb") == "a free-form law of its coordinate explains more"
    monkeypatch.setattr("rwjax.diagnosis.partial.law_left", lambda *_: 0.9)  # small causes may leave most of it
    assert why_not_of_its_form(search.by_runs, DRY, "axis.coulomb") is None
    monkeypatch.setattr("rwjax.diagnosis.partial.law_left", lambda *_: 1.1)
    near = {False: 0.05, True: 0.0}  # nothing of what is hardly anything
    monkeypatch.setattr("rwjax.diagnosis.left_out.LeftOut.excess", lambda _, e: near[bool(e.names)])
    assert why_not_of_its_form(search.by_runs, DRY, "axis.coulomb") == "a free-form law of its coordinate explains more"


def test_beside_another_name_of_its_coordinate_a_name_leaves_no_more_than_half(monkeypatch: pytest.MonkeyPatch) -> None:
    alike, apart = DRY.plus("axis.quadratic_drag"), DRY.plus("axis.bias_torque")
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY, alike, apart)
    monkeypatch.setattr("rwjax.diagnosis.partial.ModelComparison.excess", lambda *_: 1.0)
    monkeypatch.setattr("rwjax.diagnosis.left_out.LeftOut.excess", lambda *_: 1.0)
    for share, whys in {0.4: (None, None), 0.9: ("a free-form law of its coordinate explains more", None)}.items():
        monkeypatch.setattr("rwjax.diagnosis.partial.law_left", lambda *_, share=share: share)
        assert tuple(why_not_of_its_form(search.by_runs, e, "axis.coulomb") for e in (alike, apart)) == whys


def test_one_run_is_too_few_to_say_that_every_run_agrees() -> None:
    search = searched([run_of(0, PUSHED)], BIAS, SPRING)
    assert why_not(search, BIAS, "axis.bias_torque") == "too few runs tell how much of it they ask for"


@pytest.mark.parametrize(("asks", "why"), [(1.1, None), (2.0, "too few runs tell how much of it they ask for")])
def test_a_run_that_holds_little_of_a_change_tells_its_amplitude_all_the_same(
    monkeypatch: pytest.MonkeyPatch, asks: float, why: str | None
) -> None:
    """A stiff loop moves by a tenth of what a free arm does."""
    search = searched([run_of(k, PUSHED) for k in range(2)], BIAS)
    each_is_asked = PartialSettings(nearly_all=0.0, mostly=0.0)
    search.fits.settings = replace(Settings(), partial=each_is_asked)
    parts = [Amplitude(1.0, 0.01, 0.99, 0), Amplitude(asks, 0.05, 0.01, 1)]
    monkeypatch.setattr("rwjax.diagnosis.partial.amplitudes", lambda *_: parts)
    assert why_not_in_every_run(search.by_runs, BIAS, "axis.bias_torque") == why


@pytest.mark.slow
def test_of_a_set_the_names_stay_that_hold() -> None:
    both = DRY.plus("axis.spring")  # of which there is none; three random walks happen to look a little like it
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY, both)
    why = "it is not needed beside a remainder that is coloured noise"
    assert why_not(search, both, "axis.spring") == why
    claim, refused = claimed(search, Choice(both))
    assert claim is not None and claim.named == DRY and refused == {"axis.spring": why}


@pytest.mark.slow
def test_what_leaves_as_much_stands_beside_the_name_and_many_such_leave_nothing_to_claim() -> None:
    search = searched([run_of(k, PUSHED, disturbed=0.03) for k in range(3)], BIAS, OFFSET, DRY)
    claim, _ = claimed(search, Choice(BIAS))
    assert claim is not None and claim.named == BIAS and claim.alternatives == claim.equivalents == (OFFSET,)
    every = replace(ANY, alternatives=0)  # then dry friction leaves about as much
    search.fits.settings = replace(Settings(), partial=every)
    assert claimed(search, Choice(BIAS)) == (None, {"axis.bias_torque": "many other names leave about as much"})
    search.fits.settings = replace(Settings(), partial=replace(every, needed=PartialSettings().needed))
    claim, _ = claimed(search, Choice(BIAS))  # and is no rival, since it is not needed
    assert claim is not None and claim.alternatives == (OFFSET,)


@pytest.mark.slow
def test_parts_of_a_set_are_no_rivals_of_it() -> None:
    both = DRY.plus("axis.bias_torque")
    search = searched([run_of(k, FRICTION | PUSHED, disturbed=0.03) for k in range(3)], DRY, BIAS, OFFSET, both)
    search.fits.settings = replace(Settings(), partial=PartialSettings(as_much=1e9))
    claim, _ = claimed(search, Choice(both))
    assert claim is not None and claim.named == both
    assert not any({*e.names} < {*both.names} for e in (*claim.alternatives, *claim.rivals))


def test_a_name_that_fails_stays_beside_the_others_while_these_are_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    both, seen = DRY.plus("axis.bias_torque"), []
    search = searched([run_of(k, FRICTION | PUSHED) for k in range(3)], DRY, both)

    def of_its_form(by_runs: ComparisonByRuns, best: Hypothesis, name: str) -> str | None:
        seen.append((best, name))
        return "another form" if name == "axis.bias_torque" else None

    monkeypatch.setattr("rwjax.diagnosis.partial.why_not_of_its_form", of_its_form)
    claim, refused = claimed(search, Choice(both))
    assert claim is not None and claim.named == DRY and refused == {"axis.bias_torque": "another form"}
    assert {best for best, _ in seen} == {both}


@pytest.mark.slow
def test_two_names_that_stand_in_for_each_other_give_way_one_by_one() -> None:
    """Viscous friction as an effect and as a number of the file: neither is needed beside the other."""
    twice = Hypothesis(("axis.viscous", "parameter.axis.friction.viscous"))
    search = searched(
        [run_of(k, {"axis.viscous": {"b": 0.05}}) for k in range(3)], Hypothesis(("axis.viscous",)), twice
    )
    claim, refused = claimed(search, Choice(twice))
    assert claim is not None and len(claim.named.names) == 1 and len(refused) == 1
    assert {*refused.values()} == {"it is not needed beside a remainder that is coloured noise"}


@pytest.mark.slow
def test_a_name_that_leaves_something_of_its_own_coordinate_has_not_the_right_form() -> None:
    truth = {"axis.quadratic_drag": {"c": 0.04}}
    linear, drag = Hypothesis(("parameter.axis.friction.viscous",)), Hypothesis(("axis.quadratic_drag",))
    search = searched(
        [run_of(k, truth) for k in range(3)], linear, drag, BIAS, linear.plus(*drag.names), linear.plus(*BIAS.names)
    )
    laws = further_laws(search.fits, linear)
    assert laws["yaw_rate"] > 0.9 > laws[coordinate_of("axis.bias_torque")]
    search.fits.settings = replace(Settings(), partial=PartialSettings(law_left=np.inf))
    assert (
        why_not(search, linear, linear.names[0])
        == "a further law of its coordinate removes part of what it leaves, and changes it"
    )
    assert further_laws(search.fits, drag) == {}  # which leaves nothing


def test_a_further_law_says_nothing_where_left_out_runs_are_followed_no_better(monkeypatch: pytest.MonkeyPatch) -> None:
    linear, both = Hypothesis(("parameter.axis.friction.viscous",)), ("axis.quadratic_drag",)
    search = searched([run_of(k, {"axis.quadratic_drag": {"c": 0.04}}) for k in range(2)], linear, linear.plus(*both))
    search.fits.settings = replace(Settings(), partial=PartialSettings(law_left=np.inf))
    assert why_not_of_its_form(search.by_runs, linear, linear.names[0]) is not None
    monkeypatch.setattr(LeftOut, "excess", lambda _, e: 100.0 * len(e.names))
    assert why_not_of_its_form(search.by_runs, linear, linear.names[0]) is None


@pytest.mark.slow
def test_a_rival_that_does_not_follow_left_out_runs_does_not_stand_beside_a_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = searched([run_of(k, PUSHED, disturbed=0.03) for k in range(2)], BIAS, OFFSET, DRY)
    search.fits.settings = replace(
        Settings(),
        partial=PartialSettings(
            needed=-1e9, needed_by_reading=-1e9, needed_of_squares=-1e9, sigmas=1e9, as_much=1e9, less_likely=1e9
        ),
    )
    claim, _ = claimed(search, Choice(BIAS))
    assert claim is not None and DRY in claim.alternatives
    monkeypatch.setattr(LeftOut, "excess", lambda _, e: 1e12 if e == DRY else 10.0)
    claim, _ = claimed(search, Choice(BIAS))
    assert claim is not None and DRY not in claim.alternatives


@pytest.mark.slow
def test_a_smaller_law_of_its_coordinate_says_nothing_against_a_name_that_stays_what_it_is_beside_it() -> None:
    truth = {"drive.saturation": {"u_m": 0.6, "n": 5000.0}, "drive.bias": {"u_b": 0.02}}
    bends = Hypothesis(("drive.saturation",))
    search = searched([run_of(k, truth) for k in range(3)], bends, OFFSET, bends.plus(*OFFSET.names))
    assert coordinate_of("drive.saturation") == coordinate_of("drive.bias")
    assert further_laws(search.fits, bends)["voltage"] > 0.9
    search.fits.settings = replace(Settings(), partial=PartialSettings(law_left=np.inf))
    assert why_not_of_its_form(search.by_runs, bends, "drive.saturation") is None
    search.fits.settings = replace(Settings(), partial=PartialSettings(law_left=np.inf, differs=0.0))
    assert why_not_of_its_form(search.by_runs, bends, "drive.saturation") is not None


@pytest.mark.slow
def test_a_search_that_goes_on_asks_a_further_name_for_less(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []

    class Watched(FurtherSearch):
        def go_on(self, begin: Hypothesis) -> Choice:
            asked.append(self.comparison.further_removes)
            return super().go_on(begin)

    monkeypatch.setattr("rwjax.diagnosis.further.FurtherSearch", Watched)
    diagnose(RIG, [run_of(k, FRICTION, disturbed=0.3) for k in range(3)], only=DRY.names)
    assert asked == [PartialSettings().further_removes]


@pytest.mark.slow
def test_a_further_law_of_another_part_of_the_rig_says_nothing_against_a_name() -> None:
    """A delay of the readings and a periodic torque both go with time."""
    truth = {"sensor.delay": {"tau": 0.2}, "axis.periodic_torque": {"s": 0.02, "c": 0.0, "omega": 3.0}}
    late = Hypothesis(("sensor.delay",))
    search = searched([run_of(k, truth) for k in range(3)], late, late.plus("axis.periodic_torque"))
    assert coordinate_of("sensor.delay") == coordinate_of("axis.periodic_torque")
    assert further_laws(search.fits, late)["time"] > PartialSettings().further_law
    assert why_not_of_its_form(search.by_runs, late, "sensor.delay") is None


def test_where_a_set_reaches_the_noise_the_evidence_says_what_stands_beside_it() -> None:
    search = searched([run_of(k, PUSHED) for k in range(3)], BIAS, DRY)
    assert search.comparison.excess(BIAS) < 0.1
    claim, refused = claimed(search, Choice(BIAS, (OFFSET,), (OFFSET,)))
    assert claim == (BIAS, (OFFSET,), (OFFSET,), ()) and not refused


WORSE = "a run that is left out is followed worse with it"


@pytest.mark.parametrize(
    ("worse", "second", "why"),
    [
        ((0.9, 0.19), (1.1, 0.3), None),
        ((0.9, 0.2), (1.1, 0.3), WORSE),  # it holds a fifth of the change
        ((0.84, 0.19), (1.1, 0.3), WORSE),  # it asks for less
        ((0.9, 0.19), (1.16, 0.3), WORSE),  # one other alone asks for as much
        ((0.9, 0.19), (1.1, 0.04), WORSE),  # one other alone holds a part of the change
    ],
)
def test_a_run_that_is_followed_worse_may_hold_little_of_the_change_and_ask_for_as_much_as_two_others(
    worse: tuple[float, float], second: tuple[float, float], why: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY)
    search.fits.settings = replace(Settings(), partial=PartialSettings(nearly_all=0.0, mostly=0.0))
    asked = [Amplitude(value, 0.1, weight, run) for run, (value, weight) in enumerate((worse, second, (1.0, 0.5)))]
    monkeypatch.setattr("rwjax.diagnosis.partial.amplitudes", lambda *_: asked)
    squares = {True: {0: 1.2, 1: 0.1, 2: 0.1}, False: dict.fromkeys(range(3), 1.0)}
    monkeypatch.setattr("rwjax.diagnosis.left_out.LeftOut.__call__", lambda _, e: squares[bool(e.names)])
    assert why_not_in_every_run(search.by_runs, DRY, "axis.coulomb") == why


@pytest.mark.parametrize(("weight", "why"), [(0.09, None), (0.1, WORSE)])
def test_several_runs_that_are_followed_worse_count_together(
    weight: float, why: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(4)], DRY)
    search.fits.settings = replace(Settings(), partial=PartialSettings(nearly_all=0.0, mostly=0.0))
    asked = [Amplitude(1.0, 0.1, share, run) for run, share in enumerate((weight, weight, 0.4, 0.4))]
    monkeypatch.setattr("rwjax.diagnosis.partial.amplitudes", lambda *_: asked)
    squares = {True: {0: 1.2, 1: 1.2, 2: 0.1, 3: 0.1}, False: dict.fromkeys(range(4), 1.0)}
    monkeypatch.setattr("rwjax.diagnosis.left_out.LeftOut.__call__", lambda _, e: squares[bool(e.names)])
    assert why_not_in_every_run(search.by_runs, DRY, "axis.coulomb") == why


@pytest.mark.parametrize(
    "limits",
    [
        PartialSettings(differs=0.0, sigmas=0.0, nearly_all=0.0, mostly=0.0),
        PartialSettings(harms=0.0, nearly_all=0.0, mostly=0.0),
    ],
)
def test_stricter_limits_let_nothing_hold(limits: PartialSettings) -> None:
    search = searched([run_of(k, FRICTION) for k in range(3)], DRY, BIAS)
    assert why_not(search, DRY, "axis.coulomb") is None
    search.fits.settings = replace(Settings(), partial=limits)
    assert why_not(search, DRY, "axis.coulomb") is not None


@pytest.mark.slow
def test_a_further_law_is_counted_where_one_name_is_added_and_not_where_another_is_exchanged_as_well() -> None:
    both, other = DRY.plus("axis.bias_torque"), Hypothesis(("axis.stribeck", "axis.bias_torque"))
    search = searched([run_of(k, FRICTION | PUSHED) for k in range(3)], DRY, both, other)
    laws = further_laws(search.fits, DRY)
    assert laws[coordinate_of("axis.bias_torque")] > 0.9 and "yaw_rate" not in laws


def test_an_amount_that_differs_is_seen_though_the_residual_is_then_all_disagreement() -> None:
    logs = [run_of(k, {"axis.bias_torque": {"T": torque}}) for k, torque in enumerate((0.02, 0.02, 0.08))]
    search = searched(logs, BIAS)
    off = [a for a in amplitudes(search.fits, BIAS, NOTHING) if a.run is not None]
    assert max(abs(a.value - 1.0) / a.error for a in off) > 10.0


@pytest.mark.slow
def test_twins_on_both_sides_of_a_pair_stand_beside_it_and_ask_for_no_experiment() -> None:
    truth = {"drive.delay": {"tau": 0.2}, "axis.bias_torque": {"T": 0.002}}
    logs = [run_of(k, truth, disturbed=0.1) for k in range(4)]
    only = ("drive.delay", "sensor.delay", "axis.bias_torque", "drive.bias")
    found = diagnose(RIG, [*logs[:3], replace(logs[3], validate=True)], only=only)
    assert found.verdict == "partial"
    assert {frozenset(names) for names in ((found.effects), *found.alternatives)} == {
        frozenset((delay, push)) for delay in only[:2] for push in only[2:]
    }
    assert found.next_experiment.startswith("none can tell them apart")


@pytest.mark.parametrize(("disturbed", "verdict"), [(0.1, "partial"), (0.6, "unknown")])
def test_what_the_held_out_runs_alone_show_is_left_by_names_that_close_three_quarters(
    disturbed: float, verdict: str
) -> None:
    held_out = replace(run_of(3, FRICTION, disturbed=disturbed), validate=True)
    found = diagnose(
        RIG, [*(run_of(k, FRICTION) for k in range(3)), held_out], only=("axis.coulomb", "axis.bias_torque")
    )
    gap = found.gaps["yaw_rad"]
    assert gap.closed is not None and (gap.closed >= Settings().verdict.barely) == (verdict == "partial")
    assert found.verdict == verdict and found.effects == ("axis.coulomb",) and gap.after > 5.0 * gap.floor


@pytest.mark.parametrize(("alike", "stands"), [(0.1, True), (1e3, False)])
def test_a_law_that_moves_as_one_of_fewer_numbers_does_not_stand_beside_it(alike: float, stands: bool) -> None:
    """A spring with hardly any stiffness is a constant torque, by two numbers in place of one."""
    search = searched([run_of(k, PUSHED, disturbed=0.03) for k in range(3)], OFFSET, SPRING, DRY)
    search.fits.settings = replace(
        Settings(), partial=ANY, search=SearchSettings(nothing_left=alike)
    )  # apart by 31 noise squares
    claim, _ = claimed(search, Choice(OFFSET))
    assert claim is not None and (SPRING in claim.alternatives) == stands and DRY in claim.alternatives


@pytest.mark.slow
def test_rivals_count_against_the_names_that_they_do_without() -> None:
    """Of four rivals two do without dry friction, and two without the bias."""
    both, others = DRY.plus("axis.bias_torque"), ("axis.quadratic_drag", "axis.viscous")
    rivals = [one.plus(name) for one in (DRY, BIAS) for name in others]
    search = searched([run_of(k, FRICTION | PUSHED, disturbed=0.03) for k in range(3)], DRY, BIAS, both, *rivals)
    every = replace(ANY, alternatives=2)
    search.fits.settings = replace(
        Settings(), partial=every, search=SearchSettings(nothing_left=0.0)
    )  # a drag of none, too
    claim, refused = claimed(search, Choice(both))
    assert claim is not None and claim.named == both and not refused and {*rivals} <= {*claim.alternatives}
    search.fits.settings = replace(search.fits.settings, partial=replace(every, alternatives=1))
    assert claimed(search, Choice(both)) == (None, dict.fromkeys(both.names, "many other names leave about as much"))


def test_rivals_that_are_the_same_thing_count_once_against_a_name() -> None:
    search = searched([run_of(k, FRICTION, disturbed=0.03) for k in range(3)], DRY, BIAS, OFFSET)
    search.fits.settings = replace(Settings(), partial=replace(ANY, alternatives=1))
    claim, refused = claimed(search, Choice(DRY))
    assert claim is not None and claim.named == DRY and {*claim.alternatives} == {BIAS, OFFSET} and not refused
    search.fits.settings = replace(Settings(), partial=replace(ANY, alternatives=0))
    assert claimed(search, Choice(DRY)) == (None, {"axis.coulomb": "many other names leave about as much"})


@pytest.mark.parametrize("ahead", [BIAS, OFFSET])
def test_of_rivals_that_are_the_same_thing_the_one_counts_that_shares_a_name_whichever_leaves_less(
    ahead: Hypothesis,
) -> None:
    both, rivals = DRY.plus("axis.bias_torque"), {e: e.plus("axis.viscous") for e in (BIAS, OFFSET)}
    search = searched(
        [run_of(k, FRICTION | PUSHED, disturbed=0.03) for k in range(3)], DRY, BIAS, both, *rivals.values()
    )
    least = min(search.fits.known(e).cost for e in rivals.values())
    for e, pair in rivals.items():
        search.fits.put(pair, replace(search.fits.known(pair), cost=least * (1.0 if e == ahead else 1.001)), ended=True)
    search.fits.settings = replace(Settings(), partial=replace(ANY, alternatives=1))
    claim, refused = claimed(search, Choice(both))
    assert claim is not None and claim.named == BIAS
    assert refused == {"axis.coulomb": "many other names leave about as much"}


@pytest.mark.slow
@pytest.mark.parametrize(("closes", "shared"), [(0.5, True), (0.95, False)])
def test_of_several_names_those_are_claimed_that_every_explanation_shares(closes: float, shared: bool) -> None:
    """A drag leaves about as much as viscous friction; dry friction stands in both sets and removes 92 % by itself."""
    both, other = DRY.plus("axis.viscous"), DRY.plus("axis.quadratic_drag")
    logs = [run_of(k, FRICTION | {"axis.viscous": {"b": 0.02}}, disturbed=0.03) for k in range(3)]
    search = searched(logs, DRY, both, other)
    alike = PartialSettings(less_likely=np.inf, law_left=np.inf, further_law=np.inf, closes=closes)
    search.fits.settings = replace(Settings(), partial=alike)
    claim, refused = claimed(search, Choice(both))
    assert claim is not None and claim.named == (DRY if shared else both)
    assert claim.alternatives == (() if shared else (other,))
    why = "other names in its place, beside the rest, leave about as much"
    assert refused == ({"axis.viscous": why} if shared else {})


@pytest.mark.slow
def test_rivals_that_are_special_cases_of_each_other_both_stand() -> None:
    """A spring holds a bias as its limit, so that it is the same beside one."""
    both, beside = DRY.plus("axis.bias_torque"), BIAS.plus("axis.spring")
    assert SPRING.contains(beside) and beside.contains(SPRING)
    search = searched([run_of(k, FRICTION | PUSHED, disturbed=0.03) for k in range(3)], DRY, BIAS, SPRING, both, beside)
    search.fits.settings = replace(Settings(), partial=ANY)
    claim, _ = claimed(search, Choice(both))
    assert claim is not None and claim.named == both and {SPRING, beside} <= {*claim.alternatives}


@pytest.mark.slow
def test_a_rival_that_is_far_less_likely_does_not_stand_beside_a_name() -> None:
    """A delay leaves less than twice what the true lag leaves of a slow motion, and follows the command's leaps otherwise."""
    lag, late = Hypothesis(("drive.lag",)), Hypothesis(("drive.delay",))
    search = searched([run_of(k, {"drive.lag": {"T": 0.2}}, disturbed=0.1) for k in range(3)], lag, late)
    for less_likely, alternatives in ((PartialSettings().less_likely, ()), (np.inf, (late,))):
        limits = PartialSettings(law_left=np.inf, less_likely=less_likely)
        search.fits.settings = replace(Settings(), partial=limits)
        claim, _ = claimed(search, Choice(lag))
        assert claim is not None and claim.named == lag and claim.alternatives == alternatives


@pytest.mark.slow
def test_of_a_name_that_leaves_little_only_a_law_of_most_of_that_speaks_against_it() -> None:
    """Viscous friction in place of a drag leaves 3 % here, and the drag removes nearly all of that."""
    truth = {"axis.quadratic_drag": {"c": 0.04}}
    linear, drag = Hypothesis(("parameter.axis.friction.viscous",)), Hypothesis(("axis.quadratic_drag",))
    search = searched([run_of(k, truth) for k in range(3)], linear, drag, linear.plus(*drag.names))
    excess = search.comparison.excess
    assert excess(linear) < PartialSettings().little * excess(NOTHING)
    free_form = "a free-form law of its coordinate explains more"
    further = "a further law of its coordinate removes part of what it leaves, and changes it"
    for limits, why in (
        (PartialSettings(law_left=0.0, little=0.0, nearly_all=0.0), free_form),
        (PartialSettings(law_left=0.0), further),
        (PartialSettings(law_left=0.0, further_law_of_little=1.0), None),
    ):
        search.fits.settings = replace(Settings(), partial=limits)
        assert why_not(search, linear, linear.names[0]) == why
