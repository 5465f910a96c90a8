"""Plants that share a program of free runs: theirs is the motion that a program of their own gives."""

import re
from collections import Counter
from dataclasses import replace

import jax
import numpy as np
import pytest

from rwjax.effects.library import BY_NAME, LIBRARY, of_kind
from rwjax.effects.parameter import parameters
from rwjax.fitting.problem import pose
from rwjax.kinds import KINDS
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run, free_runs
from rwjax.simulation.shared_program import batch_within, numbers_within, with_light_effects
from tests.joints import joint
from tests.simulation.plants import CASES, FAST
from tests.systems import platform, reaction, record, wheel
from tests.two_axes import two_axis

T = np.arange(101) * 0.01
RIGS = {"wheel": wheel(), "platform": platform(), "reaction": reaction(), "joint": joint(), "two_axis": two_axis()}


def structures(kind: str) -> list[Structure]:
    """A plant without an effect, and with each that this kind of rig may have."""
    bare = structure_of(RIGS[kind])
    return [bare, *(bare.with_effects(name) for name in of_kind(kind))]


def test_every_kind_is_looked_at() -> None:
    assert {*RIGS} == {*KINDS}


@pytest.mark.parametrize("kind", RIGS)
def test_states_and_outputs_stay(kind: str) -> None:
    for structure in structures(kind):
        shared = with_light_effects(structure)
        assert (shared.states, shared.outputs) == (structure.states, structure.outputs), structure.effects
        assert {*structure.effects} <= {*shared.effects}
        assert with_light_effects(shared) == shared


@pytest.mark.parametrize("kind", RIGS)
def test_programs_are_fewer_than_plants(kind: str) -> None:
    every = structures(kind)
    assert len({*map(with_light_effects, every)}) < 0.75 * len(every)


def test_dry_friction_joins_no_body_without_any() -> None:
    bare = structure_of(platform())
    assert "axis.coulomb" not in with_light_effects(bare).effects
    assert "axis.coulomb" in with_light_effects(bare.with_effects("axis.stribeck")).effects
    on_yaw = with_light_effects(structure_of(two_axis()).with_effects("yaw.stribeck")).effects
    assert "yaw.coulomb" in on_yaw and "pitch.coulomb" not in on_yaw


@pytest.mark.parametrize("kind", RIGS)
def test_numbers_stand_under_their_names_and_all_others_at_their_nulls(kind: str) -> None:
    for structure in structures(kind):
        own, shared = np.arange(1.0, 1.0 + 2 * len(structure.names)).reshape(2, -1), with_light_effects(structure)
        for name, values in zip(shared.names, numbers_within(shared, structure, own).T, strict=True):
            if name in structure.names:
                assert np.array_equal(values, own[:, structure.names.index(name)]), name
            else:
                effect, _, number = name.rpartition(".")
                assert np.all(values == parameters(BY_NAME[effect])[number].null), name


QUICK = (*FAST, "wheel: ", "reaction: ", "joint: ", "two_axis: ")
"""One of every kind: plants that share a program with all light effects of their kind."""


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in QUICK else pytest.mark.slow) for n in CASES])
def test_the_motion_is_that_of_a_program_of_its_own(name: str) -> None:
    structure, theta, batch = CASES[name]()
    numbers = theta * np.random.default_rng(0).uniform(0.98, 1.02, (3, len(theta)))
    start = np.zeros((3, len(structure.states)))
    own = free_runs(structure, numbers, start, batch.windows, batch)
    program = with_light_effects(structure)
    given = numbers_within(program, structure, numbers)
    shared = free_runs(program, given, start, batch.windows, batch.with_own_numbers(given.shape[1]))
    assert np.isfinite(own).all()
    size = np.max(np.abs(own), axis=(0, 1, 2))  # of each output
    assert np.all(np.max(np.abs(shared - own), axis=(0, 1, 2)) <= 1e-9 * size)


