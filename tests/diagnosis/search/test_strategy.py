"""Strategy: a search that is handed in from outside."""

from collections.abc import Sequence

import pytest

from rwjax.diagnosis.diagnosis import diagnose
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.strategy import Strategy
from rwjax.diagnosis.search.successive_halving import fitted
from tests.diagnosis.simulated import true_log
from tests.systems import platform


class Exhaustive(Strategy):
    """Every single name, fitted one after the other."""

    def choose(self, fits: ModelFits, candidates: Sequence[str]) -> Choice:
        every = [
            Hypothesis(),
            *(Hypothesis((name,)) for name in candidates if name in ("axis.bias_torque", "axis.coulomb")),
        ]
        for hypothesis in every:
            fitted(fits, hypothesis)
        comparison = ModelComparison(fits)
        best = comparison.leader(every)
        return Choice(best, ranking=comparison.probabilities(every, comparison.effective(best)))


@pytest.mark.slow
def test_a_strategy_from_outside_names_the_cause() -> None:
    rig = platform("viscous = 0.02")
    found = diagnose(rig, [true_log(rig, **{"axis.bias_torque": {"T": 0.03}})], strategy=Exhaustive())
    assert found.verdict == "effect" and found.effects == ("axis.bias_torque",)
    assert found.ranking[0].effect == "axis.bias_torque" and len(found.ranking) == 3
    assert found.where is not None and found.where.coordinate and found.where.share > 0.9
    assert [r.names for r in found.waterfall] == [(), ("axis.bias_torque",)]
    assert found.waterfall[1].own["axis.bias_torque.T"][0] == pytest.approx(0.03, rel=0.05)
    assert "The rig lacks" in str(found).splitlines()[0] and str(found).splitlines()[0] == found.sentence


def test_a_strategy_says_what_it_chooses() -> None:
    with pytest.raises(TypeError, match="abstract"):
        Strategy()  # pyright: ignore[reportAbstractUsage]
