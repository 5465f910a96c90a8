"""Verdicts on labelled cases, and the parts from which they are made."""

import json
from pathlib import Path

import numpy as np
import pytest

from rwjax import read_logs, read_rig
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.diagnosis.gap import closure
from rwjax.diagnosis.hypothesis import Hypothesis, candidates, free_names
from rwjax.diagnosis.information_criterion import correlation_time
from tests.systems import platform, reaction, wheel


@pytest.mark.parametrize(
    "name", ["platform-axis.stribeck", "reaction-drive.deadzone", "reaction-none", "wheel-wheel.coulomb"]
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
    assert json.loads(json.dumps(found.json(), allow_nan=False))["schema"] == "rwjax.diagnosis/1"


def test_candidates_fit_the_kind_and_leave_out_what_is_modelled() -> None:
    assert not any(name.startswith("axis.") for name in candidates(wheel()))
    assert not any(name.startswith("wheel.") for name in candidates(platform()))
    assert "axis.coulomb" not in candidates(platform())
    assert "axis.coulomb" in candidates(platform("viscous = 0.02"))
    assert "parameter.axis.inertia" not in candidates(platform())  # it is free
    assert "parameter.drive.gain" in candidates(platform())


def test_a_coulomb_level_belongs_to_an_effect_only_where_nothing_else_models_it() -> None:
    stribeck = Hypothesis(("axis.stribeck",))
    assert "axis.stribeck.M_c" in free_names(reaction(), stribeck)
    assert "axis.stribeck.M_c" not in free_names(platform(), stribeck)
    both = free_names(reaction(), Hypothesis(("axis.stribeck", "axis.asymmetric_friction")))
    assert sum(name.endswith(".M_c") for name in both) == 1


def test_containment() -> None:
    coulomb, stribeck = Hypothesis(("axis.coulomb",)), Hypothesis(("axis.stribeck",))
    assert stribeck.contains(coulomb) and not coulomb.contains(stribeck) and not coulomb.contains(coulomb)


def test_correlation_time_of_a_first_order_process() -> None:
    rho, n = 0.8, 200_000
    noise = np.random.default_rng(0).normal(size=n)
    x = np.empty(n)
    x[0] = noise[0]
    for k in range(1, n):
        x[k] = rho * x[k - 1] + noise[k]
    assert correlation_time(x) == pytest.approx((1 + rho) / (1 - rho), rel=0.1)
    assert correlation_time(noise) == pytest.approx(1.0, abs=0.1)


def test_closure_is_the_share_of_the_gap_above_the_floor() -> None:
    assert closure(1.0, 0.2, 0.2) == 1.0
    assert closure(1.0, 1.0, 0.2) == 0.0
    assert closure(0.2, 0.2, 0.2) is None
