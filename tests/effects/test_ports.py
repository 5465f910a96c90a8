"""Ports: every effect sits on one, and dry friction opposes motion."""

import jax.numpy as jnp
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.effects import ports
from rwjax.effects.effect import Effect
from rwjax.effects.library import BY_NAME, EFFECTS, LIBRARY, UNLISTED
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import AxisDry, WheelDry
from rwjax.plant.dry_friction import friction_level
from tests.effects.rigs import motion

PORTS = {
    ports.AxisTorque: "axis",
    ports.AxisDry: "axis",
    ports.AxisElastic: "axis",
    ports.Inertia: "axis",
    ports.Coupling: "axis",
    ports.WheelTorque: "wheel",
    ports.WheelDry: "wheel",
    ports.MotorTorque: "motor",
    ports.CurrentLimit: "motor",
    ports.Winding: "motor",
    ports.CommandMap: "drive",
    ports.CommandDelay: "drive",
    ports.CommandFilter: "drive",
    ports.Supply: "drive",
    ports.Encoder: "sensor",
    ports.EncoderDelay: "sensor",
    ports.Reading: "sensor",
    ports.GoalDelay: "drive",
    ports.Clock: "sensor",
}


def middle(effect: type[Effect]) -> Effect:
    """The effect with every parameter at its first search start."""
    return effect(**{name: jnp.asarray(p.starts[0]) for name, p in parameters(effect).items()})


def test_names_are_unique_and_begin_with_the_place_of_their_port() -> None:
    assert len(BY_NAME) == len(LIBRARY) == len({effect.label for effect in LIBRARY})
    for effect in (*EFFECTS, *(law for law in UNLISTED if law.name.startswith("axis."))):
        ports = [place for port, place in PORTS.items() if issubclass(effect, port)]
        assert len(ports) == 1 and effect.name.split(".")[0] == ports[0], effect.name


@pytest.mark.parametrize("effect", [e for e in EFFECTS if issubclass(e, AxisDry | WheelDry)], ids=lambda e: e.name)
@given(speed=st.floats(-30.0, 30.0))
def test_dry_friction_never_adds_energy(effect: type, speed: float) -> None:
    m = motion(w=speed, Omega=speed)._replace(psi=jnp.asarray(speed), load=jnp.asarray(speed))
    sign = 1.0 if speed >= 0.0 else -1.0
    assert sign * float(friction_level([middle(effect)], m, sign)) * speed >= 0.0
