"""Regimes and frequency bands, against what was planted and against nothing."""

import numpy as np
from scipy.stats import binom, kstest

from rwjax.diagnosis.localise.regimes import REGIMES, bands, regimes, shares, weights
from rwjax.diagnosis.localise.spectrum import octave_power
from rwjax.diagnosis.settings import RegimeSettings
from tests.diagnosis.localise.measured import COASTS, COMMAND, TIME, located, measured
from tests.systems import platform

SETTINGS = RegimeSettings()


def test_regimes_of_a_made_up_motion() -> None:
    t = np.arange(800) * 0.01
    speed = np.select([t < 1.0, t < 3.0, t < 5.0, t < 6.0], [0.0, 1.0, -1.0, 0.0], default=0.5)
    command = np.select([t < 1.0, t < 2.0, t < 4.0], [0.0, 2.0, 1.0], default=0.0)
    named = np.array(REGIMES)[regimes(t, speed, speed == 0.0, command, 2.0, 1e-3, SETTINGS)]
    for at, name in (
        (0.5, "stuck"), (1.1, "breaking away"), (1.5, "saturated"), (2.5, "sliding"), (2.95, "reversing"),
        (3.05, "reversing"), (3.5, "sliding"), (4.5, "coasting"), (5.5, "stuck"), (6.1, "breaking away"), (7.0, "coasting"),
    ):  # fmt: skip
        assert named[round(at / 0.01)] == name, at


def test_without_any_command_all_that_moves_coasts() -> None:
    t = np.arange(300) * 0.01
    assert {*regimes(t, np.ones(300), np.zeros(300, bool), np.zeros(300), 0.0, 0.0, SETTINGS)} == {
        REGIMES.index("coasting")
    }


def test_the_planted_regime_is_found() -> None:
    rig = platform("viscous = 0.05")
    # what the log does not tell of: a push while it says that nothing drives
    log = measured(rig, COASTS + 0.3 * ((COASTS == 0.0) & (TIME > 0.6)), COASTS, ("yaw_rad",), 0)
    first = located(rig, log).regimes[0]
    assert first.name == "coasting" and first.share > 0.8 and first.p < 0.02 and first.of_time < 0.5


def test_the_planted_band_is_found() -> None:
    rig = platform("viscous = 0.05")
    log = measured(rig, COMMAND + 0.2 * np.sin(2.0 * np.pi * 4.0 * TIME) * (TIME > 0.6), COMMAND, ("yaw_rad",), 0)
    first = max(located(rig, log).bands, key=lambda band: band.share)
    assert first.low is not None and first.high is not None
    assert first.low <= 4.0 <= first.high and first.share > 0.8 and first.p < 1e-6


def test_a_right_rig_stands_out_in_no_band() -> None:
    rig = platform("viscous = 0.05")
    found = [located(rig, measured(rig, COMMAND, COMMAND, ("yaw_rad",), seed)).bands for seed in range(12)]
    p = [band.p for one in found for band in one]
    low, high = binom.interval(0.999, len(p), 0.1)
    assert low <= np.sum(np.array(p) < 0.1) <= high


def test_p_of_regimes_and_of_bands_are_even_where_nothing_is_planted() -> None:
    rng = np.random.default_rng(5)
    label = np.select([np.mod(np.arange(1200), 300) < 60, np.mod(np.arange(1200), 170) < 40], [0, 2], default=5)
    p = []
    for _ in range(300):
        noise = rng.normal(size=1230)
        slow = np.convolve(noise, np.ones(31) / np.sqrt(31.0), mode="valid")  # correlated over 31 samples
        own = rng.normal(size=(1200, 4)) ** 2
        parts = shares([slow**2], [own], [label], [np.repeat(label[:, None], 4, 1)], SETTINGS.shifts)
        p += [part.p for part in parts if part.name == "reversing"]
    assert kstest(p, "uniform").pvalue > 1e-3
    white = rng.normal(size=(200, 1200, 25))
    low = [bands(octave_power([one[:, 0]], [one[:, 1:]], [0.01], SETTINGS.window))[-2].p for one in white]
    assert kstest(low, "uniform").pvalue > 1e-3


def test_weights_are_inverse_variances_with_a_bound() -> None:
    found = weights(np.array([1e-9, 1.0, 1.0, 2.0]))
    assert np.allclose(found, [100.0, 1.0, 1.0, 0.25])
