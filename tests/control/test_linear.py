"""The linearised plant: what stands in it for effects that no linear plant holds."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.linear import linearisation_notes, linearised
from rwjax.control.transfer import transfer
from rwjax.errors import InputError
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from tests.control.plant_texts import I, J, K, R, platform, stiff
from tests.joints import as_platform, joint
from tests.systems import wheel


def test_a_lag_of_no_time_is_none() -> None:
    lag = '[effects."drive.lag"]\nT = 0.0'
    found, plain = (transfer(linearised(parse_rig(stiff(8e-4, e)))) for e in (lag, ""))
    assert np.array_equal(found.den, plain.den) and np.array_equal(found.num, plain.num)


@pytest.mark.parametrize("b3", [0.0, 0.01])
def test_a_falling_friction_keeps_its_slope_where_its_level_is_0(b3: float) -> None:
    plant = transfer(linearised(parse_rig(platform(f"polynomial = [{b3}, -0.0026, 0.0, 0.0]"))))
    assert plant.den == pytest.approx([1.0, -0.026, 0.0], rel=1e-9)


def test_play_counts_as_closed_and_ripple_holds_nothing() -> None:
    numbers = "s = 0.3\nk = 40.0\nc = 0.2"
    play, elastic = (f'[effects."axis.{e}"]\n{numbers}' for e in ("backlash", "flexible_coupling"))
    closed, coupled = (parse_rig(platform(effects=e)) for e in (f"{play}\ng = 0.02", elastic))
    assert np.array_equal(transfer(linearised(closed)).den, transfer(linearised(coupled)).den)
    assert linearisation_notes(closed) == ("axis.backlash: the play is closed",) and linearisation_notes(coupled) == ()
    ripple = parse_rig(stiff(0.06, '[effects."wheel.cogging"]\ns = 0.01\nc = 0.0\nn = 6.0'))
    assert np.array_equal(transfer(linearised(ripple)).den, transfer(linearised(parse_rig(stiff(0.06)))).den)
    (line,) = linearisation_notes(
        parse_rig(platform("", '[effects."axis.stribeck"]\nM_c = 0.1\nM_e = 0.1\nv_s = 0.5\nn = 0.7'))
    )
    assert line.startswith("axis.stribeck: infinitely steep")


PRESLIDING = '[effects."axis.presliding"]\nM_c = 0.0\nx_s = 1e-3\nd = 0.5'


def test_friction_that_builds_up_over_a_displacement_keeps_its_slope_and_not_its_damping() -> None:
    falling = "polynomial = [0.01, -0.0026, 0.0, 0.0]"
    elastic = parse_rig(platform(falling, PRESLIDING))
    plant = transfer(linearised(elastic))
    assert plant.den == pytest.approx([1.0, -0.026, 0.0], rel=1e-9)
    # and so it is once the axis slides: the plant's rates with the friction built up
    structure = structure_of(elastic)
    rates = one_axis_plant_of(structure, jnp.asarray(theta_of(elastic, structure))).field
    w = structure.states.index("w")
    built_up = (1.0,) * len(structure.states[2:])
    slid = [
        float(rates(jnp.zeros(()), tuple(map(jnp.asarray, (0.0, v, *built_up))), jnp.ones(()))[w]) for v in (0.1, 0.2)
    ]
    assert (slid[1] - slid[0]) / 0.1 == pytest.approx(-plant.den[1], rel=1e-9)
    assert linearisation_notes(elastic) == ("axis.presliding: sliding, all its friction built up",)


@pytest.mark.parametrize("angle", [0.5, 1.5, -0.5, 2.5])
def test_at_its_summit_a_load_is_no_spring(angle: float) -> None:
    gravity = parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n[wheel]\ninertia = {J}\n[axis]\n'
        f"inertia = {I}\n[axis.friction]\nviscous = 0.002\n[axis.gravity]\ntorque = 0.3"
    )
    found = transfer(linearised(gravity, angle * np.pi))
    assert found.hidden == (0.0,)
    assert found.den == pytest.approx(np.polymul([1.0, K**2 / (R * J)], [1.0, 0.002 / I]), rel=1e-12)
    assert transfer(linearised(gravity, angle * np.pi + 1e-6)).hidden == ()


@pytest.mark.parametrize(("n", "slope"), [(1.0, -0.06 / 0.3), (1.1, 0.0), (1.5, 0.0), (2.0, 0.0), (3.0, 0.0)])
def test_the_slope_of_stribeck_friction_at_standstill_is_its_limit(n: float, slope: float) -> None:
    falling = f'[effects."axis.stribeck"]\nM_c = 0.1\nM_e = 0.06\nv_s = 0.3\nn = {n}'
    rig = parse_rig(platform("viscous = 0.02", falling))
    assert transfer(linearised(rig)).den == pytest.approx([1.0, 0.2 + slope / 0.1, 0.0], rel=1e-9)
    level = ("axis.stribeck: taken as constant at standstill, though its level falls at once beside it",)
    assert linearisation_notes(rig) == (level if 1.0 < n < 2.0 else ())


def test_an_infinite_slope_is_taken_where_it_is_said_to_be() -> None:
    n, v_s, w = 0.7, 0.3, 1e-6
    steep = parse_rig(
        platform("viscous = 0.02", f'[effects."axis.stribeck"]\nM_c = 0.1\nM_e = 0.06\nv_s = {v_s}\nn = {n}')
    )
    slope = -0.06 * n / v_s * (w / v_s) ** (n - 1.0) * np.exp(-((w / v_s) ** n))
    assert transfer(linearised(steep)).den == pytest.approx([1.0, 0.2 + slope / 0.1, 0.0], rel=1e-9)


@pytest.mark.parametrize(
    ("effect", "numbers", "words"),
    [
        ("axis.friction_drift", "d = 0.3\nB = 0.0\ntau = 5.0", "as at the first instant"),
        ("axis.periodic_torque", "s = 0.01\nc = 0.0\nomega = 2.0", "left out"),
        ("drive.curvature", "c = 0.1", "the gain is that of small commands"),
        ("drive.saturation", "u_m = 6.0\nn = 3.0", "the gain is that of small commands"),
    ],
)
def test_what_changes_with_time_or_command_is_named(effect: str, numbers: str, words: str) -> None:
    (line,) = linearisation_notes(parse_rig(platform(effects=f'[effects."{effect}"]\n{numbers}')))
    assert line.startswith(f"{effect}: ") and line.endswith(words)


def test_a_cold_winding_is_named_and_a_sharp_limit_is_not() -> None:
    heats = stiff(0.06, '[effects."motor.heating"]\nc = 0.02\ntau = 30.0')
    assert linearisation_notes(parse_rig(heats)) == ("motor.heating: as at the first instant, the winding cold",)
    assert linearisation_notes(parse_rig(platform(effects='[effects."drive.saturation"]\nu_m = 6.0'))) == ()


def test_a_power_of_the_command_is_left_out_and_named() -> None:
    bent = parse_rig(platform(effects='[effects."drive.curvature"]\nc = 0.0\np = 0.2\nu_1 = 3.0'))
    assert np.array_equal(linearised(bent).B, linearised(parse_rig(platform())).B)
    assert linearisation_notes(bent) == (
        "drive.curvature: its power is left out, the gain is that of small commands without it",
    )


def test_drag_has_no_slope_at_standstill() -> None:
    drag = '[effects."axis.quadratic_drag"]\nc = 0.05\np = 1.3'
    assert transfer(linearised(parse_rig(platform("coulomb = 0.1", drag)))).den == pytest.approx(
        [1.0, 0.0, 0.0], abs=0.0
    )


def test_a_rig_without_an_axis_is_refused() -> None:
    with pytest.raises(InputError, match="no axis"):
        linearised(wheel())


def test_a_joint_is_the_platform_of_its_gain_and_its_back_emf() -> None:
    """Gravity of 0.3 N m linearised at 0.4 rad, 0.2 rad from its own zero: a stiffness of 0.3 cos 0.6 on 0.02 kg m2."""
    rig = joint(axis__gravity__torque=0.3, axis__gravity__angle=0.2, axis__friction__coulomb=0.05)
    found, same = (transfer(linearised(r, 0.4)) for r in (rig, as_platform(rig)))
    assert found.den == pytest.approx([1.0, (0.02 + 2.0) / 0.02, 0.3 * np.cos(0.6) / 0.02], rel=1e-9)
    assert found.num == pytest.approx([1.0 / 0.02], rel=1e-9)
    np.testing.assert_allclose(np.append(found.num, found.den), np.append(same.num, same.den), rtol=1e-12)


def test_a_joint_with_inductance_is_of_third_order() -> None:
    found = transfer(linearised(joint(motor__inductance=2e-3)))
    I, b, NK, R, L = 0.02, 0.02, 2.0, 2.0, 2e-3
    assert found.num == pytest.approx([NK / (I * L)], rel=1e-9)
    assert found.den == pytest.approx([1.0, R / L + b / I, (R * b + NK**2) / (I * L), 0.0], rel=1e-9)


def test_what_turns_volts_into_torque_is_asked_for() -> None:
    with pytest.raises(InputError, match="driven by voltage, a joint needs `motor.resistance` in the rig file"):
        linearised(joint(motor__resistance=0.0))
