"""Standard errors against the scatter of estimates, and what the logs leave undetermined, in words."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.fit import fit
from rwjax.fitting.multiple_shooting import least_squares
from rwjax.fitting.problem import pose
from rwjax.fitting.uncertainty import uncertainty
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from tests.fitting.logs import FREE, TIME, log_of, red
from tests.systems import MOTOR, platform, record, run


def test_where_no_number_is_free_there_is_no_error() -> None:
    rig = platform("viscous = 0.02")
    structure = structure_of(rig)
    problem, theta = pose(structure, (log_of(rig, noise=1e-3),)), theta_of(rig, structure)
    none = coordinates(theta, np.zeros(len(theta), bool), bounds_of(rig, structure), np.ones_like(theta))
    found = uncertainty(least_squares(problem, none, theta))
    assert found.names == () and found.covariance.shape == (0, 0)


def test_a_number_on_its_bound_is_named() -> None:
    truth = platform("viscous = 0.0\ncoulomb = 0.05", free=FREE)
    believed = truth.with_values({"axis.friction.viscous": 0.01})
    log = log_of(truth, noise=2e-3)
    bent = record(TIME, log.command, {"yaw_rad": log.outputs["yaw_rad"] * (1.0 + 0.02 * TIME / 10.0)})
    notes = fit(believed, [bent]).notes
    assert "axis.friction.viscous sits on its bound" in notes


def test_numbers_that_only_count_together_are_named() -> None:
    text = f'kind = "wheel"\n{MOTOR}\n[fit]\nfree = ["motor.torque_constant", "motor.resistance", "wheel.inertia", "motor.friction"]'
    rig = parse_rig(text.replace("0.0641", "0.0"))
    u = np.where(TIME > 0.6, 3.0 * np.sign(np.sin(1.7 * TIME)), 0.0)
    y = run(rig, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    y = y + np.random.default_rng(0).normal(0.0, 0.3, len(y))
    found = fit(rig, [record(TIME, u, {"wheel_rad_s": y})]).uncertainty
    # the speed tells K/(R J) and (b + K^2/R)/J: two of four
    notes = [note for note in found.notes if note.startswith("only a combination of")]
    assert len(notes) == len(found.notes) == 2
    assert all(any(name in note for note in notes) for name in rig.free)
    assert all(np.isinf(error) for error in found.standard_error.values()) and found.tells_something


def test_a_number_that_moves_with_an_undetermined_combination_has_no_standard_error() -> None:
    free = 'free = ["motor.torque_constant", "motor.resistance", "wheel.inertia", "motor.friction"]'
    rig = parse_rig(f'kind = "wheel"\n{MOTOR}\n[fit]\n{free}')  # L is known: one combination is left
    u = np.where(TIME > 0.6, 3.0 * np.sign(np.sin(1.7 * TIME)), 0.0)
    y = run(rig, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    log = record(TIME, u, {"wheel_rad_s": y + np.random.default_rng(0).normal(0.0, 0.3, len(y))})
    plain = fit(rig, [log])
    held = replace(rig.with_values({"motor.friction": 20 * 4.07e-6}), free=rig.free[:3])
    other = fit(held, [log])
    assert other.fit.cost == pytest.approx(plain.fit.cost, rel=1e-9)  # the log cannot tell the two apart,
    moved = abs(other.rig.values["motor.resistance"] - plain.rig.values["motor.resistance"])
    assert moved < 3.0 * plain.uncertainty.standard_error["motor.resistance"]  # 6 % of R, 80 standard errors


def test_where_no_number_leaves_a_trace_nothing_is_told() -> None:
    found = fit(platform(free=FREE), [log_of(platform(), 0.0 * TIME, noise=1e-3)]).uncertainty
    assert {*found.silent} == {*found.names} and not found.tells_something


@pytest.mark.slow
def test_a_number_without_a_trace_is_named() -> None:
    text = "axis.inertia = 0.1\naxis.friction.viscous = 0.02\naxis.gravity.torque = 0.0\naxis.gravity.angle = 0.3"
    free = 'fit.free = ["axis.inertia", "axis.gravity.angle"]'  # the direction of a load of 0
    rig = parse_rig(f'kind = "platform"\ndrive.gain = 0.4\n{text}\n{free}')
    found = fit(rig, [log_of(rig, noise=1e-3)]).uncertainty
    assert found.notes == ("a small change of axis.gravity.angle leaves no trace in these logs",)
    assert np.isinf(found.standard_error["axis.gravity.angle"]) and np.isfinite(found.standard_error["axis.inertia"])
    assert found.silent == ("axis.gravity.angle",) and found.tells_something


def test_numbers_that_are_hardly_told_apart_are_named_with_their_correlation() -> None:
    truth = platform("viscous = 0.5\ncoulomb = 0.05", free=FREE)
    level = np.where(TIME > 5.0, 0.55, 0.5)  # two speeds that hardly differ
    log = log_of(truth, np.where(TIME > 0.6, level, 0.0), noise=1e-3)
    found = fit(truth, [log])
    notes = [note for note in found.notes if "hardly told apart" in note]
    assert any("axis.friction.viscous" in note and "axis.friction.coulomb" in note for note in notes)
    C = np.array(found.json()["covariance"])
    k = [found.rig.free.index(f"axis.friction.{name}") for name in ("viscous", "coulomb")]
    assert C[k[0], k[1]] / np.sqrt(C[k[0], k[0]] * C[k[1], k[1]]) < -0.99
    other = platform(free=FREE)
    assert not [n for n in fit(other, [log_of(other, noise=1e-3)]).notes if "hardly" in n]


def test_the_interval_is_as_wide_as_the_scatter_of_estimates() -> None:
    truth = platform(free=FREE)
    fits = []
    for seed in range(40):
        log = log_of(truth)
        noise = np.random.default_rng(seed).normal(0.0, 2e-3, len(TIME))
        fits.append(fit(truth, [record(TIME, log.command, {"yaw_rad": log.outputs["yaw_rad"] + noise})]))
    for name in truth.free:
        scatter = np.std([f.rig.values[name] for f in fits], ddof=1)
        claimed = np.median([f.uncertainty.standard_error[name] for f in fits])
        assert 0.65 < claimed / scatter < 1.5, name  # 40 draws know a scatter to 11 %


@pytest.mark.slow
def test_standard_errors_know_that_residuals_are_correlated() -> None:
    truth = platform(free=FREE)
    clean = log_of(truth)
    fits = []
    for seed in range(12):
        y = clean.outputs["yaw_rad"] + red(len(TIME), 0.98, 0.02, seed)
        fits.append(fit(truth, [replace(clean, outputs={"yaw_rad": y})]))
    for name in truth.free:
        scatter = np.std([f.rig.values[name] for f in fits], ddof=1)
        claimed = np.median([f.uncertainty.standard_error[name] for f in fits])
        assert 0.5 < claimed / scatter < 2.5, name  # a tenth of it if every sample counted by itself
