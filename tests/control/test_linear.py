"""Transfer functions: stiff plants against their closed form, and what stands for effects that they cannot hold."""

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.linear import Linear, characteristic, linearised, taken_as, transfer
from rwjax.errors import InputError

K, R, J, I, b = 0.0216, 36.3, 1.24e-4, 5e-4, 4e-6


def stiff(inductance: float, effects: str = "") -> str:
    return (
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\ninductance = {inductance}\nfriction = {b}\n'
        f"[wheel]\ninertia = {J}\n[axis]\ninertia = {I}\n[axis.friction]\nviscous = 1e-4\n{effects}"
    )


def platform(friction: str = "viscous = 0.02", effects: str = "") -> str:
    return f'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\n{friction}\n{effects}'


@pytest.mark.parametrize("L", [0.06, 8e-4, 1e-6, 1e-9])
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


def test_a_lag_of_no_time_is_none() -> None:
    lag = '[effects."drive.lag"]\nT = 0.0'
    found, plain = (transfer(linearised(parse_rig(stiff(8e-4, e)))) for e in (lag, ""))
    assert np.array_equal(found.den, plain.den) and np.array_equal(found.num, plain.num)


def test_coefficients_are_those_of_the_eigenvalues() -> None:
    A = np.random.default_rng(1).normal(size=(20, 6, 6))
    den, size = characteristic(A)
    assert den == pytest.approx(np.array([np.poly(a) for a in A]), rel=1e-9, abs=1e-9)
    assert np.all(size >= np.abs(den) * (1.0 - 1e-12))


def test_what_rounding_covers_is_said() -> None:
    lost = Linear(("x", "y"), np.diag([1e6, 1e6]), np.array([1.0, -1.0 - 1e-16]), np.ones(2))
    with pytest.raises(InputError, match="too far apart for a transfer function"):
        transfer(lost)


@pytest.mark.parametrize("b3", [0.0, 0.01])
def test_a_falling_friction_keeps_its_slope_where_its_level_is_0(b3: float) -> None:
    plant = transfer(linearised(parse_rig(platform(f"polynomial = [{b3}, -0.0026, 0.0, 0.0]"))))
    assert plant.den == pytest.approx([1.0, -0.026, 0.0], rel=1e-9)


def test_play_counts_as_closed_and_ripple_holds_nothing() -> None:
    numbers = "s = 0.3\nk = 40.0\nc = 0.2"
    play, elastic = (f'[effects."axis.{e}"]\n{numbers}' for e in ("backlash", "flexible_coupling"))
    closed, coupled = (parse_rig(platform(effects=e)) for e in (f"{play}\ng = 0.02", elastic))
    assert np.array_equal(transfer(linearised(closed)).den, transfer(linearised(coupled)).den)
    assert taken_as(closed) == ("axis.backlash: the play is closed",) and taken_as(coupled) == ()
    ripple = parse_rig(stiff(0.06, '[effects."wheel.cogging"]\ns = 0.01\nc = 0.0\nn = 6.0'))
    assert np.array_equal(transfer(linearised(ripple)).den, transfer(linearised(parse_rig(stiff(0.06)))).den)
    (line,) = taken_as(parse_rig(platform("", '[effects."axis.stribeck"]\nM_c = 0.1\nM_e = 0.1\nv_s = 0.5\nn = 0.7')))
    assert line.startswith("axis.stribeck: infinitely steep")
