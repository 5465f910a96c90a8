"""The fit of a rig: known numbers come back, priors and numbers of every run, honest words."""

import re
from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, RigError, parse_rig, predict, simulate
from rwjax.fitting.fit import fit
from rwjax.simulation.layout import OF_JOINT
from tests.fitting.logs import ALL, FREE, TIME, log_of, red, runs_of
from tests.joints import joint, logged, servo
from tests.systems import platform, record, run


@pytest.mark.parametrize("factor", [0.6, 1.7])  # no start of the fit is the truth
def test_known_numbers_come_back_from_wrong_starts(factor: float) -> None:
    truth = platform(free=FREE)
    believed = truth.with_values({name: factor * truth.values[name] for name in truth.free})
    found = fit(believed, [log_of(truth)]).rig
    for name in truth.free:
        assert found.values[name] == pytest.approx(truth.values[name], rel=1e-5), name


@pytest.mark.slow
def test_a_halved_step_moves_no_number_by_a_tenth_of_its_standard_error() -> None:
    rig = platform(
        "viscous = 0.02\ncoulomb = 0.05\nstatic = 0.08\nstribeck_velocity = 0.2",
        free=FREE + ', "axis.friction.static"',
    )
    y = log_of(rig).outputs["yaw_rad"]
    q = 2 * np.pi / 2048
    log = record(TIME, log_of(rig).command, {"yaw_rad": q * np.round(y / q)}, resolution={"yaw_rad": q})
    plain, halved = fit(rig, [log]), fit(rig, [log], refine=2)
    for name, error in plain.uncertainty.standard_error.items():
        assert abs(plain.rig.values[name] - halved.rig.values[name]) < 0.1 * error, name


@pytest.mark.parametrize("factor", [0.4, 2.5])
def test_a_swing_is_not_fitted_a_period_off(factor: float) -> None:
    # twelve periods of a pendulum: with 40 % of its gravity the start is seven periods behind, each a local minimum
    truth = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.01\n'
        '[axis.gravity]\ntorque = 1.5\n[fit]\nfree = ["axis.gravity.torque", "axis.friction.viscous"]'
    )
    time = np.arange(2001) * 0.01
    y = run(truth, record(time, 0.0 * time), {"psi": 1.0})["yaw_rad"]
    log = record(time, 0.0 * time, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, 1e-3, len(y))})
    found = fit(truth.with_values({name: factor * truth.values[name] for name in truth.free}), [log])
    for name, error in found.uncertainty.standard_error.items():
        assert abs(found.rig.values[name] - truth.values[name]) < 4.0 * error < 0.04 * truth.values[name], name


def test_dropouts_cost_precision_and_nothing_else() -> None:
    truth = platform(free=FREE)
    whole = log_of(truth, np.where(TIME > 0.6, 0.6 * np.sign(np.sin(1.7 * TIME)), 0.0), noise=1e-3)
    silent = (TIME > 2.0) & (TIME < 4.5)  # no readings
    kept = ~((TIME > 6.0) & (TIME < 6.5)) | (
        np.arange(len(TIME)) % 37 == 0
    )  # hardly any samples; the command is held there
    y = np.where(silent, np.nan, whole.outputs["yaw_rad"])
    broken = record(TIME[kept], whole.command[kept], {"yaw_rad": y[kept]})
    full, found = fit(truth, [whole]), fit(truth, [broken])
    for name, error in found.uncertainty.standard_error.items():
        assert abs(found.rig.values[name] - truth.values[name]) < 4.0 * error, name
        assert full.uncertainty.standard_error[name] < error < 5.0 * full.uncertainty.standard_error[name], name


def test_a_known_added_inertia_tells_friction_and_inertia_in_absolute_units() -> None:
    truth = platform(free=ALL)
    plain, loaded = runs_of(truth, [0.1, 0.14])
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
    found = fit(replace(truth, per_run=("axis.inertia",)), runs_of(truth, inertias))
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


@pytest.mark.slow
def test_a_prior_weighs_as_much_as_it_is_sure_where_residuals_are_correlated() -> None:
    truth = platform(free=FREE)
    clean = log_of(truth)
    log = replace(clean, outputs={"yaw_rad": clean.outputs["yaw_rad"] + red(len(TIME), 0.98, 0.02, 0)})
    plain = fit(truth, [log])
    value, error = plain.rig.values["axis.inertia"], plain.uncertainty.standard_error["axis.inertia"]
    found = fit(replace(truth, prior={"axis.inertia": (value + 2.0 * error, error)}), [log])
    assert (found.rig.values["axis.inertia"] - value) / (2.0 * error) == pytest.approx(0.5, abs=0.2)
    assert found.uncertainty.standard_error["axis.inertia"] == pytest.approx(error / np.sqrt(2.0), rel=0.3)


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
    found = fit(truth, runs_of(truth, [0.0999, 0.1, 0.1001]))
    assert found.rig.standard_error["axis.inertia"] == pytest.approx(0.005, rel=0.1)  # 5 % of the gain, of 0.1


