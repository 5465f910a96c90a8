"""The smooth solver: creep and sliding in closed form, the exact solver, steps that end at jumps, runs that fail."""

import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from time import perf_counter

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from rwjax import parse_rig
from rwjax.errors import InputError
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT
from rwjax.simulation.simulate import simulate
from rwjax.simulation.smooth import Smooth, default_width, method_for
from rwjax.simulation.solver import Solver
from rwjax.simulation.trajectory import Trajectory
from rwjax.simulation.windows import plant_of_run
from tests.joints import joint, servo
from tests.systems import MOTOR, platform, reaction, record, wheel
from tests.two_axes import GIMBAL, GRAVITY, TILTING, two_axis

T = np.arange(101) * 0.02
PLATFORM = platform()  # 0.1 kg m2, 0.4 N m/V, 0.05 N m dry, 0.02 N m s/rad viscous
BARE = replace(PLATFORM, counts_per_rev={})
TIGHT = Smooth(0.01, diffrax.Tsit5(), rtol=1e-9, atol=1e-11)
SINE = 0.3 * np.sin(2.0 * np.pi * T)
SQUARE = np.where(np.arange(101) // 25 % 2 == 0, 0.5, -0.5)


def on_platform(
    u: np.ndarray | float, solver: Solver = TIGHT, start: Mapping[str, float] | None = None, **friction: float
) -> Trajectory:
    """Run of the platform; every one with the same shapes, so that there is one program for each method."""
    numbers = {f"axis.friction.{name}": value for name, value in friction.items()}
    return simulate(PLATFORM, T, np.broadcast_to(u, T.shape), numbers=numbers, start=start, solver=solver)


@pytest.mark.slow
@pytest.mark.parametrize("width", [0.01, 0.001])
@pytest.mark.parametrize("share", [-0.3, 0.64, 0.9])
def test_an_axis_that_friction_would_hold_creeps_at_the_rate_of_the_closed_form(share: float, width: float) -> None:
    found = on_platform(share * 0.05 / 0.4, replace(TIGHT, width=width), viscous=0.0)
    assert found["yaw_rad_s"][-1] == pytest.approx(width * np.arctanh(share), rel=1e-5)


def test_sliding_with_viscous_friction_alone_is_the_closed_form() -> None:
    found = on_platform(0.5, start={"w": 2.0}, coulomb=0.0)
    assert found["yaw_rad_s"] == pytest.approx(10.0 - 8.0 * np.exp(-0.2 * T), rel=1e-9)
    assert found["yaw_rad"] == pytest.approx(10.0 * T - 40.0 * (1.0 - np.exp(-0.2 * T)), rel=1e-8, abs=1e-9)


def test_a_run_with_stick_and_slip_tends_to_the_exact_one_with_the_width() -> None:
    exact = on_platform(SINE, EXACT)["yaw_rad_s"]
    assert np.sum(np.abs(exact) < 1e-12) > 3  # it sticks at times
    widths = 0.01 * 0.25 ** np.arange(4)
    error = [np.max(np.abs(on_platform(SINE, replace(TIGHT, width=w))["yaw_rad_s"] - exact)) for w in widths]
    order = np.log(np.divide(error[:-1], error[1:])) / np.log(4.0)
    assert np.all(order > 0.75) and np.all(order < 1.1) and order[-1] > 0.9, order
    assert error[-1] < 1e-3


@pytest.mark.slow
def test_steps_end_where_the_command_jumps() -> None:
    """A step across a jump would miss it by what the tolerance allows; these ends are right far within it."""
    rough = replace(TIGHT, width=0.05, rtol=1e-3, atol=1e-5)
    error = [
        np.max(np.abs(on_platform(u, rough)["yaw_rad"] - on_platform(u, replace(TIGHT, width=0.05))["yaw_rad"]))
        for u in (SQUARE, np.roll(SQUARE, 3))
    ]
    assert max(error) < 2e-4, error
    every = [on_platform(SQUARE, replace(TIGHT, every_step=flag))["yaw_rad"] for flag in (False, True)]
    assert every[0] == pytest.approx(every[1], rel=1e-7, abs=1e-9)


def test_a_run_that_fails_is_infinite_from_there_on_and_costs_little() -> None:
    on_platform(0.5)  # compiles
    begin = perf_counter()
    fails = on_platform(0.5, start={"w": 1.0}, viscous=-100.0)["yaw_rad_s"]  # e-fold in a millisecond
    lost = ~np.isfinite(fails)
    assert lost.any() and not lost[:5].any() and np.all(np.diff(lost.astype(int)) >= 0)
    assert np.all(np.isposinf(fails[lost]))
    absurd = on_platform(0.5, viscous=-1e12, coulomb=1e12)
    assert not np.isfinite(absurd["yaw_rad_s"][1:]).any() and absurd["yaw_rad_s"][0] == 0.0
    assert perf_counter() - begin < 1.0


LIMITED = f'kind = "wheel"\n{MOTOR}[effects."motor.current_limit"]\ni_m = 1.5\n'
EFFECTS = """
[effects."drive.delay"]
tau = 0.013
[effects."drive.lag"]
T = 0.03
[effects."sensor.delay"]
tau = 0.007
[effects."sensor.clock"]
e = 0.02
"""
BENT = '[effects."axis.presliding"]\nM_c = 0.0\nx_s = 0.02\ns = {s}\nd = 0.1\n'
RIGS = {
    "platform": platform("viscous = 0.02"),
    "wheel with inductance": wheel(),
    "current limit": parse_rig(LIMITED),
    "late command and readings, lag, clock": platform(f"viscous = 0.02\n{EFFECTS}"),
    "presliding": platform("viscous = 0.02\ncoulomb = 0.05\n" + BENT.format(s=0.0)),
    "presliding, bent": platform("viscous = 0.02\ncoulomb = 0.05\n" + BENT.format(s=0.5)),
    "reaction": reaction(),
    "two_axis": two_axis(GIMBAL + TILTING + GRAVITY),
}


ORDER = {
    "current limit": 2,
    "late command and readings, lag, clock": 2,
    "presliding": 1,
    "presliding, bent": 1,
    "two_axis": 2,
}
"""Of the rigs whose motion the exact solver's equal steps do not solve in closed form: the order of its error in the step."""


def apart(rig: Rig, step: float) -> float:
    """Largest difference of both solvers, over the largest value of each output; every run lasts 1 s."""
    time = np.arange(round(1.0 / step) + 1) * step
    u = (0.4 if rig.kind == "platform" else 4.0) * np.sign(np.sin(2.0 * np.pi * 1.7 * time + 0.1))
    u = np.stack([u, -u], axis=1) if rig.kind == "two_axis" else u
    smooth, exact = (simulate(rig, time, u, solver=solver) for solver in (Smooth(0.01), EXACT))
    return max(float(np.max(np.abs(smooth[y] - exact[y])) / np.max(np.abs(exact[y]))) for y in exact)


@pytest.mark.parametrize(
    "name", ["wheel with inductance", *(pytest.param(n, marks=pytest.mark.slow) for n in ("platform", "reaction"))]
)
def test_without_dry_friction_it_is_the_exact_solver(name: str) -> None:
    assert apart(RIGS[name], 0.02) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("name", ORDER)
def test_the_exact_solver_tends_to_it_with_shorter_steps(name: str) -> None:
    coarse, fine = apart(RIGS[name], 0.005), apart(RIGS[name], 0.0025)
    assert fine < 3e-3 and np.log2(coarse / fine) > ORDER[name] - 0.2, (coarse, fine)


@pytest.mark.slow
def test_a_stiff_motor_gets_an_implicit_method_and_turns_as_one_without_inductance() -> None:
    K, R, b, J, L = 0.0182, 0.83, 4.07e-6, 1.24e-4, 1e-6
    rig, log = wheel(L), record(T, np.full_like(T, 4.0), {})
    assert method_for(rig, [log], 0.01) == diffrax.Kvaerno3()
    assert method_for(wheel(), [log], 0.01) == diffrax.Tsit5()
    found = simulate(rig, T, log.command, solver=Smooth())
    pole, steady = -(b * R + K * K) / (J * R), 4.0 * K / (b * R + K * K)
    assert found["wheel_rad_s"] == pytest.approx(steady * (1.0 - np.exp(pole * T)), abs=1e-5 * steady)


COUNT = 2.0 * np.pi / 4096.0


def test_the_default_width_is_one_count_in_ten_seconds() -> None:
    turned = record(
        T, 0.0 * T, {"yaw_rad": np.round(0.3 * np.sin(3.0 * T) / COUNT) * COUNT}, resolution={"yaw_rad": COUNT}
    )
    assert default_width(PLATFORM, [turned]) == pytest.approx(COUNT / 10.0, rel=1e-3)


def test_the_default_width_of_a_rate_is_a_tenth_of_its_noise() -> None:
    noise = 0.03 * np.random.default_rng(1).normal(size=4000)
    time = np.arange(4000) * 0.01
    log = record(time, 0.0 * time, {"yaw_rad_s": np.sin(time) + noise})
    assert default_width(PLATFORM, [log]) == pytest.approx(0.003, rel=0.05)
    fast = record(time, 0.0 * time, {"yaw_rad_s": 500.0 * np.sin(time) + noise})
    assert default_width(PLATFORM, [fast]) == pytest.approx(
        0.05, rel=0.01
    )  # below a share of the fastest rate it costs time


def test_the_default_width_without_readings_is_by_the_rig_files_encoder() -> None:
    bare, counted = record(T, 0.0 * T, {}), replace(PLATFORM, counts_per_rev={"yaw_rad": 4096.0})
    assert default_width(counted, [bare]) == pytest.approx(COUNT / 10.0)
    assert default_width(BARE, [bare]) == 0.01


def test_what_the_user_sets_stays_and_the_rest_is_chosen() -> None:
    log, euler = record(T, SINE, {}), diffrax.Heun()
    whole = Smooth(0.3, euler, rtol=1e-3)
    assert whole.suited(PLATFORM, [log]) == whole
    assert Smooth(0.3).suited(PLATFORM, [log]) == Smooth(0.3, diffrax.Tsit5())
    chosen = Smooth(method=euler).suited(PLATFORM, [log])
    assert chosen == Smooth(default_width(PLATFORM, [log]), euler)
    assert whole.sign_width == 0.3


def test_a_note_says_the_width_and_whether_the_readings_show_it() -> None:
    log, says = record(T, SINE, {}), "dry friction acts by a smooth sign {} rad/s wide, solved by Heun"
    assert Smooth(0.01, diffrax.Heun()).notes(BARE, [log]) == [says.format(0.01)]
    first, second = Smooth(0.3, diffrax.Heun()).notes(BARE, [log])
    assert first == says.format(0.3) and second.startswith("the smooth sign is 30 times as wide as what these readings")


class Own(diffrax.Tsit5):
    """A method of somebody else."""


def test_programs_of_methods_of_others_are_not_the_librarys() -> None:
    assert TIGHT.from_library and not replace(TIGHT, method=Own()).from_library


@pytest.mark.slow
def test_the_first_windows_and_each_window_from_its_node_are_those_of_the_whole_run() -> None:
    log = record(T, SQUARE)
    structure, problem = structure_of(PLATFORM), pose(structure_of(PLATFORM), (log,), {"yaw_rad": 1.0})
    theta, batch, start = theta_of(PLATFORM, structure), problem.batch, np.array([[0.0, 0.3]])

    def all_three(run: Batch, x0: Array) -> list:
        plant = plant_of_run(structure, jnp.asarray(theta), run)
        whole, nodes = TIGHT.whole(plant, run, x0)
        first = TIGHT.beginning(plant, run, x0, jnp.asarray(2))
        return [whole, nodes, *first, *TIGHT.windows(plant, run, nodes)]

    found = jax.jit(lambda batch: TIGHT.of_logs(all_three, batch, jnp.asarray(start)))(batch)
    whole, nodes, first, begun, each, ends = (np.asarray(a)[0] for a in found)
    assert batch.windows > 2 and nodes[0] == pytest.approx(start[0])
    assert first[:2] == pytest.approx(whole[:2], rel=1e-9) and not first[2:].any()
    assert begun[:2] == pytest.approx(nodes[:2], rel=1e-9) and not begun[2:].any()
    assert each == pytest.approx(whole, rel=1e-7, abs=1e-9)
    assert ends[:-1] == pytest.approx(nodes[1:], rel=1e-7, abs=1e-9)


def test_the_loop_of_a_servo_and_torque_that_is_off_are_left_to_the_exact_solver() -> None:
    t = np.arange(20) * 0.01
    with pytest.raises(InputError, match=r"does not simulate the loop of \[drive.servo\]; take the exact one"):
        simulate(servo(joint()), t, {"goal_rad": t}, solver=Smooth())
    with pytest.raises(InputError, match="does not simulate torque that is off at times"):
        simulate(joint(), t, {"voltage_V": t, "enabled": (t < 0.1).astype(float)}, solver=Smooth())


@pytest.mark.parametrize("width", [-1.0, 0.0, np.inf, np.nan])
def test_a_width_that_is_no_positive_number_is_refused_where_the_solver_is_made(width: float) -> None:
    with pytest.raises(InputError, match=rf"^width {width}: the width of the smooth sign has to be a positive number"):
        Smooth(width)


def test_a_width_that_is_no_number_is_refused_in_the_same_words() -> None:
    """In a process of its own, where no signature is checked, as for a user."""
    program = """
import numpy as np
from rwjax import InputError, Smooth
Smooth(np.array(0.1)), Smooth(np.float32(0.1)), Smooth(1)
for width in ({}, [0.1], "wide", np.array("x"), np.array(1j), np.array(True), True, 10**400):
    try:
        Smooth(width)
    except InputError as error:
        print(error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        f"width {width}: the width of the smooth sign has to be a positive number [rad/s]"
        for width in ("{}", "[0.1]", "wide", "x", "1j", "True", "True", 10**400)
    ]
