"""A wheel that turns steadily: nothing of it changes under the command that keeps it."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax import Rig, RigError, parse_rig
from rwjax.control.open_loop import open_loop, steady_state
from rwjax.control.steady_wheel import steady_wheel
from rwjax.plant.assemble import one_axis_plant_of
from tests.control.current_limited_rig import I, J, K, R

B, C, TAU, RHO = 2e-6, 0.02, 30.0, 0.01
SAG = f'[effects."drive.supply_sag"]\nrho = {RHO}\nm = 0.5\ntau = 2.0\n'
HEATS = f'[effects."motor.heating"]\nc = {C}\ntau = {TAU}\n'
RUBS = '[effects."wheel.coulomb"]\nM_c = 0.012\n'


def rig(effects: str, inductance: float = 0.0) -> Rig:
    """A reaction wheel on an axis that dry friction holds."""
    return parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\nfriction = {B}\ninductance = {inductance}\n'
        f"[wheel]\ninertia = {J}\n[axis]\ninertia = {I}\n[axis.friction]\ncoulomb = 0.1\n{effects}"
    )


@pytest.mark.parametrize("inductance", [0.0, 5e-3])
@pytest.mark.parametrize("spin", [200.0, -200.0])
def test_under_its_command_no_rate_of_a_warm_winding_behind_a_sagging_supply_is_left(
    inductance: float, spin: float
) -> None:
    structure, theta, state, command = steady_wheel(rig(SAG + HEATS + RUBS, inductance), spin)
    plant, x = one_axis_plant_of(structure, theta), tuple(state)
    moving = plant.with_friction(jnp.zeros(()), x, plant.act(jnp.asarray(command)), x).rates
    rates = dict(zip(structure.states, map(float, moving), strict=True))
    assert rates.pop("theta") == spin and np.max(np.abs([*rates.values()])) < 1e-9
    found = dict(zip(structure.states, map(float, state), strict=True))
    i = (B * abs(spin) + 0.012) / K
    q = C * i**2 * TAU / (1.0 - C * i**2 * TAU)
    volts = K * abs(spin) + R * (1.0 + q) * i
    assert found["motor.heating:q"] == pytest.approx(q, rel=1e-9)
    drawn = i if inductance else (abs(command) - K * abs(spin)) / (R * (1.0 + q))  # at once: that of the voltage before
    assert found["drive.supply_sag:v"] == pytest.approx(abs(command) * drawn, rel=1e-9)
    assert abs(command) * (1.0 - RHO * abs(command) * drawn) == pytest.approx(volts, rel=1e-9)


@pytest.mark.parametrize(
    "effects",
    [
        HEATS + RUBS,
        SAG,
        '[effects."drive.deadzone"]\nu_0 = 0.4\n',
        '[effects."axis.presliding"]\nM_c = 0.02\nx_s = 0.01\n' + RUBS,
    ],
    ids=["warm", "sagging", "dead zone", "presliding"],
)
def test_the_wheel_goes_on_as_it_turns(effects: str) -> None:
    structure, theta, state, command = steady_wheel(rig(effects), 100.0)
    seen = open_loop(structure, theta, jnp.full(50, command), 2.0, state)
    assert np.asarray(seen.wheel) == pytest.approx(100.0, rel=1e-9)


def test_a_wheel_that_stands_does_so_without_a_command() -> None:
    *_, state, command = steady_wheel(rig(SAG + HEATS + RUBS, 5e-3))
    assert command == 0.0 and not np.any(state)


@pytest.mark.parametrize(
    ("effects", "why"),
    [
        (HEATS.replace(f"c = {C}", "c = 1.0") + RUBS, "motor.heating may not settle there"),
        (SAG.replace("0.01", "1.0") + RUBS, "drive.supply_sag may not settle there"),
        ('[effects."motor.current_limit"]\ni_m = 0.1\n' + RUBS, "its motor does not give what friction takes there"),
    ],
    ids=["warms without end", "sags away", "current limit"],
)
def test_a_rate_that_no_command_keeps_is_one_line(effects: str, why: str) -> None:
    said = rf"^no command keeps the wheel at 1909.86 1/min \(200 rad/s\): {why}; take a lower rate, or check these numbers$"
    with pytest.raises(RigError, match=said):
        steady_state(rig(effects), 200.0)
