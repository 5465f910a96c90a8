"""What a rig file models by its own numbers, as effects."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects.axis import Imbalance
from rwjax.effects.ports import AxisDry, AxisTorque
from rwjax.effects.rig_terms import of_rig_numbers
from rwjax.plant.dry_friction import friction_level
from tests.effects.rigs import motion


def resisting(numbers: dict[str, float], w: float) -> float:
    """Torque [N m] against a turning axis."""
    effects = of_rig_numbers({name: jnp.asarray(value) for name, value in numbers.items()})
    m, way = motion(w=w), 1.0 if w > 0.0 else -1.0
    dry = float(friction_level([e for e in effects if isinstance(e, AxisDry)], m, way))
    return way * dry - sum(float(e.torque(m)) for e in effects if not isinstance(e, AxisDry))


@pytest.mark.parametrize("w", [-3.0, -0.1, 0.1, 3.0])
def test_friction_is_that_of_the_rig_file(w: float) -> None:
    stribeck = {
        "axis.friction.viscous": 0.02,
        "axis.friction.coulomb": 0.05,
        "axis.friction.static": 0.09,
        "axis.friction.stribeck_velocity": 0.2,
    }
    level = 0.05 + 0.04 * np.exp(-((w / 0.2) ** 2))
    assert resisting(stribeck, w) == pytest.approx(np.sign(w) * level + 0.02 * w, rel=1e-14)
    cubic = dict(zip(("b3", "b2", "b1", "b0"), (0.3, -0.05, 0.02, -0.001), strict=True))
    polynomial = {f"axis.friction.{name}": value for name, value in cubic.items()}
    exact = np.polyval([-0.001, 0.02, -0.05, 0.3], abs(w)) * np.sign(w)
    assert resisting(polynomial, w) == pytest.approx(exact, rel=1e-14)


def test_a_load_turns_towards_its_rest() -> None:
    at = motion()._replace(psi=jnp.asarray(0.5))
    assert float(load(0.3, 0.1).torque(at)) == pytest.approx(-0.3 * np.sin(0.6), rel=1e-15)


@pytest.mark.parametrize(("torque", "angle"), [(0.3, 0.1), (0.42, 0.1), (0.3, -0.7), (0.1, 2.5)])
def test_any_error_of_a_known_load_is_an_imbalance(torque: float, angle: float) -> None:
    known, true = (load(*numbers) for numbers in ((0.3, 0.1), (torque, angle)))
    s = torque * np.cos(angle) - 0.3 * np.cos(0.1)
    c = torque * np.sin(angle) - 0.3 * np.sin(0.1)
    imbalance = Imbalance(s=jnp.asarray(s), c=jnp.asarray(c))
    for psi in np.linspace(-4.0, 4.0, 9):
        at = motion()._replace(psi=jnp.asarray(psi))
        both = float(known.torque(at) + imbalance.torque(at))
        assert both == pytest.approx(float(true.torque(at)), abs=1e-15)


def load(torque: float, angle: float) -> AxisTorque:
    """The load of a rig file."""
    numbers = {"axis.gravity.torque": jnp.asarray(torque), "axis.gravity.angle": jnp.asarray(angle)}
    (gravity,) = of_rig_numbers(numbers)
    return gravity


def test_a_rig_without_such_numbers_has_no_such_terms() -> None:
    assert of_rig_numbers({"axis.inertia": jnp.asarray(1.0)}) == []
    assert [e.name for e in of_rig_numbers({"axis.friction.coulomb": jnp.asarray(1.0)})] == ["axis.coulomb"]