@pytest.mark.slow
def test_a_prior_on_a_number_of_every_run_asks_nothing_of_the_shared_start() -> None:
    truth = replace(platform(free=FREE), per_run=("axis.inertia",), prior={"axis.inertia": (0.1, 1e-4)})
    logs = runs_of(truth, [0.1, 0.1])
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


@pytest.mark.slow
def test_a_model_that_misses_and_a_prior_that_is_far_off_are_said() -> None:
    truth = platform(free=FREE)
    log = log_of(truth, noise=1e-3)
    assert not any("misses the readings" in note for note in fit(truth, [log]).notes)
    unpowered = replace(log, command=0.0 * log.command, name="off.csv")
    assert any("misses the readings" in note and "off.csv" in note for note in fit(truth, [unpowered]).notes)
    pushed = {"yaw_rad": log.outputs["yaw_rad"] + np.where((TIME > 5.0) & (TIME < 6.0), 0.3, 0.0)}
    (cut,) = [note for note in fit(truth, [replace(log, outputs=pushed)], segments=2.0).notes if "misses" in note]
    assert re.search(r"most yaw_rad of \S+ from \d[\d.]* to \d[\d.]* s, by ", cut)
    notes = fit(replace(truth, prior={"axis.inertia": (0.15, 0.001)}), [log]).notes
    assert any("standard deviations from its prior" in note for note in notes)


@pytest.mark.slow
def test_a_fit_whose_best_run_is_not_finite_is_refused() -> None:
    rig = platform('viscous = 0.02\n[effects."axis.spring"]\nk = 1e-300\nT_0 = 0.1\nk_3 = 0.1\n')
    log = record(TIME[:100], np.sign(np.sin(TIME[:100])), {"yaw_rad": np.sin(TIME[:100])})
    with pytest.raises(RigError, match=r"the best free run misses yaw_rad by nan rad, and no rig goes beyond 1e\+09"):
        fit(rig, [log])


def test_a_gear_that_the_file_lacks_is_told_of_where_it_matters() -> None:
    time = np.arange(100) * 0.01
    bare = joint(gear__ratio=0.0, motor__torque_constant=2.0, motor__inertia=0.0)
    log = logged(bare, time, voltage_V=5.0 * np.sign(np.sin(7.0 * time)))
    given = replace(bare, free=("axis.inertia",))
    told = [note for note in fit(given, [log]).notes if "gear.ratio" in note]
    assert told == [
        "the rig file has no gear.ratio: 1 is taken, which is right where the motor's numbers hold behind the gear, as `rwjax init` writes them"
    ]
    estimated = replace(bare, free=("motor.torque_constant",))  # with the gear it is one number
    geared = replace(bare, numbers=bare.numbers | {"gear.ratio": 1.0}, free=("axis.inertia",))
    for rig in (estimated, geared):
        assert not any("gear.ratio" in note for note in fit(rig, [log]).notes)


def test_a_servo_s_numbers_come_back_from_what_simulate_gives() -> None:
    motor = {"motor__torque_constant": 0.0107, "motor__resistance": 2.6, "gear__ratio": 345.0}
    numbers = motor | {"axis__inertia": 0.012, "axis__friction__coulomb": 0.05, "axis__gravity__torque": 0.6}
    truth = replace(servo(joint(**numbers), kp=60.0, kd=0.3), free=("axis.inertia", "axis.friction.viscous"))
    time = np.arange(400) * 0.01
    goal = np.where(time > 0.6, 0.7 * np.sign(np.sin(2.2 * time)), 0.0)
    y = np.asarray(simulate(truth, time, {"goal_rad": goal})["yaw_rad"])
    log = Log.from_arrays(truth, time=time, goal_rad=goal, yaw_rad=y)
    assert np.max(np.abs(predict(truth, log)["yaw_rad"] - y)) < 1e-12
    believed = truth.with_values({name: 1.3 * truth.values[name] for name in truth.free})
    fitted = fit(believed, [log])
    found = fitted.rig
    finest = 0.005 / OF_JOINT  # s, by which it was simulated
    assert fitted.fit.problem.batch.h[0] <= finest * (1.0 + 1e-9)
    assert {name: found.values[name] for name in truth.free} == pytest.approx(
        {name: truth.values[name] for name in truth.free}, rel=1e-4
    )
