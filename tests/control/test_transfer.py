"""Transfer functions against closed forms: motor, load, spring, drive and friction."""

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.boundary import real_boundary
from rwjax.control.linear import Linear, left_out_effects, linearised
from rwjax.control.transfer import Transfer, characteristic, transfer
from rwjax.errors import InputError
from tests.control import thesis_axis as thesis
from tests.control.plant_texts import I, J, K, R, b, platform, stiff


def test_the_plant_of_the_thesis_comes_out_of_the_rig() -> None:
    J, L, R, b, K = thesis.J, thesis.L, thesis.R, thesis.b, thesis.K
    plant = transfer(linearised(thesis.THESIS))
    den = np.polymul([J * L, J * R + b * L, b * R + K**2], [1.0, thesis.SLOPE])
    assert plant.den == pytest.approx(den / den[0], rel=1e-10)
    assert plant.num == pytest.approx([-K / (L * thesis.I)], rel=1e-10)
    assert plant.hidden == (0.0,) and np.all(plant.restoring > 0.0)


def test_a_held_load_is_a_spring_or_none() -> None:
    rig = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02\n[axis.gravity]\n'
        "torque = 0.3\nangle = 0.2"
    )
    for angle in (0.0, 2.5):
        den = transfer(linearised(rig, angle)).den
        assert den == pytest.approx([1.0, 0.2, 3.0 * np.cos(angle + 0.2)], rel=1e-12)


def test_a_wheel_under_a_spring_keeps_its_zero_and_hides_nothing() -> None:
    spring = parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n[wheel]\ninertia = {J}\n[axis]\ninertia = {I}\n'
        '[effects."axis.spring"]\nk = 0.2\nT_0 = 0.0'
    )
    plant = transfer(linearised(spring))
    assert plant.hidden == () and len(plant.den) == 4
    assert plant.num[-1] == 0.0 and plant.num[0] < 0.0  # a constant command holds no constant torque
    with np.errstate(all="raise"):
        assert np.isnan(real_boundary(plant, np.array([1.0]))).all()  # hence no pole comes to 0


def test_drives_and_friction_in_the_loop() -> None:
    def of(effects: str, friction: str = "viscous = 0.02") -> Transfer:
        text = f'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\n{friction}\n{effects}'
        rig = parse_rig(text)
        assert left_out_effects(rig) == (("drive.delay",) if "delay" in effects else ())
        return transfer(linearised(rig))

    plain = of("")
    assert plain.den == pytest.approx([1.0, 0.2, 0.0], abs=1e-12)
    lag = of('[effects."drive.lag"]\nT = 0.1')
    assert lag.den == pytest.approx(np.polymul(plain.den, [1.0, 10.0]), abs=1e-12)
    two = of('[effects."drive.lag"]\nT = 0.1\nq = 0.4')
    assert two.den == pytest.approx(np.polymul(lag.den, [1.0, 25.0]), abs=1e-9)
    dead = '[effects."drive.deadzone"]\nu_0 = 0.3\n[effects."drive.delay"]\ntau = 0.02\n[effects."axis.coulomb"]\nM_c = 0.1'
    assert of(dead).den == pytest.approx(plain.den, abs=1e-12)  # fed forward
    falling = of('[effects."axis.stribeck"]\nM_c = 0.1\nM_e = 0.1\nv_s = 0.5\nn = 1.0')
    assert falling.den == pytest.approx([1.0, 0.2 - 0.1 / 0.5 / 0.1, 0.0], rel=1e-5)  # the slope beside standstill


@pytest.mark.parametrize("L", [0.06, 8e-4, 1e-4, 4e-5])
def test_a_quick_current_leaves_the_transfer_function_as_it_is(L: float) -> None:
    plant = transfer(linearised(parse_rig(stiff(L))))
    motor = np.array([1.0, R / L + b / J, (R * b + K**2) / (J * L)])
    assert plant.den == pytest.approx(np.polymul(motor, [1.0, 1e-4 / I]), rel=1e-12)
    assert plant.num == pytest.approx([-K / (L * I)], rel=1e-12) and plant.hidden == (0.0,)


def test_a_stiff_coupling_turns_as_one() -> None:
    rigid = transfer(linearised(parse_rig(platform())))
    stiffest = '[effects."axis.flexible_coupling"]\ns = 0.3\nk = 1e6\nc = 20.0'
    plant = transfer(linearised(parse_rig(platform(effects=stiffest))))
    s = 1j * np.geomspace(0.01, 100.0, 30)  # resonance: 7000 rad/s
    both = [np.polyval(p.num, s) / np.polyval(p.den, s) for p in (plant, rigid)]
    assert both[0] == pytest.approx(both[1], rel=1e-3)


def test_coefficients_are_those_of_the_eigenvalues() -> None:
    A = np.random.default_rng(1).normal(size=(20, 6, 6))
    den, size = characteristic(A)
    assert den == pytest.approx(np.array([np.poly(a) for a in A]), rel=1e-9, abs=1e-9)
    assert np.all(size >= np.abs(den) * (1.0 - 1e-12))


def test_each_of_many_plants_is_turned_forward_whatever_zeros_another_has() -> None:
    many = Transfer(np.array([[-1.0, 2.0], [0.0, -3.0], [0.5, 0.0]]), np.tile([1.0, 0.1, 0.2], (3, 1)), ())
    assert np.array_equal(many.restoring, [[1.0, -2.0], [0.0, 3.0], [0.5, 0.0]])
    assert np.array_equal(many.each()[1].restoring, [0.0, 3.0])


def test_what_rounding_covers_is_said() -> None:
    lost = Linear(np.diag([1e6, 1e6]), np.array([1.0, -1.0 - 1e-16]), np.ones(2))
    with pytest.raises(InputError, match="too far apart for a transfer function"):
        transfer(lost)
