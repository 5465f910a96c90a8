"""What a fit says of a rig: read from its file, and plants drawn from it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax.control.fit_estimate import FitEstimate, draw_plants, read_fit_estimate
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from tests.control.fit_of_a_rig import ESTIMATE, MEAN, NAMES
from tests.systems import platform, reaction


def test_draws_have_the_fit_s_mean_and_covariance() -> None:
    rig = reaction()
    thetas = draw_plants(rig, ESTIMATE, 20_000)
    at = [structure_of(rig).names.index(name) for name in NAMES]
    assert np.mean(thetas[:, at], 0) == pytest.approx(MEAN, rel=0.005)  # 0.1 sqrt(1/20 000) is 0.0007
    size = np.sqrt(np.diag(ESTIMATE.covariance))
    off = (np.cov(thetas[:, at].T) - ESTIMATE.covariance) / np.outer(size, size)
    assert np.max(np.abs(off)) < 5.0 * np.sqrt(2.0 / 20_000)  # five deviations of a sample variance
    others = np.delete(np.arange(thetas.shape[1]), at)
    assert np.all(thetas[:, others] == theta_of(rig, structure_of(rig))[others])


def test_draws_keep_to_what_is_possible() -> None:
    wide = FitEstimate(NAMES, MEAN, np.diag(MEAN**2))
    assert np.all(draw_plants(reaction(), wide, 500)[:, [structure_of(reaction()).names.index(n) for n in NAMES]] > 0.0)
    with pytest.raises(InputError, match="far beyond what is possible"):
        draw_plants(reaction(), FitEstimate(NAMES[:1], np.array([-1.0]), np.array([[1e-4]])), 10)
    with pytest.raises(InputError, match=r"`motor\.resistance`, which this rig lacks"):
        draw_plants(platform(), FitEstimate(("motor.resistance",), MEAN[:1], np.eye(1)), 10)


def test_a_fit_s_answer_is_read_and_anything_else_refused(tmp_path: Path) -> None:
    path = tmp_path / "fit.json"
    answer = {"numbers": {"axis.inertia": {"value": 0.05}}, "covariance_of": ["axis.inertia"], "covariance": [[1e-6]]}
    path.write_text(json.dumps(answer))
    rig = reaction()
    assert read_fit_estimate(path, rig) == (("axis.inertia",), np.array([0.05]), np.array([[1e-6]]), ())
    path.write_text(json.dumps(answer | {"covariance": [[None]]}))
    with pytest.raises(InputError, match=r"fit\.json: `covariance`: the logs say nothing"):
        read_fit_estimate(path, rig)
    path.write_text(json.dumps({"numbers": answer["numbers"], "notes": []}))
    with pytest.raises(InputError, match="no `covariance`, as of the two-stage method"):
        read_fit_estimate(path, rig)
    for wrong in ("{", "[]", '{"covariance_of": {}}', json.dumps(answer | {"numbers": {}})):
        path.write_text(wrong)
        with pytest.raises(InputError, match="is not what `rwjax fit"):
            read_fit_estimate(path, rig)
    path.write_text(json.dumps({"numbers": {}, "covariance_of": [], "covariance": []}))
    with pytest.raises(InputError, match=r"fit\.json: `covariance_of` is empty"):
        read_fit_estimate(path, rig)
    path.write_text(json.dumps(answer))
    corrected = replace(rig, effects={"axis.coulomb": {"M_c": 0.01}}, free=("axis.inertia", "axis.coulomb.M_c"))
    with pytest.raises(InputError, match=r"fit\.json: a fit without `axis\.coulomb\.M_c`, which the rig file frees"):
        read_fit_estimate(path, corrected)
    path.write_text(json.dumps(answer | {"rig": "another"}))
    with pytest.raises(InputError, match=r"fit\.json: is a fit of rig `another`, not of"):
        read_fit_estimate(path, rig)


def test_of_what_every_run_has_of_its_own_the_mean_is_taken(tmp_path: Path) -> None:
    names = ["axis.inertia", "axis.friction.viscous in a.csv", "axis.friction.viscous in b in c.csv"]
    A = np.array([[1e-3, 0.0, 0.0], [2e-4, 5e-4, 0.0], [-1e-4, 3e-4, 4e-4]])
    numbers = {name: {"value": value} for name, value in zip(names, (0.05, 0.002, 0.004), strict=True)}
    path = tmp_path / "fit.json"
    path.write_text(json.dumps({"numbers": numbers, "covariance_of": names, "covariance": (A @ A.T).tolist()}))
    found = read_fit_estimate(path, reaction())
    assert found.names == ("axis.inertia", "axis.friction.viscous") and found.per_run == ("axis.friction.viscous",)
    assert found.mean == pytest.approx([0.05, 0.003])
    drawn = np.array([0.05, 0.002, 0.004]) + np.random.default_rng(1).normal(size=(100_000, 3)) @ A.T
    means = np.stack([drawn[:, 0], drawn[:, 1:].mean(axis=1)])
    scatter = np.diag([0.0, 2e-6])  # of 0.002 and 0.004: a plant is a run, not their mean
    assert found.covariance == pytest.approx(
        np.cov(means) + scatter, rel=0.03
    )  # 5 deviations of a sample variance: 2 %
