"""The plant without feedback: the delay that it waits, stick and slide."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.open_loop import command_delay
from rwjax.control.slew import slew
from rwjax.errors import InputError
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from tests.control.current_limited_rig import LIMITS, I, J, K, R


@pytest.mark.parametrize(
    ("held", "effect", "spin", "words"),
    [
        pytest.param("[axis.gravity]\ntorque = 0.002\nangle = 0.5", "", 0.0, "the axis turns", marks=pytest.mark.slow),
        ("", '[effects."axis.bias_torque"]\nT = 0.02', 0.0, "the axis turns"),
        ("", '[effects."drive.bias"]\nu_b = 0.1', 0.0, "the wheel changes its rate"),
        ("", '[effects."wheel.coulomb"]\nM_c = 1e-4', 50.0, ""),
        ("", '[effects."drive.bias"]\nu_b = 0.1', 50.0, ""),
        ("", '[effects."motor.heating"]\nc = 0.5\ntau = 30.0\n[effects."wheel.coulomb"]\nM_c = 1e-3', 50.0, ""),
        (
            "",
            '[effects."axis.periodic_torque"]\ns = 0.001\nc = 0.0\nomega = 3.0',
            0.0,
            "`axis.periodic_torque` changes",
        ),
        ("", '[effects."axis.bias_torque"]\nT = 0.005', 50.0, ""),
    ],
)
def test_a_delay_counts_only_where_the_rig_waits(held: str, effect: str, spin: float, words: str) -> None:
    friction = "viscous = 0.001" if held else "coulomb = 0.01"
    late = parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n[wheel]\ninertia = {J}\n[axis]\ninertia = {I}\n'
        f'[axis.friction]\n{friction}\n{held}\n{effect}\n[effects."drive.delay"]\ntau = 0.2'
    )
    if not words:
        assert command_delay(late, spin) == 0.2
        return
    with pytest.raises(InputError, match=f"^{words}.* the drive's delay of 0.2 s; leave the delay out$"):
        slew(late, np.radians(5.0), LIMITS, spin)


@pytest.mark.slow
def test_a_sliding_axis_goes_on_through_rest_where_a_real_one_sticks() -> None:
    text = 'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\ncoulomb = 0.05'
    structure = structure_of(parse_rig(text))
    plant, h, zero = (
        plant_of(structure, jnp.asarray(theta_of(parse_rig(text), structure))),
        jnp.asarray(0.01),
        jnp.zeros(()),
    )
    p = EXPONENTIAL_STEP.prepare(plant, h)
    slid = stuck = (zero, jnp.asarray(0.1))  # psi, w; friction slows by 0.5 rad/s2
    for _ in range(50):
        slid = EXPONENTIAL_STEP.slide(plant, p, zero, slid, zero, h, jnp.ones(()))
        stuck = EXPONENTIAL_STEP.step(plant, p, zero, stuck, zero, h)
    t = 0.5
    assert [float(v) for v in slid] == pytest.approx([0.1 * t - 0.25 * t**2, 0.1 - 0.5 * t])
    assert [float(v) for v in stuck] == pytest.approx([0.01, 0.0])
