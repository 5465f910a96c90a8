"""Margins against python-control, and against the loops that they say to be the last stable ones."""

import control
import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import pd_loop
from rwjax.control.margins import margins, pd_margins
from rwjax.control.sampled_loop import sampled_loop
from rwjax.control.transfer import transfer
from tests.systems import platform

RNG = np.random.default_rng(11)


def random_loop(unstable: bool) -> tuple[np.ndarray, np.ndarray]:
    """A strictly proper open loop whose poles are stable, one of them at 0 in every second, or of which one is not."""
    poles = -np.exp(RNG.uniform(-2.0, 3.0, RNG.integers(2, 5)))
    poles[0] *= -1.0 if unstable else RNG.random() < 0.5
    den = np.poly(poles)
    num = RNG.uniform(0.2, 3.0) * np.abs(den).max() * np.poly(-np.exp(RNG.uniform(-2.0, 3.0, len(poles) - 2)))
    return num, den


@pytest.mark.parametrize("unstable", [False, True])
def test_margins_of_a_hundred_loops_are_those_of_python_control(unstable: bool) -> None:
    compared, below = 0, 0
    while compared < 100:
        num, den = random_loop(unstable)
        if not np.all(np.roots(np.polyadd(num, den)).real < 0.0):
            continue
        found, system = margins(np.atleast_1d(num), den), control.tf(num, den)
        gains, phases, moduli, _, crossings, _ = control.stability_margins(system, returnall=True)
        gains = np.append(gains, -1.0 / np.real(system(0.0)) if den[-1] != 0.0 and np.real(system(0.0)) < 0.0 else [])
        low, high = (gains[(gains > 0.0) & side] for side in (gains < 1.0, gains > 1.0))
        assert found.gain[0] == pytest.approx(np.max(low, initial=0.0), rel=1e-6)
        assert found.gain[1] == pytest.approx(np.min(high, initial=np.inf), rel=1e-6)
        lags = np.radians(np.mod(phases, 360.0))
        assert found.phase == pytest.approx(np.min(np.minimum(lags, 2.0 * np.pi - lags), initial=np.inf), rel=1e-6)
        assert found.delay == pytest.approx(np.min(lags / crossings, initial=np.inf), rel=1e-6)
        ends = [1.0, abs(1.0 + system(0.0))] if den[-1] != 0.0 else [1.0]  # at no and at high frequency
        assert found.modulus == pytest.approx(min(np.min(moduli, initial=np.inf), *ends), rel=1e-6)
        compared, below = compared + 1, below + (found.gain[0] > 0.0)
    assert (below > 90) == unstable  # too low a gain does not hold an unstable plant


def test_the_loop_bears_its_margins_and_no_more() -> None:
    # friction that falls with speed: too low a gain does not hold the axis, and the motor's lag bears no high one
    rig = parse_rig(
        'kind = "reaction"\n[motor]\ntorque_constant = 0.0182\nresistance = 0.83\ninductance = 0.1\n[wheel]\n'
        "inertia = 1.24e-4\n[axis]\ninertia = 0.0495\n[axis.friction]\npolynomial = [0.0186, -0.0026, 0.0, 0.0]"
    )
    plant, gains = transfer(linearised(rig)), np.array([20.0, 0.0])
    found, loop = pd_margins(plant, *gains), pd_loop(plant)
    assert np.all(loop.poles(*gains).real < 0.0) and 0.0 < found.gain[0] < 1.0 < found.gain[1] < np.inf
    (low, high), bears = found.gain, True
    for factor, stable in ((0.99 * low, False), (1.01 * low, bears), (0.99 * high, bears), (1.01 * high, False)):
        assert bool(np.all(loop.poles(*(factor * gains)).real < 0.0)) == stable


def test_a_sampled_loop_bears_the_delay_margin_but_for_its_own() -> None:
    plant, gains, h = transfer(linearised(platform())), (10.0, 2.0), 0.01
    bears = pd_margins(plant, *gains).delay
    own = h  # half a sample of the hold and half a sample of the difference
    for late, stable in ((0.97 * bears - own, True), (1.03 * bears - own, False)):
        z = 1.0 + sampled_loop(plant, h, late).poles(*gains)
        assert bool(np.all(np.abs(z) < 1.0)) == stable
