"""What chapters 2 and 4 of the thesis say, as statements that could fail."""

import numpy as np
import pytest

from experiments.thesis import chapter2, left_open, region, square_waves
from experiments.thesis.testbed import AMPS, INERTIA, TOP, VOLTS, yaw_testbed
from rwjax.control.drive_limits import Limits
from rwjax.control.momentum_dump import dump
from rwjax.control.ring import slew_time
from rwjax.control.sizing import size_wheels

WAVES = {}


def waves(gains: tuple[float, float]) -> list[square_waves.Wave]:
    if gains not in WAVES:
        WAVES[gains] = [square_waves.wave(h, square_waves.controller(*gains)) for h in square_waves.HEIGHTS]
    return WAVES[gains]


def test_the_ring_of_chapter_2() -> None:
    thin, right = float(chapter2.RING.thin_inertia), float(chapter2.RING.inertia)
    assert right / thin == pytest.approx(0.82)
    behind = chapter2.inertia_behind(15.0, thin)
    assert behind == pytest.approx(0.19, abs=0.005)  # not printed: what "90° in 15 s" stands for
    assert slew_time(behind, 0.5 * np.pi, right * TOP) == pytest.approx(15.0 / 0.82)


def test_no_wheel_of_10_cm_turns_chapter_4_s_axis_by_90_degrees_in_one_go() -> None:
    limits = Limits(VOLTS, AMPS, TOP)
    over = size_wheels(yaw_testbed(), np.array([float(chapter2.RING.thin_inertia), 1.24e-4]), 0.5 * np.pi, 15.0, limits)
    assert np.all(np.isinf(over.time))


def test_the_counts_of_listing_a4() -> None:
    assert region.count(region.as_printed()) == 6928
    assert region.count(region.corrected()) == 7001
    assert region.corrected().num[0] < 0.0  # eq. 4.11 drops the minus sign of eq. 4.2
    assert region.corrected().hidden == (0.0,)


@pytest.mark.parametrize("ki", region.INTEGRALS)
def test_slices_are_what_roots_say(ki: float) -> None:
    found = region.with_integral(region.corrected(), ki)[::10, ::10]
    plant = region.corrected()
    for i, kp in enumerate(region.GRID[::10]):
        for j, kd in enumerate(region.GRID[::10]):
            law, den = ([kd, kp, ki], np.append(plant.den, 0.0)) if ki else ([kd, kp], plant.den)
            poles = np.roots(np.polyadd(den, np.polymul(plant.restoring, law)))
            assert found[i, j] == bool(np.all(poles.real < -region.SIGMA))


def test_what_the_thesis_finds_of_its_square_waves() -> None:
    found = square_waves.findings(waves(square_waves.SOFT), waves(square_waves.STIFF))
    assert found.stiffer_tracks_better and found.stiffer_saturates_more and found.an_error_stays
    assert found.overshoot_is_larger_at_20_degrees_than_at_10
    assert not found.overshoot_grows_on_to_45_degrees  # here the wheel runs into the voltage's limit speed


def test_the_error_that_stays_is_no_more_than_what_friction_holds() -> None:
    # a stuck axis and a wheel that has come to its steady rate: u = (K + R b/K) Ω, and Kp e = u
    for gains in (square_waves.SOFT, square_waves.STIFF):
        for w in waves(gains):
            last, wheel = float(w.run.command[999]), float(w.run.wheel[999])
            assert float(w.run.rate[999]) == 0.0
            assert last == pytest.approx((0.0182 + 0.83 * 4.07e-6 / 0.0182) * wheel, abs=0.05 * VOLTS)
            assert -float(w.out[0].error) * gains[0] == pytest.approx(
                last, abs=1.01 * gains[0] * np.pi / 2048
            )  # half a count


@pytest.mark.slow
def test_momentum_goes_into_the_bearing_and_the_axis_does_not_move() -> None:
    found = dump(yaw_testbed(), TOP, Limits(VOLTS, AMPS))
    assert found.bound == pytest.approx(1.24e-4 * TOP / (0.9 * 0.3757 * INERTIA))
    assert found.time < 1.03 * found.bound
    assert np.all(np.asarray(left_open.rushed(found, 1.0).angle) == 0.0)
    assert np.degrees(np.max(np.abs(np.asarray(left_open.rushed(found, 0.8).angle)))) > 1.0
