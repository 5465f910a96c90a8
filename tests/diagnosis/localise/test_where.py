"""Where: smoother, regimes, bands and the split of momentum, each against what was planted and against nothing."""

import numpy as np
import pytest
from scipy.stats import binom, kstest

from rwjax.diagnosis.localise.momentum import LEVEL, Momentum, bump
from rwjax.diagnosis.localise.own_noise import above
from rwjax.diagnosis.localise.regimes import REGIMES, bands, regimes, shares
from rwjax.diagnosis.localise.smoother import smoother
from rwjax.diagnosis.localise.where import Where, locate
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import sizes_of
from rwjax.logs.log import Log
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import Evaluation
from tests.systems import platform, reaction, record, run

TIME = np.arange(1001) * 0.01
PUSH = 0.9 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME)
COMMAND = np.where(TIME > 0.6, PUSH, 0.0)
COASTS = np.where(np.mod(TIME, 3.0) < 2.0, COMMAND, 0.0)
NOISE = {"yaw_rad": 2e-4, "yaw_rad_s": 2e-3, "wheel_rad_s": 0.3, "current_A": 0.01}


def as_given(rig: Rig, *logs: Log) -> Fit:
    """The rig's own numbers as a fit."""
    structure = structure_of(rig)
    theta, problem = theta_of(rig, structure), pose(structure, logs)
    free = np.array([name in rig.free for name in structure.names])
    moves = coordinates(theta, free, bounds_of(rig, structure), sizes_of(rig, structure, theta, list(logs)))
    unused = Evaluation(*[np.zeros(0)] * 7)
    return Fit(problem, moves, theta, problem.start, 0.0, unused, True, 0)


def measured(
    rig: Rig, command: np.ndarray, told: np.ndarray, names: tuple[str, ...], seed: int, **effects: dict
) -> Log:
    """Noisy readings of a run under `command` where the log tells of `told`."""
    y = run(rig, record(TIME, command), {}, effects=effects or None)
    rng = np.random.default_rng(seed)
    return record(TIME, told, {name: y[name] + NOISE[name] * rng.normal(size=len(TIME)) for name in names})


def located(rig: Rig, *logs: Log) -> Where:
    found = locate(as_given(rig, *logs), tuple(range(len(logs))), {"time": 1.0}, "time")
    assert found is not None
    return found


def momentum(rig: Rig, seed: int, names: tuple[str, ...], **effects: dict) -> Momentum:
    logs = [measured(rig, c, c, names, 100 * seed + k, **effects) for k, c in enumerate((8.0 * COMMAND, 8.0 * COASTS))]
    found = located(rig, *logs).momentum
    assert found is not None
    return found


def test_the_smoother_is_the_penalised_least_squares_line() -> None:
    # order 2, uniform steps: the smoothed value minimises sum (y - x)^2/r + w' Q^-1 w, here solved as one linear system
    n, h, r = 120, 0.02, 0.05
    y = np.sin(np.arange(n) * h * 3.0) + r * np.random.default_rng(0).normal(size=n)
    y[40:43] = np.nan
    s = smoother(y, np.full(n - 1, h), r, 2)
    X = s(y)
    assert np.allclose(s(np.stack([y, 2.0 * y], axis=1))[..., 1], 2.0 * X, rtol=1e-9, atol=1e-12)
    grown = s.ahead[0]
    V_ratio = s.gain[-1, 1] / s.gain[-1, 0]  # settled gain: q from the Riccati equation's fixed point
    s0 = r**2 / (1.0 - s.gain[-1, 0])
    P = np.array([[s.gain[-1, 0] * s0, s.gain[-1, 1] * s0], [s.gain[-1, 1] * s0, np.nan]])
    q = (P[0, 1] ** 2 / s0) / h  # P11 grows by q h and loses P01^2 / s in every step
    Q = q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]])
    A, b = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
    for k in range(n):
        if np.isfinite(y[k]):
            A[2 * k, 2 * k] += 1.0 / r**2
            b[2 * k] += y[k] / r**2
        if k:
            step = np.zeros((2, 2 * n))
            step[:, 2 * k : 2 * k + 2], step[:, 2 * k - 2 : 2 * k] = np.eye(2), -grown
            A += step.T @ np.linalg.solve(Q, step)
    assert V_ratio > 0.0
    inside = slice(5, n - 5)  # the filter begins from a wide guess, not from none
    assert np.allclose(X[inside, 0], np.linalg.solve(A, b)[::2][inside], atol=2e-4 * r)
    assert np.allclose(s.deviation[inside, 0], np.sqrt(np.diag(np.linalg.inv(A))[::2][inside]), rtol=1e-3)


