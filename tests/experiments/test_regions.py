"""The slowest pole of random loops says what the closed form says; the experiment does the same for ten thousand of each kind."""

import numpy as np
import pytest

from experiments.control.random_loops import FAMILIES, thesis_axes
from experiments.control.regions import agreement, sampled_agreement

COUNT = 60


@pytest.mark.parametrize("name", [*FAMILIES][::2] + [*FAMILIES][1:2])
def test_both_ways_judge_random_loops_alike(name: str) -> None:
    found = agreement(FAMILIES[name](np.random.default_rng(11), COUNT))
    assert 0 < found.stable < found.loops == COUNT
    assert (found.left_out, found.otherwise) == (0, 0)


def test_both_ways_judge_sampled_loops_alike() -> None:
    found = sampled_agreement(thesis_axes(np.random.default_rng(12), COUNT))
    assert 0 < found.stable < found.loops == COUNT
    assert (found.left_out, found.otherwise) == (0, 0)
