"""The rank of a true limit among the draws of a fit: uniform where the covariance is right, at the ends where it is too small."""

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.control.holds import OUTER, Limits, rank


@pytest.mark.parametrize(("too_small", "share"), [(1.0, 0.05), (1.5, 0.191), (0.5, 8.9e-5)])
def test_the_outer_draws_hold_the_true_limit_as_often_as_the_standard_errors_are_right(
    too_small: float, share: float
) -> None:
    """2 Phi(-1.96/f) for standard errors f times too small."""
    rng, rigs = np.random.default_rng(8), 4000
    fitted = 20.0 + too_small * rng.normal(size=rigs)  # true limit 20, standard error as the fit says it 1
    outer = [Limits(x, 0.0, 20.0, rank(x + rng.normal(size=1000), 20.0)).outer for x in fitted]
    # four deviations of a count, and what 1000 draws blur of a quantile at 2.5 %
    assert np.mean(outer) == pytest.approx(share, abs=4.0 * np.sqrt(share / rigs) + 0.003)
    assert OUTER == 0.05
