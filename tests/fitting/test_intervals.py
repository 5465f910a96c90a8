"""What is known besides the logs, numbers of every run, and how sure the estimates are."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log
from rwjax.fitting.bootstrap import bootstrap
from rwjax.fitting.coordinates import Coordinates, coordinates
from rwjax.fitting.fit import fit
from rwjax.fitting.multiple_shooting import least_squares
from rwjax.fitting.nonsmooth import secant_steps
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.profile import interval
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from tests.fitting.test_multiple_shooting import FREE, TIME, log_of
from tests.systems import platform

ALL = '"drive.gain", "axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'


def _runs(rig: Rig, inertias: list[float]) -> list[Log]:
    """One run of the rig for each inertia, named `a.csv`, `b.csv`, …"""
    truths = [rig.with_values({"axis.inertia": inertia}) for inertia in inertias]
    logs = [log_of(truth, noise=1e-3) for truth in truths]
    return [replace(log, name=f"{name}.csv") for name, log in zip("abcdef", logs, strict=False)]


def test_a_known_added_inertia_tells_friction_and_inertia_in_absolute_units() -> None:
    truth = platform(free=ALL)
    plain, loaded = _runs(truth, [0.1, 0.14])
    believed = truth.with_values({"drive.gain": 0.6, "axis.inertia": 0.17})
    alone = fit(believed, [plain])
    assert any("only a combination of" in note for note in alone.notes)  # gain, inertia and friction scale together
    both = fit(believed, [plain, replace(loaded, added={"axis.inertia": 0.04})])
    for name in truth.free:
        error = both.uncertainty.standard_error[name]
        assert abs(both.rig.values[name] - truth.values[name]) < 4.0 * error, name
        assert error < 0.02 * truth.values[name], name


def test_a_number_of_every_run_comes_back_run_by_run() -> None:
    truth = platform(free=FREE)
    inertias = [0.09, 0.1, 0.12]
    found = fit(replace(truth, per_run=("axis.inertia",)), _runs(truth, inertias))
    numbers = found.fit.numbers()
    for name, inertia in zip("abc", inertias, strict=True):
        own = f"axis.inertia in {name}.csv"
        assert abs(numbers[own] - inertia) < 4.0 * found.uncertainty.standard_error[own]
    assert found.rig.values["axis.inertia"] == pytest.approx(np.mean(inertias), rel=1e-3)
    assert found.rig.values["axis.friction.coulomb"] == pytest.approx(0.05, rel=1e-2)
    scatter = np.std(inertias, ddof=1) / np.sqrt(3.0)
    assert found.rig.standard_error["axis.inertia"] == pytest.approx(scatter, rel=0.05)


def test_a_prior_weighs_as_much_as_it_is_sure() -> None:
    truth = platform(free=FREE)
    log = log_of(truth, noise=1e-3)
    plain = fit(truth, [log])
    value, error = plain.rig.values["axis.inertia"], plain.uncertainty.standard_error["axis.inertia"]
    unsure = fit(replace(truth, prior={"axis.inertia": (2.0 * value, 1e6)}), [log])
    assert unsure.rig.values["axis.inertia"] == pytest.approx(value, rel=1e-7)
    sure = fit(replace(truth, prior={"axis.inertia": (value + error, 1e-3 * error)}), [log])
    assert sure.rig.values["axis.inertia"] == pytest.approx(value + error, abs=0.01 * error)
    assert sure.uncertainty.standard_error["axis.inertia"] == pytest.approx(1e-3 * error, rel=0.01)


def test_a_prior_settles_what_the_logs_leave_open() -> None:
    truth = platform(free=ALL)
    known = replace(truth.with_values({"axis.inertia": 0.15}), prior={"drive.gain": (0.4, 0.02)})
    found = fit(known, [log_of(truth, noise=1e-3)])
    assert not any("only a combination" in note for note in found.notes)
    for name in truth.free:  # all scale with the gain, which is known to 5 %
        assert found.rig.values[name] == pytest.approx(truth.values[name], rel=0.01), name
        assert found.uncertainty.standard_error[name] == pytest.approx(0.05 * truth.values[name], rel=0.2), name


def test_three_kinds_of_interval_agree_where_the_sum_of_squares_is_a_parabola() -> None:
    truth = platform(free=FREE)
    found = fit(truth, [log_of(truth, noise=1e-3)])
    drawn = np.percentile(bootstrap(found.fit, 60), (2.5, 97.5), axis=0).T
    for k, name in enumerate(found.fit.free):
        error = found.uncertainty.standard_error[name]
        low, high = found.interval[name]
        number = int(found.fit.coordinates.index[k])
        assert interval(found.fit, number, float(found.uncertainty.inflation[k]), error) == pytest.approx(
            (low, high), abs=0.05 * error
        )
        assert 0.5 < (drawn[k, 1] - drawn[k, 0]) / (high - low) < 1.6, name  # 60 draws of 24 stretches
        assert low < truth.values[name] < high, name


def test_a_number_at_its_bound_has_a_one_sided_interval_that_the_profile_gives() -> None:
    truth = platform("viscous = 0.02\ncoulomb = 0.0", free=FREE)
    log = log_of(truth, noise=1e-3)
    found = fit(truth.with_values({"axis.friction.coulomb": 0.01}), [log])
    low, high = found.interval["axis.friction.coulomb"]
    assert low == 0.0 < high
    # the upper end by hand: hold the friction there, fit the rest, and see the cost grow by half of 3.84
    held = replace(truth.with_values({"axis.friction.coulomb": high}), free=truth.free[:2])
    k = found.fit.free.index("axis.friction.coulomb")
    grown = 2.0 * (fit(held, [log]).fit.cost - found.fit.cost) / found.uncertainty.inflation[k]
    assert grown == pytest.approx(3.84, rel=0.05)
    assert any("by its profile" in note for note in found.notes)


def test_numbers_that_only_scale_together_have_no_interval() -> None:
    rig = platform(free=ALL)
    found = fit(rig, [log_of(rig, noise=1e-3)])
    assert {ends[1] for ends in found.interval.values()} == {np.inf}


def _red(samples: int, rho: float, size: float, seed: int) -> np.ndarray:
    """Correlated noise of a standard deviation."""
    white = np.random.default_rng(seed).normal(0.0, size * np.sqrt(1.0 - rho**2), samples)
    red = np.zeros(samples)
    for k in range(1, samples):
        red[k] = rho * red[k - 1] + white[k]
    return red


def test_a_prior_weighs_as_much_as_it_is_sure_where_residuals_are_correlated() -> None:
    truth = platform(free=FREE)
    clean = log_of(truth)
    log = replace(clean, outputs={"yaw_rad": clean.outputs["yaw_rad"] + _red(len(TIME), 0.98, 0.02, 0)})
    plain = fit(truth, [log])
    value, error = plain.rig.values["axis.inertia"], plain.uncertainty.standard_error["axis.inertia"]
    found = fit(replace(truth, prior={"axis.inertia": (value + 2.0 * error, error)}), [log])
    assert (found.rig.values["axis.inertia"] - value) / (2.0 * error) == pytest.approx(0.5, abs=0.2)
    assert found.uncertainty.standard_error["axis.inertia"] == pytest.approx(error / np.sqrt(2.0), rel=0.3)


def test_a_bootstrap_over_many_short_logs_moves_in_every_draw() -> None:
    truth = platform(free=FREE)
    parts = [log_of(truth, noise=1e-3).cut(k, k + 200) for k in range(0, 1000, 100)]
    found = fit(truth, parts)
    drawn = bootstrap(found.fit, 40)
    assert np.all(np.abs(drawn - found.fit.theta[found.fit.coordinates.index]).max(axis=1) > 0.0)
    for k, name in enumerate(found.fit.free):
        assert 0.5 < np.std(drawn[:, k]) / found.uncertainty.standard_error[name] < 2.0, name


def test_a_bootstrap_draws_the_prior_too_and_leaves_open_what_is_open() -> None:
    rig = platform(free=ALL)
    log = log_of(rig, noise=1e-3)
    low, high = fit(replace(rig, prior={"drive.gain": (0.4, 0.02)}), [log], bootstrap=60).interval["axis.inertia"]
    assert high - low == pytest.approx(3.92 * 0.05 * 0.1, rel=0.35)
    open_ended = fit(rig, [log], bootstrap=5)
    assert open_ended.interval["axis.inertia"][1] == np.inf
    assert not any("refits" in note for note in open_ended.notes)


def test_two_numbers_of_every_run_in_runs_of_different_length() -> None:
    truth = platform(free=FREE)
    runs = []
    for name, inertia, level, samples in (("a", 0.09, 0.05, 1001), ("b", 0.1, 0.03, 401), ("c", 0.12, 0.07, 701)):
        rig = truth.with_values({"axis.inertia": inertia, "axis.friction.coulomb": level})
        runs.append(replace(log_of(rig, noise=1e-3).cut(0, samples), name=name))
    found = fit(replace(truth, per_run=("axis.inertia", "axis.friction.coulomb")), runs)
    numbers, errors = found.fit.numbers(), found.uncertainty.standard_error
    for name, inertia, level in (("a", 0.09, 0.05), ("b", 0.1, 0.03), ("c", 0.12, 0.07)):
        for number, value in (("axis.inertia", inertia), ("axis.friction.coulomb", level)):
            own = f"{number} in {name}"
            assert abs(numbers[own] - value) < 4.0 * errors[own] < 0.05 * value, own


def test_the_mean_over_runs_is_as_unsure_as_what_they_share() -> None:
    truth = replace(platform(free=ALL), per_run=("axis.inertia",), prior={"drive.gain": (0.4, 0.02)})
    found = fit(truth, _runs(truth, [0.0999, 0.1, 0.1001]))
    assert found.rig.standard_error["axis.inertia"] == pytest.approx(0.005, rel=0.1)  # 5 % of the gain, of 0.1


def test_a_prior_on_a_number_of_every_run_asks_nothing_of_the_shared_start() -> None:
    truth = replace(platform(free=FREE), per_run=("axis.inertia",), prior={"axis.inertia": (0.1, 1e-4)})
    logs = _runs(truth, [0.1, 0.1])
    costs = [fit(truth.with_values({"axis.inertia": start}), logs).fit.cost for start in (0.1, 0.13)]
    assert costs[0] == pytest.approx(costs[1], rel=1e-6)


@pytest.mark.parametrize("spread", [0.01, 0.003, 0.0005])
def test_a_light_prior_decides_what_only_it_knows(spread: float) -> None:
    truth = platform(free=ALL)
    believed = replace(truth.with_values({"axis.inertia": 0.12}), prior={"axis.inertia": (0.1, spread)})
    found = fit(believed, [log_of(truth, noise=1e-4)])  # readings good to a millionth beside a prior of 10 %
    assert not any("fix one" in note for note in found.notes)
    assert found.rig.values["axis.inertia"] == pytest.approx(0.1, abs=0.02 * spread)
    assert found.rig.values["drive.gain"] == pytest.approx(0.4, abs=0.1 * spread)
    assert found.uncertainty.standard_error["axis.inertia"] == pytest.approx(spread, rel=0.02)


def test_a_model_that_misses_and_a_prior_that_is_far_off_are_said() -> None:
    truth = platform(free=FREE)
    log = log_of(truth, noise=1e-3)
    assert not any("misses the readings" in note for note in fit(truth, [log]).notes)
    unpowered = replace(log, command=0.0 * log.command, name="off.csv")
    assert any("misses the readings" in note and "off.csv" in note for note in fit(truth, [unpowered]).notes)
    notes = fit(replace(truth, prior={"axis.inertia": (0.15, 0.001)}), [log]).notes
    assert any("standard deviations from its prior" in note for note in notes)


def _believed_heavier() -> tuple[Problem, Coordinates, np.ndarray]:
    """A problem with an inertia that is known to be 0.12 besides logs that say 0.1, and where its fit begins."""
    rig = platform(free=FREE)
    structure = structure_of(rig)
    problem = pose(structure, (log_of(rig, noise=1e-3),), prior={"axis.inertia": (0.12, 1e-9)})
    theta = theta_of(rig, structure)
    free = np.array([name in rig.free for name in structure.names])
    moves = coordinates(theta, free, bounds_of(rig, structure), np.abs(theta) + 1e-3, prior=True)
    return problem, moves, theta


def test_a_step_goes_all_the_way_to_a_sure_prior() -> None:
    problem, moves, theta = _believed_heavier()
    begun = least_squares(problem, moves, theta, most_steps=0)
    once = least_squares(problem, moves, theta, damping=0.0, most_steps=1)
    assert begun.theta[moves.index[0]] == 0.1
    assert once.theta[problem.names.index("axis.inertia")] == pytest.approx(0.1 * np.exp(0.2), rel=1e-3)


def test_steps_across_creases_heed_a_prior() -> None:
    problem, moves, theta = _believed_heavier()
    begun = least_squares(problem, moves, theta, most_steps=0)
    found, start, cost = secant_steps(problem, moves, theta, begun.start, problem.start_free, begun.cost)
    again = least_squares(problem, moves, found, start=start, most_steps=0)
    assert cost < 0.2 * begun.cost and cost == pytest.approx(again.cost, rel=1e-9)
    assert found[problem.names.index("axis.inertia")] == pytest.approx(0.12, rel=0.05)


def test_standard_errors_know_that_residuals_are_correlated() -> None:
    truth = platform(free=FREE)
    clean = log_of(truth)
    fits = []
    for seed in range(12):
        y = clean.outputs["yaw_rad"] + _red(len(TIME), 0.98, 0.02, seed)
        fits.append(fit(truth, [replace(clean, outputs={"yaw_rad": y})]))
    for name in truth.free:
        scatter = np.std([f.rig.values[name] for f in fits], ddof=1)
        claimed = np.median([f.uncertainty.standard_error[name] for f in fits])
        assert 0.5 < claimed / scatter < 2.5, name  # a tenth of it if every sample counted by itself
