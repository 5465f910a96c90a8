"""A stepper of one's own, handed in from outside."""

from dataclasses import dataclass
from pathlib import Path

import jax
import numpy as np
import pytest

from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.plant import Command, Plant
from rwjax.plant.structure import State
from rwjax.rig.model import Rig
from rwjax.simulation.exact import Exact
from rwjax.simulation.exponential_step import ExponentialStep
from rwjax.simulation.free_run import free_run
from rwjax.simulation.solver import Solver
from rwjax.simulation.stepper import Stepper
from rwjax.types import Scalar
from tests.systems import reaction, record
from tests.two_axes import GIMBAL, GRAVITY, two_axis


@dataclass(frozen=True)
class Midpoint(Stepper):
    """The explicit midpoint rule, for plants without dry friction."""

    share: float = 0.5

    def prepare(self, plant: Plant, h: Scalar) -> None:
        """Nothing is shared."""

    def step(self, plant: Plant, prepared: None, t: Scalar, x: State, u: Command, h: Scalar) -> State:
        """State after one step."""
        half = tuple(a + self.share * h * k for a, k in zip(x, plant.field(t, x, u), strict=True))
        return tuple(a + h * k for a, k in zip(x, plant.field(t + self.share * h, half, u), strict=True))


T = np.arange(101) * 0.01
ONE = 3.0 * np.sin(4.0 * T)
CASES = {
    "reaction": (reaction("viscous = 0.0026\n[axis.gravity]\ntorque = 0.3\nangle = 0.2"), ONE),
    "two_axis": (two_axis(GIMBAL + GRAVITY), np.stack([ONE, ONE[::-1]], axis=1)),
}


def readings(rig: Rig, u: np.ndarray, refine: int, **given: Solver) -> np.ndarray:
    """Readings of a free run, posed with a solver or with none."""
    structure = structure_of(rig)
    outputs = dict.fromkeys(structure.outputs, np.zeros_like(T))
    problem = pose(structure, (record(T, u, outputs),), dict.fromkeys(outputs, 1.0), refine=refine, **given)
    start = np.array([[0.3 if name.startswith("psi") else 0.0 for name in structure.states]])
    return np.asarray(free_run(structure, theta_of(rig, structure), start, problem.batch, solver=problem.solver)[0])


def miss(kind: str, refine: int) -> float:
    """Largest difference between both steppers in yaw [rad]."""
    rig, u = CASES[kind]
    return float(np.max(np.abs(readings(rig, u, refine, solver=Exact(Midpoint())) - readings(rig, u, refine))[..., 0]))


def test_a_midpoint_step_agrees_to_its_order() -> None:
    assert np.log2(miss("reaction", 1) / miss("reaction", 4)) / 2.0 == pytest.approx(2.0, abs=0.2)


def test_a_rig_with_two_axes_takes_a_stepper_of_ones_own() -> None:
    assert 0.0 < miss("two_axis", 1) < 1e-4


def test_the_stepper_that_a_problem_is_posed_with_is_the_only_one_used(monkeypatch: pytest.MonkeyPatch) -> None:
    rig, u = CASES["reaction"]
    structure = structure_of(rig)
    problem = pose(structure, (record(T, u, {}),), {}, solver=Exact(Midpoint(share=0.51)))

    def refuse(*_: object) -> None:
        raise AssertionError("the library's own step was taken")

    monkeypatch.setattr(ExponentialStep, "prepare", refuse)
    found = predict_logs(problem, theta_of(rig, structure), with_floor=False)[0]
    assert np.ptp(found.outputs["yaw_rad"]) > 0.01


def test_programs_of_a_stepper_of_ones_own_are_not_kept_on_disk(tmp_path: Path) -> None:
    rig, u = CASES["reaction"]
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        readings(rig, u, 1, solver=Exact(Midpoint(share=0.52)))
        assert not [*tmp_path.glob("traced-*")]
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    assert not Exact(Midpoint()).from_library and Exact().from_library
