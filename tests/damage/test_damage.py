"""A short run of the damaged inputs, the same at every run; `python -m tests.damage` tries many more."""

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from tests.damage.trial import Damaged, Shares, inputs, tried

FEW = 150
SHARES = Shares(programs=4, fits=0, regions=50)


@given(damaged=inputs())
@settings(
    max_examples=FEW, derandomize=True, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck)
)
def test_damaged_inputs_are_refused_in_one_line_or_mean_something(
    damaged: Damaged, tmp_path_factory: pytest.TempPathFactory
) -> None:
    assert tried(tmp_path_factory.mktemp("damaged"), damaged, SHARES).faults == []
