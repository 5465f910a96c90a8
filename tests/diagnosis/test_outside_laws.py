"""Names that pass for a law outside the list of effects are not claimed where it does as well."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.outside_laws import OutsideLaw, doing_as_well, outside_laws_of
from rwjax.diagnosis.result import Diagnosis
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving, fitted
from rwjax.diagnosis.settings import SearchSettings, Settings
from rwjax.effects.library import is_outside
from rwjax.logs.log import Log
from tests.systems import platform, record, run

RIG = platform()
STRIBECK = Hypothesis(("axis.stribeck",))
GROWS = Hypothesis(("axis.growing_stiction",))
LAWS = {
    "axis.stribeck": {"M_e": 0.03, "v_s": 0.1},
    "axis.growing_stiction": {"M_e": 0.06, "tau": 0.5},
}


def triangles(truth: str, seed: int) -> Log:
    """A run of slow triangles, through rest and breakaway, after rests of several lengths."""
    t, rng = np.arange(1601) * 0.01, np.random.default_rng(seed)
    size = np.repeat(rng.uniform(0.3, 0.8, 8), 201)[: len(t)]
    command = np.where(
        t > 0.6, size * np.interp((t / rng.uniform(3.0, 5.0)) % 1.0, [0.0, 0.25, 0.75, 1.0], [0, 1, -1, 0]), 0.0
    )
    y = run(RIG, record(t, command), {}, effects={truth: LAWS[truth]})["yaw_rad"]
    return replace(record(t, command, {"yaw_rad": y + rng.normal(0.0, 2e-4, len(t))}), name=f"{seed}.csv")


def fits_of(truth: str) -> ModelFits:
    logs = [triangles(truth, seed) for seed in range(2)]
    fits = ModelFits.of(RIG, logs, range(len(logs)))
    fits(NOTHING)
    fits.start_from_first_readings()
    SuccessiveHalving(fits).fit([STRIBECK], NOTHING)
    fitted(fits, STRIBECK)
    return fits


PASSES = {  # names, and the laws that pass for them
    "sensor.missed_counts": "axis.growing_inertia",
    "axis.friction_drift": "axis.worked_friction",
    "axis.spring": "axis.angle_gain",
}
OTHERS = {
    "sensor.missed_counts": {"s": 0.2, "w_m": 2.0, "j": 0.0},
    "axis.growing_inertia": {"p": 0.3, "w_0": 4.0},
    "axis.friction_drift": {"d": 1.0, "B": 0.0, "tau": 3.0, "s": 0.0},
    "axis.worked_friction": {"d": 0.4, "tau": 1.0},
    "axis.spring": {"k": 0.02, "T_0": 0.0, "k_3": 0.0},
    "axis.angle_gain": {"s_1": 0.3, "c_1": -0.2, "s_2": 0.0, "c_2": 0.05},
}
SOON = ("axis.growing_inertia", "axis.angle_gain")


@pytest.mark.parametrize("truth", [pytest.param(e, marks=[] if e in SOON else [pytest.mark.slow]) for e in OTHERS])
def test_so_do_laws_of_the_motion_and_of_the_angle(truth: str) -> None:
    name, law = next(pair for pair in PASSES.items() if truth in pair)
    t, logs = np.arange(801) * 0.01, []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        command = np.repeat(rng.uniform(-0.8, 0.8, 9), 89)[: len(t)]
        y = run(RIG, record(t, command), {}, effects={truth: OTHERS[truth]})["yaw_rad"]
        logs.append(replace(record(t, command, {"yaw_rad": y + rng.normal(0.0, 2e-4, len(t))}), name=f"{seed}.csv"))
    fits = ModelFits.of(RIG, logs, range(len(logs)))
    fits(NOTHING)
    fits.start_from_first_readings()
    claimed = Hypothesis((name,))
    SuccessiveHalving(fits).fit([claimed], NOTHING)
    fitted(fits, claimed)
    asked = outside_laws_of([claimed])
    assert [one.instead.names for one in asked] == [(law,)]
    assert doing_as_well(fits, asked) == ([] if truth == name else asked)


ASKED = OutsideLaw("axis.stribeck", "axis.growing_stiction", STRIBECK, GROWS)
WHY = "breakaway friction that grows with the time at rest does as well in its place, and is no effect of the list"


@pytest.mark.parametrize("truth", LAWS)
def test_a_law_outside_the_list_stands_for_a_name_where_it_is_the_truth_and_not_where_the_name_is(truth: str) -> None:
    found = doing_as_well(fits_of(truth), [ASKED])
    assert found == ([] if truth == "axis.stribeck" else [ASKED])


def test_it_is_asked_of_every_set_beside_the_other_names() -> None:
    bias, both = Hypothesis(("axis.bias_torque",)), STRIBECK.plus("axis.bias_torque")
    assert outside_laws_of([STRIBECK, bias]) == [ASKED] and outside_laws_of([bias]) == []
    assert outside_laws_of([both])[0].instead == GROWS.plus("axis.bias_torque")
    assert outside_laws_of([Hypothesis(("pitch.stribeck",))])[0].law == "pitch.growing_stiction"
    assert ASKED.why == WHY


def diagnosed(close: float) -> Diagnosis:
    logs = [triangles("axis.stribeck", seed) for seed in range(3)]
    settings = Settings(search=SearchSettings(close_outside=close))
    return diagnose(RIG, logs, settings=settings, only=("axis.stribeck", "axis.bias_torque"))


@pytest.mark.slow
def test_a_name_is_claimed_from_which_the_law_falls_short() -> None:
    found = diagnosed(SearchSettings().close_outside)
    assert found.verdict == "effect" and found.effects == STRIBECK.names
    assert not found.refused and found.proposal is None


def test_a_name_is_not_claimed_where_the_law_does_as_well_and_what_tells_them_apart_is_proposed() -> None:
    found = diagnosed(1e9)
    assert found.verdict == "unknown" and found.complete and found.effects == STRIBECK.names
    assert found.refused == {"axis.stribeck": WHY} and found.sentence.endswith(f"but this is no claim: {WHY}.")
    assert found.proposal is not None and WHY.partition(" does")[0] in found.next_experiment
    assert not any(is_outside(name) for run in found.proposal.runs for name in run.tells_apart)


def test_a_budget_that_ends_before_the_law_was_asked_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def ended(fits: ModelFits, asked: list[OutsideLaw]) -> list[OutsideLaw]:
        raise Stopped

    monkeypatch.setattr("rwjax.diagnosis.further.doing_as_well", ended)
    found = diagnosed(1e9)
    assert found.verdict == "unknown" and not found.complete and not found.untried
    assert any("before it was told whether Stribeck friction may be claimed" in note for note in found.notes)
