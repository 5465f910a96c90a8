"""Effects on a rig with two axes: names of each half in all that an effect says."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects.effect import FittedRig
from rwjax.effects.library import BY_NAME, EFFECTS, special_cases
from rwjax.effects.parameter import parameters
from rwjax.effects.two_axis import NOT_HERE, Misalignment, on_each_half
from rwjax.kinds import NUMBERS


def test_each_half_has_every_effect_once_yaw_first() -> None:
    found, mine = on_each_half(EFFECTS), [e for e in EFFECTS if not issubclass(e, NOT_HERE)]
    assert len(found) == 2 * len(mine)
    for effect, yaw, pitch in zip(mine, found, found[len(mine) :], strict=False):
        for half in (yaw, pitch):
            assert issubclass(half, effect) and parameters(half) == parameters(effect)
        assert yaw.name != pitch.name


@pytest.mark.parametrize(("axis", "wheel", "motor"), [("yaw", "wheel_1", "motor_1"), ("pitch", "wheel_2", "motor_2")])
def test_names_that_an_effect_gives_are_those_of_its_half(axis: str, wheel: str, motor: str) -> None:
    assert special_cases(f"{axis}.stribeck") == {f"{axis}.coulomb"} == {BY_NAME[f"{axis}.presliding"].includes}
    assert special_cases(f"{axis}.spring") == {f"{axis}.bias_torque"} and special_cases(f"{wheel}.coulomb") == set()
    assert BY_NAME[f"{axis}.coulomb"].modelled_by[0] == f"{axis}.friction.coulomb" in NUMBERS
    assert BY_NAME[f"drive_{motor[-1]}.supply_sag"].like_larger == (f"{motor}.resistance",)
    assert BY_NAME[f"{axis}.bias_torque"].label.endswith(f"({axis})")


def test_what_is_the_same_thing_lies_on_the_same_half() -> None:
    fitted = FittedRig(
        "two_axis", frozenset({"pitch.bias_torque"}), {"pitch.bias_torque.T": 0.1, "sensor.clock.e": 0.0}
    )
    assert BY_NAME["pitch.asymmetric_friction"].same_as(fitted) == ("pitch.bias_torque",)
    assert BY_NAME["yaw.asymmetric_friction"].same_as(fitted) == ("yaw.bias_torque",)
    alike = fitted._replace(kind="platform", names=frozenset({"drive_2.deadzone", "drive_2.curvature"}))
    alike = alike._replace(numbers={f"drive_2.curvature.{n}": v for n, v in (("c", -0.1), ("p", 0.0), ("u_1", 3.0))})
    assert BY_NAME["pitch.bias_torque"].same_as(alike) == () and BY_NAME["yaw.bias_torque"].same_as(alike) != ()
    assert BY_NAME["drive_2.curvature"].same_as(alike) == ("drive_2.supply_sag",)


def test_a_misaligned_encoder_reads_a_part_of_the_pitch() -> None:
    reading = Misalignment(e=jnp.asarray(0.1)).read(jnp.asarray(1.0), jnp.asarray(-2.0))
    assert np.isclose(float(reading), 0.8, rtol=1e-15)