def test_test_functions_have_unit_area_and_their_own_derivatives() -> None:
    s = np.linspace(-1.0, 1.0, 20001)
    value, first, second = bump(s, 0.4)
    t = 0.2 * s
    assert np.trapezoid(value, t) == pytest.approx(1.0, abs=1e-6)
    assert np.allclose(np.gradient(value, t)[1:-1], first[1:-1], atol=1e-4 * np.max(first))
    assert np.allclose(np.gradient(first, t)[1:-1], second[1:-1], atol=1e-4 * np.max(second))


def test_regimes_of_a_made_up_motion() -> None:
    t = np.arange(800) * 0.01
    speed = np.select([t < 1.0, t < 3.0, t < 5.0, t < 6.0], [0.0, 1.0, -1.0, 0.0], default=0.5)
    command = np.select([t < 1.0, t < 2.0, t < 4.0], [0.0, 2.0, 1.0], default=0.0)
    named = np.array(REGIMES)[regimes(t, speed, speed == 0.0, command, 2.0)]
    for at, name in (
        (0.5, "stuck"), (1.1, "breaking away"), (1.5, "saturated"), (2.5, "sliding"), (2.95, "reversing"),
        (3.05, "reversing"), (3.5, "sliding"), (4.5, "coasting"), (5.5, "stuck"), (6.1, "breaking away"), (7.0, "coasting"),
    ):  # fmt: skip
        assert named[round(at / 0.01)] == name, at


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


def test_p_of_regimes_and_of_logarithms_are_even_where_nothing_is_planted() -> None:
    rng = np.random.default_rng(5)
    label = np.select([np.mod(np.arange(1200), 300) < 60, np.mod(np.arange(1200), 170) < 40], [0, 2], default=5)
    p = []
    for _ in range(300):
        noise = rng.normal(size=1230)
        slow = np.convolve(noise, np.ones(31) / np.sqrt(31.0), mode="valid")  # correlated over 31 samples
        own = rng.normal(size=(1200, 4)) ** 2
        parts = shares([slow**2], [own], [label], [np.repeat(label[:, None], 4, 1)])
        p += [part.p for part in parts if part.name == "reversing"]
    assert kstest(p, "uniform").pvalue > 1e-3
    squares = rng.chisquare(60, size=(2000, 25))
    assert kstest([above(row[0], row[1:]) for row in squares], "uniform").pvalue > 1e-3
    white = rng.normal(size=(200, 1200, 25))
    low = [bands([one[:, 0]], [one[:, 1:]], [0.01])[-2].p for one in white]
    assert kstest(low, "uniform").pvalue > 1e-3


FULL = ("yaw_rad", "wheel_rad_s", "current_A")
COUPLED = "viscous = 0.0026\ncoulomb = 0.004"


@pytest.mark.parametrize("names", [FULL, FULL[:2]])
def test_the_side_that_lacks_a_torque(names: tuple[str, ...]) -> None:
    rig = reaction(COUPLED)
    assert momentum(rig, 1, names, **{"axis.bias_torque": {"T": 0.002}}).side == "external"
    assert momentum(rig, 2, names, **{"wheel.coulomb": {"M_c": 5e-4}}).side == "internal"
    assert momentum(rig, 3, names, **{"drive.deadzone": {"u_0": 0.4}}).side == "internal"


def test_neither_side_where_nothing_is_missing() -> None:
    rig, seeds = reaction(COUPLED), 40
    found = [momentum(rig, seed, FULL) for seed in range(seeds)]
    for alarms in (sum(m.external < LEVEL for m in found), sum(m.internal < LEVEL for m in found)):
        assert alarms <= binom.ppf(0.999, seeds, LEVEL)
    p = np.array([m.external for m in found])
    assert kstest(p, "uniform").pvalue > 1e-3
