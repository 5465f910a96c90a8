"""Spectra against those of scipy, and against the power of a record."""

import numpy as np
import pytest
import scipy.signal

from rwjax.diagnosis.localise.spectrum import welch

RNG = np.random.default_rng(11)


@pytest.mark.parametrize(("samples", "length"), [(400, 64), (401, 65), (400, 400), (399, 399), (130, 128)])
def test_densities_are_those_of_scipy(samples: int, length: int) -> None:
    y = RNG.normal(size=(samples, 3)) + 2.0
    f, density = welch(y, 0.01, length)
    theirs, wanted = scipy.signal.welch(y, 100.0, nperseg=length, axis=0, detrend=False)
    np.testing.assert_allclose(f, theirs, rtol=1e-14)
    np.testing.assert_allclose(density, wanted, rtol=1e-10)


def test_the_density_of_white_noise_is_its_variance_over_the_band() -> None:
    f, density = welch(RNG.normal(scale=3.0, size=(200_000, 1)), 0.01, 256)
    assert np.mean(density[5:-5]) == pytest.approx(9.0 / 50.0, rel=0.02)
    assert f[-1] == 50.0
