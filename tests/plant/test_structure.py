"""What a plant is made of: names, states and outputs of every kind."""

from dataclasses import replace

import jax.numpy as jnp
import pytest

from rwjax.plant.from_rig import structure_of
from rwjax.plant.structure import Structure
from rwjax.rig.columns_section import Source
from rwjax.rig.model import Rig
from tests.joints import joint
from tests.systems import platform, reaction, wheel
from tests.two_axes import TILTING, two_axis

OWN = (("axis.flexible_coupling", "axis.flexible_coupling:twist"), ("axis.presliding", "axis.presliding:z_1"))


@pytest.mark.parametrize(
    ("structure", "states", "outputs"),
    [
        (structure_of(wheel()), "theta Omega i", "wheel_rad wheel_rad_s current_A"),
        (structure_of(wheel(0.0)), "theta Omega", "wheel_rad wheel_rad_s current_A"),
        (structure_of(platform()), "psi w", "yaw_rad yaw_rad_s"),
        (structure_of(reaction()), "psi w theta Omega i", "yaw_rad yaw_rad_s wheel_rad wheel_rad_s current_A"),
        (
            structure_of(two_axis()),
            "psi_1 w_1 theta_1 Omega_1 psi_2 w_2 theta_2 Omega_2",
            "yaw_rad yaw_rad_s wheel_1_rad wheel_1_rad_s current_1_A pitch_rad pitch_rad_s wheel_2_rad wheel_2_rad_s current_2_A",
        ),
    ],
    ids=["wheel", "wheel without inductance", "platform", "reaction", "two_axis"],
)
def test_every_kind_has_its_states_and_outputs(structure: Structure, states: str, outputs: str) -> None:
    assert structure.states == tuple(states.split()) and structure.outputs == tuple(outputs.split())
    read = {name for _, _, angle, rate in structure.turning for name in (angle, rate)}
    assert read | {name for name in structure.outputs if name.startswith("current")} == {*structure.outputs}
    assert {name for angle, rate, *_ in structure.turning for name in (angle, rate)} <= {*structure.states}


@pytest.mark.parametrize(("effect", "state"), OWN)
def test_an_effects_own_states_come_last(effect: str, state: str) -> None:
    structure = structure_of(reaction()).with_effects(effect)
    assert structure.states[:5] == structure_of(reaction()).states and state in structure.states[5:]


def test_effects_stand_in_the_order_of_the_library_however_they_are_added() -> None:
    one = structure_of(reaction()).with_effects("drive.delay", "axis.coulomb")
    assert one == structure_of(reaction()).with_effects("axis.coulomb").with_effects("drive.delay")
    assert one.names[-2:] == ("axis.coulomb.M_c", "drive.delay.tau") and one.from_library
    assert one.vector({"drive.delay.tau": 0.1})[-2:] == [0.0, 0.1]


def test_an_angle_matters_where_something_depends_on_it() -> None:
    assert structure_of(reaction()).angles == set()
    assert structure_of(reaction()).with_effects("axis.imbalance").angles == {"psi"}
    assert structure_of(reaction()).with_effects("wheel.cogging").angles == {"theta"}
    assert structure_of(two_axis()).angles == {"psi_2"}


def test_a_rig_with_two_axes_is_two_reaction_rigs_by_name() -> None:
    yaw, pitch = structure_of(two_axis(TILTING + '[effects."wheel_2.coulomb"]\nM_c = 0.1\n')).halves
    assert yaw.kind == pitch.kind == "reaction" and yaw.numbers == pitch.numbers
    assert yaw.effects == () and pitch.effects == ("wheel.coulomb",)  # the tilt belongs to both


def test_a_device_without_signs_reports_sizes() -> None:
    rig = wheel()
    reading = {"wheel_rad": jnp.array(-1.0), "wheel_rad_s": jnp.array(-2.0), "current_A": jnp.array(-3.0)}
    unsigned = replace(rig, sources={"wheel_rad_s": Source("speed", unsigned=True), "current_A": Source("current_A")})
    assert structure_of(unsigned).as_reported(reading) == (-1.0, 2.0, -3.0)
    assert structure_of(rig).as_reported(reading) == (-1.0, -2.0, -3.0)


@pytest.mark.parametrize(("kind", "parts"), [(platform(), 4), (joint(), 2), (reaction(), 4)])
def test_play_divides_the_steps_of_a_grid(kind: Rig, parts: int) -> None:
    structure = structure_of(kind)
    assert structure.parts_of_step == 1
    assert structure._replace(effects=("axis.backlash",)).parts_of_step == parts
