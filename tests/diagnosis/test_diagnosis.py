"""Verdicts on labelled cases, and on logs that say nothing."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

from rwjax import InputError, Log, parse_rig, read_logs, read_rig, simulate, write_rig
from rwjax.diagnosis.budget import Budget
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.diagnosis.hypothesis import Hypothesis, candidates
from rwjax.diagnosis.partial import Claim, Holding
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.diagnosis.settings import Limits, RemarkSettings, ReportSettings, Settings
from rwjax.diagnosis.uninformative import diverged_numbers
from rwjax.diagnosis.words import sure_of
from rwjax.fitting.fit import fit
from rwjax.fitting.processes import Team
from rwjax.rig.model import Rig
from tests.diagnosis.several_runs import RIG, run_of
from tests.diagnosis.simulated import TIME, true_log
from tests.fitting.test_threads import blas_threads
from tests.systems import platform, record, run, wheel


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("platform-axis.stribeck", marks=pytest.mark.slow),
        pytest.param("reaction-drive.deadzone", marks=pytest.mark.slow),
        "reaction-none",
        pytest.param("wheel-wheel.coulomb", marks=pytest.mark.slow),
    ],
)
def test_labelled_examples(examples: Path, name: str) -> None:
    folder = examples / name
    truth = json.loads((folder / "truth.json").read_text())
    rig = read_rig(folder / "rig.toml")
    found = diagnose(rig, read_logs(sorted(folder.glob("*.csv")), rig))
    assert found.verdict == ("effect" if truth["effects"] else "none")
    assert list(found.effects) == truth["effects"]
    assert found.signal == truth["signal"] or not truth["effects"]
    for signal, floor in truth["floor"].items():
        # the label's floor leaves the start's uncertainty out: up to half a count, sqrt(1 + 3) times the noise
        assert 0.8 * floor < found.gaps[signal].floor < 2.0 * floor
    assert json.loads(json.dumps(found.json(), allow_nan=False))["schema"] == "rwjax.diagnosis/2"


@pytest.mark.parametrize("noise", [0.0, 2e-4], ids=["exact", "noisy"])
@pytest.mark.filterwarnings("error")
def test_logs_in_which_nothing_moves_do_not_say_that_nothing_is_missing(noise: float) -> None:
    still = 0.3 + np.random.default_rng(0).normal(0.0, noise, len(TIME))
    found = diagnose(platform(), [record(TIME, np.zeros(len(TIME)), {"yaw_rad": still})])
    assert found.verdict == "unknown" and not found.effects
    assert "nothing moves in these logs" in found.sentence and "turns" in found.next_experiment


@pytest.mark.slow
def test_a_wrong_number_of_an_effect_that_the_rig_file_holds_is_named() -> None:
    rig = replace(platform("viscous = 0.02"), effects={"axis.coulomb": {"M_c": 0.05}})
    time, noise, logs = 0.01 * np.arange(1001), np.random.default_rng(0).normal(0.0, 2e-4, (4, 1001)), []
    for own, rate in zip(noise, (0.7, 1.1, 1.7, 2.3), strict=True):
        command = record(time, 0.3 * np.sign(np.sin(rate * time)) + 0.2 * np.sin(3.1 * time))
        logs.append(replace(command, outputs={"yaw_rad": run(rig, command, {}, effects=rig.effects)["yaw_rad"] + own}))
    found = diagnose(rig.with_values({"axis.coulomb.M_c": 0.04}), logs)
    assert found.verdict == "effect" and found.effects == ("parameter.axis.coulomb.M_c",)
    assert found.corrected.values["axis.coulomb.M_c"] == pytest.approx(0.05, rel=1e-3)


@pytest.mark.slow
def test_a_second_cause_is_found_though_the_first_takes_up_nearly_all_of_its_error() -> None:
    """Dry friction takes up 97 % of the error that a dead zone makes beside it, in runs that are fitted; counts are the only noise."""
    rig = parse_rig(
        'kind = "platform"\n[drive]\ngain = 1.0\n[axis]\ninertia = 0.02\n[axis.friction]\nviscous = 0.1\n'
        '[encoder]\ncounts_per_rev = 2048\n[fit]\nfree = ["axis.inertia", "axis.friction.viscous"]\n'
    )
    both = replace(rig, effects={"axis.coulomb": {"M_c": 0.75}, "drive.deadzone": {"u_0": 0.8, "j": 0.0}})
    time, step = 0.01 * np.arange(2000), 2.0 * np.pi / 2048
    levels = np.random.default_rng(0).integers(-255, 256, 50) * 12.0 / 255
    shapes = (
        8.47 * np.sign(np.sin(0.6 * np.pi * time)),
        24.0 / np.pi * np.arcsin(np.sin(0.4 * np.pi * time)),
        levels[(time / 0.8).astype(int)],
    )
    logs = []
    for u in shapes:
        u = np.where(time < 0.5, 0.0, u)
        turned = np.asarray(simulate(both, time, u)["yaw_rad"])
        logs.append(record(time, u, {"yaw_rad": step * np.round(turned / step)}, resolution={"yaw_rad": step}))
    found = diagnose(rig, logs)
    assert found.verdict == "effect" and {*found.effects} == {"axis.coulomb", "drive.deadzone"}


@pytest.mark.slow
def test_the_search_goes_on_where_held_out_runs_show_a_small_share_of_what_is_far_above_the_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun: list[tuple[str, ...]] = []

    class Watched(FurtherSearch):
        def go_on(self, begin: Hypothesis) -> Choice:
            begun.append(begin.names)
            return super().go_on(begin)

    monkeypatch.setattr("rwjax.diagnosis.further.FurtherSearch", Watched)
    monkeypatch.setattr("rwjax.diagnosis.model_comparison.ModelComparison.leaves_visible", lambda self, e: False)
    logs = [run_of(k, {"axis.coulomb": {"M_c": 0.06}}, disturbed=0.3) for k in range(3)]
    diagnose(RIG, logs, only=["axis.coulomb"])
    assert begun == [("axis.coulomb",)]


@pytest.mark.slow
def test_a_wheel_that_stands_still_is_remarked_on_and_a_turning_one_is_not() -> None:
    rig, rng = wheel(), np.random.default_rng(1)
    command = np.where(TIME > 1.0, 0.5, 0.0)
    through = command / 0.83 * (1.0 - np.exp(-0.83 / 0.0641 * np.maximum(TIME - 1.0, 0.0)))  # of the winding at rest
    held = {"wheel_rad_s": rng.normal(0.0, 0.01, len(TIME)), "current_A": through + rng.normal(0.0, 1e-3, len(TIME))}
    found = diagnose(rig, [record(TIME, command, held)])
    assert found.verdict == "unknown" and not found.effects
    assert "turns" in found.next_experiment and any("hardly moves" in remark for remark in found.remarks)
    turning = run(rig, record(TIME, command, held), {})
    assert diverged_numbers(rig, fit(rig, [record(TIME, command, turning)]).fit, RemarkSettings()) == ()


@pytest.mark.slow
def test_other_settings_give_another_verdict_and_are_recorded() -> None:
    rig = platform("viscous = 0.02")
    log = true_log(rig, **{"axis.bias_torque": {"T": 0.03}})
    blind = Settings(verdict=Limits(nothing=1e9))
    steps: list[str] = []
    found = diagnose(rig, [log], settings=blind, progress=steps.append)
    assert found.verdict == "none" and found.settings is blind and not found.effects
    assert steps == ["the rig as it is"]


@pytest.fixture(scope="module")
def pushed() -> tuple[Rig, Log]:
    """A platform that lacks a constant torque, and its log."""
    rig = platform("viscous = 0.02")
    return rig, true_log(rig, **{"axis.bias_torque": {"T": 0.03}})


FEW = ("axis.coulomb", "axis.bias_torque", "drive.bias", "sensor.scale")


class Counted:
    """A clock that goes by one second at each look: the budget then ends at the same place of the search on any machine."""

    def __init__(self) -> None:
        self.looks = 0.0

    def __call__(self) -> float:
        self.looks += 1.0
        return self.looks


@pytest.mark.slow
def test_wherever_a_search_is_ended_the_answer_is_whole_and_claims_nothing(pushed: tuple[Rig, Log]) -> None:
    rig, log = pushed
    clock = Counted()
    whole = diagnose(rig, [log], only=FEW, budget=Budget(math.inf, clock))
    assert whole.complete and whole.untried == () and whole.verdict == "ambiguous"
    for share in (0.0, 0.3, 0.6, 0.85, 0.98):
        looks = max(share * clock.looks, 1.0)
        found = diagnose(rig, [log], only=FEW, budget=Budget(looks, Counted()))
        answer = json.loads(json.dumps(found.json(), allow_nan=False))
        assert answer["complete"] is found.complete is False and answer["verdict"] == "unknown", share
        assert {*answer["untried"]} < {*FEW} if share > 0.5 else {*answer["untried"]} <= {*FEW}
        assert (
            found.sentence.startswith("Unfinished")
            and "a longer `--budget` lets it come there" in found.next_experiment
        )
        (ended,) = (remark for remark in found.remarks if "ended the search, and nothing is claimed" in remark)
        assert share < 0.5 or re.search(r"; best until then was .* \(.* rad left of the fitted runs\)$", ended), share
        assert np.isfinite([gap for one in found.gaps.values() for gap in (one.before, one.after, one.floor)]).all()
        assert parse_rig(write_rig(found.corrected)).effects == found.corrected.effects
    assert answer["untried"] == [] and {*found.effects} & {"axis.bias_torque", "drive.bias"}  # the same thing here


def test_with_no_time_at_all_the_gap_is_told_and_every_candidate_is_untried(pushed: tuple[Rig, Log]) -> None:
    rig, log = pushed
    budget = Budget()
    assert not budget.stop()
    found = diagnose(rig, [log], budget=budget)
    assert not found.complete and found.verdict == "unknown" and found.effects == () and found.waterfall[0].names == ()
    assert found.untried == tuple(name for name in candidates(rig) if name not in ("sensor.offset",))
    assert found.gaps["yaw_rad"].before > 10.0 * found.gaps["yaw_rad"].floor
    (ended,) = (remark for remark in found.remarks if remark.startswith("an interruption ended the search"))
    assert f", {found.untried[3]} and {len(found.untried) - 4} more" in ended and found.untried[4] not in ended
    assert (
        found.next_experiment == "none before the search has come to its end"
    )  # a longer budget would not have helped


def test_matrix_products_take_one_thread_so_that_no_digit_depends_on_the_processors(pushed: tuple[Rig, Log]) -> None:
    rig, log = pushed
    seen = set[int]()
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        diagnose(rig, [log], budget=1e-3, progress=lambda text: seen.update(blas_threads()))
    assert seen == {1}


def test_where_nothing_is_missing_no_budget_is_too_short() -> None:
    rig = platform("viscous = 0.02")
    found = diagnose(rig, [true_log(rig)], budget=1e-9)
    assert found.complete and found.verdict == "none" and found.untried == ()


def test_names_that_are_none_are_refused_before_the_work(pushed: tuple[Rig, Log]) -> None:
    rig, log = pushed
    with pytest.raises(InputError, match="`axis.colomb` is no effect .* nearest `axis.coulomb`"):
        diagnose(rig, [log], without=["axis.colomb"])
    with pytest.raises(InputError, match="budget 0.0: has to be a positive number of seconds"):
        diagnose(rig, [log], budget=0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("drive.one_sided", {"s": -1.0}),
        ("drive.square_law", {"s": 1.0, "u_1": 0.8}),
        ("sensor.offset", {"w_b": 0.05}),
    ],
)
def test_what_was_withheld_from_the_rig_is_named(name: str, given: dict[str, float]) -> None:
    rig = platform("viscous = 0.05", '"axis.friction.viscous"')
    logs = []
    for k, pace in enumerate((1.7, 2.3, 1.1)):
        command = np.where(TIME > 0.6, 0.5 * np.sign(np.sin(pace * TIME)) + 0.4 * np.sin(2.9 * pace * TIME), 0.0)
        outputs = dict.fromkeys(("yaw_rad", "yaw_rad_s"), np.zeros_like(TIME))
        y = run(rig, record(TIME, command, outputs), {}, effects={name: given})
        rng = np.random.default_rng(k)
        read = {on: y[on] + rng.normal(0.0, noise, len(TIME)) for on, noise in (("yaw_rad", 1e-3), ("yaw_rad_s", 5e-3))}
        logs.append(record(TIME, command, read, validate=k == 2))
    found = diagnose(rig, logs)
    assert (found.verdict, found.effects) == ("effect", (name,))
    for number, value in given.items():
        assert found.corrected.effects[name][number] == pytest.approx(value, rel=0.02)


@pytest.mark.slow
def test_a_rig_without_free_numbers_is_diagnosed() -> None:
    rig = replace(RIG, free=(), prior={})
    logs = [run_of(k, {"axis.bias_torque": {"T": 0.02}}) for k in range(3)]
    found = diagnose(rig, logs, only=("axis.bias_torque", "axis.coulomb", "axis.spring"))
    assert found.verdict == "effect" and found.effects == ("axis.bias_torque",)
    assert any("`fit.free`" in remark for remark in found.remarks)
    assert not any("`fit.free`" in remark for remark in diagnose(RIG, logs, only=("axis.spring",)).remarks)


@pytest.mark.slow
def test_helpers_change_no_byte_of_the_answer() -> None:
    logs = [run_of(k, {"axis.bias_torque": {"T": 0.02}}, disturbed=0.02) for k in range(3)]
    only = ("axis.bias_torque", "axis.coulomb", "axis.spring", "axis.stribeck")
    answers = []
    for helpers in (0, 1):
        with Team(helpers) as team:
            answers.append(json.dumps(diagnose(RIG, logs, only=only, team=team).json()))
    assert answers[0] == answers[1]


@pytest.mark.slow
def test_what_leaves_another_output_far_off_is_claimed_in_part_and_the_output_is_named() -> None:
    """The rate shakes as no angle does: dry friction explains the angle alone."""
    logs = []
    for k in range(3):
        log = run_of(k, {"axis.coulomb": {"M_c": 0.06}})
        shaken = np.gradient(log.outputs["yaw_rad"], log.time) + 0.1 * np.sin(41.0 * log.time)
        rng = np.random.default_rng(k)
        rate = np.where(log.time > 1.0, shaken, 0.0) + rng.normal(0.0, 0.01, len(log.time))
        logs.append(replace(log, outputs=log.outputs | {"yaw_rad_s": rate}))
    found = diagnose(RIG, logs, only=["axis.coulomb"])
    assert found.signal == "yaw_rad" and found.gaps["yaw_rad"].closed > 0.95
    assert (found.verdict, found.effects) == ("partial", ("axis.coulomb",))
    gap = found.gaps["yaw_rad_s"]
    assert f"and for the {gap.after:.3g} rad/s of yaw_rad_s that stay (" in found.sentence
    excess = (gap.after**2 - gap.floor**2) / (gap.before**2 - gap.floor**2)
    assert found.left.share == pytest.approx(excess)


def test_a_claim_that_leaves_more_of_another_output_than_the_rig_as_it_is_does_is_given_up() -> None:
    """The angle is that of a rig with dry friction, the rate that of one without."""
    logs = []
    for k in range(3):
        angle, free = (run_of(k, truth) for truth in ({"axis.coulomb": {"M_c": 0.06}}, {}))
        rate = np.gradient(free.outputs["yaw_rad"], free.time) + np.random.default_rng(k).normal(
            0.0, 0.02, len(free.time)
        )
        logs.append(replace(angle, outputs=angle.outputs | {"yaw_rad_s": rate}))
    first_alone = Settings(report=ReportSettings(ranked=1))  # the rig as it is counts however far behind it stands
    found = diagnose(replace(RIG, free=(), prior={}), logs, only=["axis.coulomb"], settings=first_alone)
    assert found.signal == "yaw_rad" and found.verdict == "unknown"
    assert found.refused == {"axis.coulomb": "another explanation leaves clearly less of the held-out runs"}


@pytest.mark.slow
def test_a_claim_that_has_less_evidence_than_another_explanation_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    stands_in = Hypothesis(("axis.spring",))
    monkeypatch.setattr("rwjax.diagnosis.further.claimed", lambda search, choice: Holding(Claim(stands_in, (), ()), {}))
    logs = [run_of(k, {"axis.bias_torque": {"T": 0.06}}, disturbed=0.3) for k in range(3)]
    found = diagnose(RIG, logs, only=["axis.bias_torque", "axis.spring"])
    assert (found.verdict, found.effects, found.ranking[0].effect) == ("partial", stands_in.names, "axis.bias_torque")
    told = "by the evidence of the fitted runs alone axis.bias_torque would lead"
    assert any(remark.startswith(told) for remark in found.remarks)
    first, after = found.ranking[0], found.gaps[found.signal].after
    assert first.why_not is not None and first.gap_after is not None
    assert ("the fitted runs alone speak more for it" in first.why_not) == (first.gap_after <= after)


@pytest.mark.slow
def test_a_claim_that_another_explanation_beats_on_the_held_out_runs_is_given_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stands_in = Hypothesis(("axis.bias_torque",))
    monkeypatch.setattr("rwjax.diagnosis.further.claimed", lambda search, choice: Holding(Claim(stands_in, (), ()), {}))
    logs = [run_of(k, {"axis.coulomb": {"M_c": 0.06}}, disturbed=0.3) for k in range(3)]
    found = diagnose(RIG, logs, only=["axis.coulomb", "axis.bias_torque"])
    assert found.verdict == "unknown" and found.effects == ("axis.coulomb",)
    assert found.refused == {"axis.bias_torque": "another explanation leaves clearly less of the held-out runs"}


def test_it_is_said_how_to_keep_a_number_that_the_answer_says_is_wrong() -> None:
    rig = replace(RIG.with_values({"drive.gain": 0.8 * RIG.values["drive.gain"]}), free=())
    logs = [run_of(k, {}) for k in range(2)]
    found = diagnose(rig, logs, only=["parameter.drive.gain"])
    assert found.effects == ("parameter.drive.gain",)
    told = [remark for remark in found.remarks if "--without" in remark]
    assert told == [sure_of("parameter.drive.gain")]
    assert not any("--without" in remark for remark in diagnose(RIG, logs, only=["parameter.drive.gain"]).remarks)
