"""Names that pass for a law outside the list of effects are not claimed where it does as well."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.diagnosis import diagnose
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.outside_laws import why_not_claimed, with_outside_laws
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving, fitted
from rwjax.diagnosis.settings import SearchSettings, Settings
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


@pytest.mark.parametrize("truth", LAWS)
def test_a_law_outside_the_list_stands_for_a_name_where_it_is_the_truth_and_not_where_the_name_is(truth: str) -> None:
    found = with_outside_laws(fits_of(truth), STRIBECK)
    assert found == ({} if truth == "axis.stribeck" else {"axis.stribeck": GROWS})


def test_a_name_for_which_no_law_passes_costs_no_fit() -> None:
    logs = [triangles("axis.stribeck", 0)]
    fits = ModelFits.of(RIG, logs, range(1))
    assert with_outside_laws(fits, Hypothesis(("axis.bias_torque",))) == {} and len(list(fits)) == 0


def test_the_reason_names_the_law() -> None:
    both = STRIBECK.plus("axis.bias_torque")
    why = why_not_claimed(both, Hypothesis(("axis.growing_stiction", "axis.bias_torque")))
    assert (
        why
        == "breakaway friction that grows with the time at rest does as well in its place, and is no effect of the list"
    )


@pytest.mark.parametrize("as_well", [False, True])
def test_a_diagnosis_does_not_claim_it_and_proposes_what_tells_them_apart(as_well: bool) -> None:
    settings = Settings(search=SearchSettings(close_outside=1e9 if as_well else 10.0))
    logs = [triangles("axis.stribeck", seed) for seed in range(3)]
    found = diagnose(RIG, logs, settings=settings, only=("axis.stribeck", "axis.bias_torque"))
    assert found.effects == STRIBECK.names
    if not as_well:
        assert found.verdict == "effect" and not found.refused and found.proposal is None
        return
    assert found.verdict == "unknown" and {*found.refused} == {*STRIBECK.names}
    assert found.sentence.endswith("but this is no claim: " + why_not_claimed(STRIBECK, GROWS) + ".")
    assert found.proposal is not None and "axis.growing_stiction" in found.next_experiment
