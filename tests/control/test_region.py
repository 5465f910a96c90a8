"""Gain regions: against roots of the same polynomials, the thesis's counts, the D-partition and the limit of fast sampling."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax import parse_rig
from rwjax.control.boundary import boundary, real_boundary
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.linear import linearised, left_out_effects
from rwjax.control.loop_polynomial import pd_loop, pid_loop
from rwjax.control.polynomials import disc, hurwitz, mapped, shift, within_sector
from rwjax.control.region import pd_region
from rwjax.control.sampled_loop import sampled_loop, sampled_pid_loop
from rwjax.control.stability import share_of_plants, stable, stable_sampled
from rwjax.control.transfer import Transfer, transfer
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, reaction, wheel

J, b, R, L, K, I = 1.24e-4, 4.07e-6, 0.83, 0.1, 0.0182, 0.0432 + 0.3 * 0.145**2
SLOPE = -5.2491e-2  # 1/s, b2/I of listing A.4
THESIS = parse_rig(
    f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\ninductance = {L}\nfriction = {b}\n[wheel]\n'
    f"inertia = {J}\n[axis]\ninertia = {I}\n[axis.friction]\n"
    f"polynomial = [{0.3757 * I}, {SLOPE * I}, {0.020461 * I}, {-6.8912e-4 * I}]"
)
GRID = np.linspace(0.0, 100.0, 101)
CORNER = 1e-3  # roots nearer than this to a limit, several of them together, are not told from it

real = st.floats(-3.0, 2.0)
pair = st.tuples(st.floats(-3.0, 2.0), st.floats(0.01, 5.0))


def polynomial(reals: list[float], pairs: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    roots = np.array([*map(complex, reals), *(x + s * 1j * y for x, y in pairs for s in (1.0, -1.0))])
    return np.real(np.poly(roots)), roots


@given(st.lists(real, min_size=1, max_size=3), st.lists(pair, max_size=2), st.floats(0.0, 1.0), st.floats(0.05, 0.95))
def test_roots_are_where_the_tests_say(
    reals: list[float], pairs: list[tuple[float, float]], sigma: float, damping: float
) -> None:
    c, roots = polynomial(reals, pairs)
    order = len(c) - 1
    for distance, found in (
        (-roots.real, hurwitz([*jnp.asarray(c)])),
        (-roots.real - sigma, hurwitz(mapped(shift(order, sigma), [*jnp.asarray(c)]))),
        (-roots.real - damping * np.abs(roots), within_sector([*jnp.asarray(c)], damping)),
        (1.0 + sigma - np.abs(1.0 + roots), hurwitz(mapped(disc(order, 1.0 + sigma), [*jnp.asarray(c)]))),
    ):
        if np.min(np.abs(distance)) > CORNER:
            assert bool(found) == bool(np.all(distance > 0.0))


def test_the_plant_of_the_thesis_comes_out_of_the_rig() -> None:
    plant = transfer(linearised(THESIS))
    den = np.polymul([J * L, J * R + b * L, b * R + K**2], [1.0, SLOPE])
    assert plant.den == pytest.approx(den / den[0], rel=1e-10)
    assert plant.num == pytest.approx([-K / (L * I)], rel=1e-10)
    assert plant.hidden == (0.0,) and np.all(plant.restoring > 0.0)


def test_the_region_of_the_thesis() -> None:
    found = pd_region(THESIS, GRID, GRID, 0.5)
    assert found.stable.sum() == 7001
    loop = pd_loop(found.plant)
    by_roots = [[np.all(loop.poles(kp, kd).real < -0.5) for kd in GRID[::5]] for kp in GRID[::5]]
    assert np.array_equal(found.stable[::5, ::5], by_roots)


@pytest.mark.parametrize("damping", [0.2, 0.4])
def test_damped_pairs_are_those_whose_roots_are_damped(damping: float) -> None:
    loop = pd_loop(transfer(linearised(THESIS)))
    found = stable(loop, GRID[::7, None], GRID[None, ::7], sigma=0.5, damping=damping)
    for i, kp in enumerate(GRID[::7]):
        for j, kd in enumerate(GRID[::7]):
            poles = loop.poles(kp, kd)
            assert found[i, j] == bool(np.all(poles.real < -0.5) and np.all(-poles.real > damping * np.abs(poles)))
    assert 5 < found.sum() < found.size - 50


def test_the_polynomial_as_the_thesis_prints_it() -> None:
    # R b2/(I L) stands in the coefficient of s^2; it belongs to s
    motor = (R * b + K**2) / (J * L)
    den = np.array([1.0, R / L + b / J + SLOPE + SLOPE * R / L, motor + SLOPE * b / J, SLOPE * motor])
    printed = Transfer(np.array([K / (L * I)]), den, ())
    assert stable(pd_loop(printed), GRID[:, None], GRID[None, :], sigma=0.5).sum() == 6928


@pytest.mark.parametrize("sigma", [0.0, 0.5])
@pytest.mark.parametrize("rig", [THESIS, platform(), reaction()], ids=["thesis", "platform", "reaction"])
def test_the_region_ends_on_the_curves_of_the_d_partition(rig, sigma: float) -> None:
    plant = transfer(linearised(rig))
    loop, omega = pd_loop(plant), np.geomspace(0.1, 20.0, 30)
    beside, flips = np.array([1.0 - 1e-9, 1.0 + 1e-9]), 0

    def others_hold(kp: float, kd: float, crossing: complex) -> bool:
        poles = loop.poles(kp, kd)
        assert np.min(np.abs(poles - crossing)) < 1e-8 * max(1.0, abs(crossing))
        for gone in {crossing, crossing.conjugate()}:
            poles = np.delete(poles, np.argmin(np.abs(poles - gone)))
        return bool(np.all(poles.real < -sigma - 1e-3))

    for w, (kp, kd) in zip(omega, boundary(plant, omega, sigma).T, strict=True):
        inside = stable(loop, np.full(2, kp), kd * beside, sigma=sigma)
        if others_hold(kp, kd, complex(-sigma, w)):
            assert inside[0] != inside[1], (kp, kd)
            flips += 1
        else:
            assert not inside.any()
    for kd in np.linspace(0.0, 30.0, 11):
        kp = float(real_boundary(plant, np.array([kd]), sigma)[0])
        beside_kp = kp * beside if abs(kp) > 1e-6 else kp + np.array([-1e-9, 1e-9])
        inside = stable(loop, beside_kp, np.full(2, kd), sigma=sigma)
        if others_hold(kp, kd, complex(-sigma, 0.0)):
            assert inside[0] != inside[1], (kp, kd)
            flips += 1
        else:
            assert not inside.any()
    assert flips > 10


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


def test_sampling_fast_is_not_sampling() -> None:
    plant = transfer(linearised(THESIS))
    slow = np.sort_complex(pd_loop(plant).poles(40.0, 10.0))
    error = []
    for h in (1e-2, 1e-3, 1e-4):
        z = 1.0 + sampled_loop(plant, h).poles(40.0, 10.0)
        s = np.sort_complex(np.log(z[np.abs(z) > 0.05]) / h)
        error.append(np.max(np.abs(s - slow)))
    assert error[1] == pytest.approx(0.1 * error[0], rel=0.2) and error[2] == pytest.approx(0.1 * error[1], rel=0.2)


@pytest.mark.parametrize("late", [0.0, 0.004, 0.01, 0.013, 0.02])
def test_a_sampled_loop_is_what_the_recursion_does(late: float) -> None:
    """The same loop step by step: exact motion of a double integrator under the held, late command."""
    rig = parse_rig('kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1')
    plant, h = transfer(linearised(rig)), 0.01
    loop, gain = sampled_loop(plant, h, late), 4.0
    whole, part = int(late // h), late % h
    for kp, kd in ((3.0, 2.0), (30.0, 1.0), (5.0, 60.0)):
        x, v, before, held = 1.0, 0.0, 1.0, [0.0] * 4
        size = []
        for _ in range(4000):
            held = [-(kp * x + kd * (x - before) / h), *held[:3]]
            before = x
            for u, time in ((held[whole + 1], part), (held[whole], h - part)):
                x, v = x + v * time + 0.5 * gain * u * time**2, v + gain * u * time
            size.append(abs(x))
            if abs(x) > 1e9:
                break
        largest = np.max(np.abs(1.0 + loop.poles(kp, kd)))
        assert (largest < 1.0) == (size[-1] < 1.0)
        found = stable_sampled(loop, np.array([kp]), np.array([kd]))
        assert bool(found[0]) == (largest < 1.0)


def test_a_filtered_sampled_loop_with_an_integral_is_what_runs() -> None:
    rig = parse_rig('kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02')
    law = Controller(6.0, ki=2.0, kd=2.0, filter_time=0.03)
    run = np.asarray(run_rig(rig, law, np.zeros(400), LoopTiming(delay_steps=2.0), psi=0.1).angle)
    poles = 1.0 + sampled_pid_loop(transfer(linearised(rig)), 0.01, 0.005, 0.03).poles(6.0, 2.0, 2.0)
    p = np.poly(poles).real  # the angle's recursion
    rest = [np.dot(p, run[k - len(p) + 1 : k + 1][::-1]) for k in range(100, 400)]
    assert np.max(np.abs(rest)) < 1e-9 < np.max(np.abs(run[100:]))


def test_an_integral_part_moves_every_pole() -> None:
    plant = transfer(linearised(THESIS))
    loop, rng = pid_loop(plant), np.random.default_rng(3)
    gains = rng.uniform(0.0, (60.0, 200.0, 20.0), (200, 3))
    by_roots = [np.all(loop.poles(*g).real < 0.0) for g in gains]
    assert np.array_equal(stable(loop, *gains.T), by_roots) and 10 < sum(by_roots) < 190


def test_a_rig_without_an_axis_is_refused() -> None:
    with pytest.raises(InputError, match="no axis"):
        linearised(wheel())


def test_the_share_of_plants_is_what_each_of_them_says() -> None:
    rng = np.random.default_rng(5)
    structure = structure_of(THESIS)
    thetas = theta_of(THESIS, structure) * np.exp(rng.normal(0.0, 0.2, (40, len(structure.names))))
    plants = transfer(linearised(THESIS, thetas=thetas))
    kp, kd = GRID[::4], GRID[::7]
    one_by_one = []
    for num, den in zip(plants.num, plants.den, strict=True):
        one_by_one.append(stable(pd_loop(Transfer(num, den, ())), kp[:, None], kd[None, :], sigma=0.5))
    assert np.array_equal(share_of_plants(plants, kp, kd, 0.5), np.mean(one_by_one, axis=0))
    single = transfer(linearised(THESIS.with_values(dict(zip(structure.names, thetas[7], strict=True)))))
    assert plants.den[7] == pytest.approx(single.den, rel=1e-9) and plants.num[7] == pytest.approx(single.num, rel=1e-9)


def test_many_gains_in_blocks_are_those_of_one_block() -> None:
    plants = transfer(linearised(THESIS, thetas=theta_of(THESIS, structure_of(THESIS))[None]))
    wide = np.linspace(0.0, 100.0, 151)
    found = share_of_plants(plants, wide, wide, 0.5)
    assert np.array_equal(found, pd_region(THESIS, wide, wide, 0.5).stable)
