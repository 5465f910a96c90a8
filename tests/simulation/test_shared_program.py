"""Plants that share a program of free runs: theirs is the motion that a program of their own gives."""

import numpy as np
import pytest

from rwjax.effects.library import BY_NAME, LIBRARY, of_kind
from rwjax.effects.parameter import parameters
from rwjax.kinds import KINDS
from rwjax.plant.from_rig import structure_of
from rwjax.plant.structure import Structure
from rwjax.simulation.free_run import free_runs
from rwjax.simulation.shared_program import numbers_with_light_effects, with_light_effects
from tests.joints import joint
from tests.simulation.plants import CASES, FAST
from tests.systems import platform, reaction, wheel
from tests.two_axes import two_axis

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
        own = np.arange(1.0, 1.0 + 2 * len(structure.names)).reshape(2, -1)
        given = numbers_with_light_effects(structure, own)
        for name, values in zip(with_light_effects(structure).names, given.T, strict=True):
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
    given = numbers_with_light_effects(structure, numbers)
    index = np.arange(given.shape[1])[None]
    shared = free_runs(
        with_light_effects(structure),
        given,
        start,
        batch.windows,
        batch._replace(theta_index=index, theta_offset=np.zeros(index.shape)),
    )
    assert np.isfinite(own).all()
    size = np.max(np.abs(own), axis=(0, 1, 2))  # of each output
    assert np.all(np.max(np.abs(shared - own), axis=(0, 1, 2)) <= 1e-9 * size)


def test_the_quick_ones_are_cases() -> None:
    assert {*QUICK} <= {*CASES}


def test_light_effects_have_no_states_of_their_own() -> None:
    light = [effect for effect in LIBRARY if effect.light]
    assert light and not any(effect.states or effect.passes_for for effect in light)
