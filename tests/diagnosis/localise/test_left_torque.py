"""Left torque: what is left, as coloured noise."""

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.localise.left_torque import LeftTorque, coloured, left_torque
from rwjax.diagnosis.localise.spectrum import octave_power
from rwjax.diagnosis.localise.where import missing_torques
from rwjax.diagnosis.settings import LocalisationSettings, RegimeSettings
from rwjax.fitting.multiple_shooting import Fit
from tests.diagnosis.several_runs import run_of, searched

WINDOW = RegimeSettings().window
CHANCE = LocalisationSettings().by_chance


def left_by(fitted: Fit, logs: tuple[int, ...]) -> LeftTorque | None:
    """What a fit leaves of some logs."""
    limits = LocalisationSettings()
    return left_torque(fitted, missing_torques(fitted, logs, limits), limits)


def gauss_markov(sigma: float, tau: float, interval: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """A first-order Gauss-Markov process, exact at its samples."""
    keep, y = np.exp(-interval / tau), np.empty(count)
    y[0] = rng.normal(0.0, sigma)
    kicks = rng.normal(0.0, sigma * np.sqrt(1.0 - keep**2), count)
    for k in range(1, count):
        y[k] = keep * y[k - 1] + kicks[k]
    return y


@pytest.mark.parametrize("tau", [0.03, 0.1, 0.4])
def test_a_coloured_torque_in_white_noise_has_its_size_and_its_correlation_time(tau: float) -> None:
    rng = np.random.default_rng(0)
    true = [gauss_markov(0.02, tau, 0.005, 12_000, rng) for _ in range(12)]
    noise = rng.normal(0.0, 0.01, (12, 12_000, 5))
    records, own = [y + n[:, 0] for y, n in zip(true, noise, strict=True)], [n[:, 1:] for n in noise]
    found = coloured(octave_power(records, own, [0.005] * 12, WINDOW), CHANCE)
    assert found.rms == pytest.approx(0.02, rel=0.05)
    assert found.correlation_time == pytest.approx(tau, rel=0.2)
    octave = int(np.searchsorted(found.edges, 1.0 / (2.0 * np.pi * tau))) - 1
    f = np.linspace(*found.edges[octave : octave + 2], 200)
    density = np.mean(4.0 * 0.02**2 * tau / (1.0 + (2.0 * np.pi * f * tau) ** 2))
    assert found.density[octave] == pytest.approx(density, rel=0.2)


def test_noise_alone_leaves_nothing_of_a_complete_rig() -> None:
    noise = np.random.default_rng(1).normal(size=(40, 4000, 25))
    found = [coloured(octave_power([one[:, 0]], [one[:, 1:]], [0.01], WINDOW), CHANCE) for one in noise]
    nothing = [one for one in found if one.rms == 0.0 and one.correlation_time is None and not one.density.any()]
    assert len(nothing) >= 37  # a dozen octaves, each by chance once in a thousand times


def test_a_short_run_beside_long_ones_moves_neither_size_nor_correlation_time() -> None:
    rng = np.random.default_rng(2)
    lengths = [12_000] * 12 + [300]
    records = [gauss_markov(0.02, 1.0, 0.005, n, rng) for n in lengths]
    own = [rng.normal(0.0, 1e-4, (n, 5)) for n in lengths]
    found = [coloured(octave_power(records[:k], own[:k], [0.005] * k, WINDOW), CHANCE) for k in (12, 13)]
    assert found[0].correlation_time == pytest.approx(1.0, rel=0.2)
    assert found[1].correlation_time == pytest.approx(found[0].correlation_time, rel=0.05)
    assert found[1].rms == pytest.approx(found[0].rms, rel=0.05)


def test_power_is_the_square_of_white_noise_whatever_the_lengths_and_intervals() -> None:
    rng = np.random.default_rng(3)
    for lengths, intervals in (
        ([256] * 40, [0.01] * 40),
        ([20_000, 2_000], [0.001, 0.01]),
        ([255, 257] * 20, [0.01] * 40),
    ):
        records = [rng.normal(size=n) for n in lengths]
        power = octave_power(records, [np.zeros((n, 1)) for n in lengths], intervals, WINDOW)
        told = power.edges[-1] <= 0.5 / max(intervals) * 1.001  # noise of a faster log is spread over more octaves
        if told:
            assert np.sum(power.power[:, 0] / power.duration) == pytest.approx(1.0, rel=0.05)
        else:
            density = power.power[:, 0] / power.duration / np.diff(power.edges)
            assert density[-3:] == pytest.approx(2.0 * min(intervals), rel=0.1)


def test_what_is_slower_than_the_runs_has_no_correlation_time() -> None:
    rng = np.random.default_rng(4)
    records = [np.full(1000, rng.normal()) for _ in range(6)]
    found = coloured(
        octave_power(records, [rng.normal(0.0, 1e-3, (1000, 8)) for _ in range(6)], [0.01] * 6, WINDOW), CHANCE
    )
    assert found.rms > 0.1 and found.correlation_time is None


def test_dry_friction_is_left_as_its_torque_until_it_is_named() -> None:
    dry = Hypothesis(("axis.coulomb",))
    search = searched([run_of(k, {"axis.coulomb": {"M_c": 0.06}}) for k in range(3)], dry)
    before, after = (left_by(search.fits(e), (0, 1, 2)) for e in (NOTHING, dry))
    assert before is not None and after is not None
    assert before.rms > 0.06  # the friction, and what the inertia that was bent to suit it gets wrong
    assert after.rms < 0.05 * before.rms
    assert after.json()["rms_Nm"] == after.rms and len(after.json()["spectrum"]) == len(after.density)


@pytest.mark.parametrize("name", ["drive.lag", "sensor.eccentricity", "sensor.delay", "axis.presliding"])
def test_beside_hidden_states_late_or_bent_readings_the_motion_tells_no_torque(name: str) -> None:
    search = searched([run_of(k, {"axis.coulomb": {"M_c": 0.06}}) for k in range(2)], Hypothesis((name,)))
    assert left_by(search.fits(Hypothesis((name,))), (0, 1)) is None