def test_far_from_where_it_began_a_body_meets_no_stop() -> None:
    rig = platform()
    own, start = structure_of(rig), np.array([[-9e8, 1.0], [9e8, 1.0]])
    log = record(T, np.ones_like(T), {"yaw_rad": np.zeros_like(T)})
    problem = pose(own, [log], {"yaw_rad": 1.0})
    found = []
    for structure in (problem.structure, with_light_effects(problem.structure)):
        numbers = np.tile(theta_of(rig, structure), (2, 1))
        batch = problem.batch.with_own_numbers(numbers.shape[1])
        found.append(free_runs(structure, numbers, start, batch.windows, batch))
    assert "axis.end_stop" in structure.effects and np.ptp(found[0][0]) > 0.5
    assert np.array_equal(*found)


def test_every_log_keeps_numbers_of_its_own_and_what_is_known_to_be_added_to_them() -> None:
    structure = structure_of(platform())
    logs = [record(T, u, {"yaw_rad": np.zeros_like(T)}) for u in (np.full_like(T, 0.5), np.sin(9.0 * T))]
    problem = pose(structure, logs, {"yaw_rad": 1.0}, per_run=("axis.inertia",))
    structure = problem.structure
    theta = problem.expand(theta_of(platform(), structure))
    theta[-1] *= 1.5  # the second run's inertia
    offset = problem.batch.theta_offset.copy()
    offset[0, structure.names.index("drive.gain")] = 0.1
    problem = replace(problem, batch=problem.batch._replace(theta_offset=offset))
    start = np.array([[0.0, 1.0], [0.2, -1.0]])
    shared = replace(problem, shares_programs=True)
    assert len(shared.program.names) > len(structure.names) and problem.program == structure
    y, nodes = shared.free_run(theta, start)
    own, begun = problem.free_run(theta, start)
    assert y == pytest.approx(own, rel=1e-9, abs=1e-12) and nodes == pytest.approx(begun, rel=1e-9, abs=1e-12)
    assert np.max(np.abs(own[1] - problem.free_run(problem.expand(theta[: len(structure.names)]), start)[0][1])) > 1e-4
    numbers, batch = batch_within(shared.program, structure, theta, problem.batch)
    held = numbers[batch.theta_index] + batch.theta_offset
    k = shared.program.names.index("drive.gain")
    assert held[0, k] - held[1, k] == pytest.approx(0.1)


def test_the_quick_ones_are_cases() -> None:
    assert {*QUICK} <= {*CASES}


def costly(structure: Structure, rig: Rig) -> Counter[str]:
    """How often a free run takes a function that costs as much as ten products, by its name."""
    outputs = {name: 0.1 * T for name in structure.outputs}
    log = record(T, np.ones((len(T), 2)) if rig.kind == "two_axis" else np.ones_like(T), outputs)
    problem = pose(structure, [log], dict.fromkeys(outputs, 1.0))
    theta = np.ones(len(structure.names))
    run = jax.make_jaxpr(lambda theta: free_run(problem.structure, theta, problem.start, problem.batch))(theta)
    return Counter(re.findall(r"= (pow|sqrt|exp|expm1|log|log1p|sin|cos|tanh|atan2)\b", str(run)))


@pytest.mark.parametrize("kind", RIGS)
def test_what_is_light_takes_no_power_and_no_sine(kind: str) -> None:
    rig, bare = RIGS[kind], structure_of(RIGS[kind])
    heavy = "yaw.stribeck" if kind == "two_axis" else "motor.saturation" if kind == "wheel" else "axis.stribeck"
    assert costly(bare.with_effects(heavy), rig) > costly(bare, rig)
    for structure in (bare, bare.with_effects(heavy)):  # beside a friction others join
        assert costly(with_light_effects(structure), rig) == costly(structure, rig), structure.effects


def test_light_effects_have_no_states_of_their_own() -> None:
    light = [effect for effect in LIBRARY if effect.light]
    assert light and not any(effect.states or effect.passes_for for effect in light)
