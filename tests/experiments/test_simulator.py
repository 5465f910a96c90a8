"""The separate simulator against closed forms, and the demo's logs made again byte for byte."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.blind.sensors import Recorded, readings
from experiments.blind.simulator import STEP, STOPS, Truth, happen, run, simulate
from experiments.blind.truth import HEAT, PSI, PSI_DRIVE, STATES, TOUCH, W_DRIVE, W

DEMO = Path(__file__).resolve().parents[2] / "data" / "demo"
TIME = np.arange(1001) * 0.01
STILL = np.zeros(5)
SQUARE = 4.0 * np.sign(np.sin(2.0 * TIME))
BARE = Truth(kind=1, I=0.1, gain=0.4)
COMMAND = np.where(TIME < 0.2, 0.0, 3.0)  # a step at 0.2 s


def test_coast_down_stops_at_its_closed_form() -> None:
    truth = Truth(kind=1, I=0.1, gain=0.4, viscous=0.02, coulomb=0.05)
    start = np.array([0.0, 2.0, 0.0, 0.0, 0.0])
    w = simulate(TIME, np.zeros_like(TIME), TIME, start, truth.array(), STEP)[:, 1]
    stop = 0.1 / 0.02 * np.log1p(0.02 * 2.0 / 0.05)
    exact = np.where(stop > TIME, (2.0 + 0.05 / 0.02) * np.exp(-0.2 * TIME) - 0.05 / 0.02, 0.0)
    assert np.max(np.abs(w - exact)) < 1e-8  # midpoint steps of 0.1 ms
    assert np.all(w[stop < TIME] == 0.0)


@pytest.mark.parametrize(
    "law",
    [
        {"excess": 0.03},
        {"coulomb": 0.1, "asymmetry": 0.04},
        {"load_friction": 0.9},
        {"dwell": 0.05, "excess": 0.03},
        {"drift": 0.5, "excess": 0.03},
        {"angle_friction": 0.5, "coulomb": 0.2},
    ],
)
def test_a_stuck_axis_stays(law: dict) -> None:
    truth = replace(BARE, **({"coulomb": 0.05} | law))
    x = simulate(TIME, np.full_like(TIME, 0.9 * 0.08 / 0.4), TIME, STILL, truth.array(), STEP)
    assert np.all(x[:, 0] == 0.0)


def test_wheel_friction_drag_and_cogging_keep_angular_momentum() -> None:
    truth = Truth(kind=2, I=0.05, wheel_coulomb=0.01, wheel_drag=1e-7, cogging=0.002, saturation_current=3.0)
    x = simulate(TIME, SQUARE, TIME, STILL, truth.array(), STEP)
    assert np.ptp(x[:, 3]) > 100.0
    assert np.max(np.abs(truth.I * x[:, 1] + truth.J * x[:, 3])) < 1e-12


def test_a_delay_shifts_by_exactly_itself() -> None:
    late = simulate(TIME, SQUARE, TIME + 0.05, STILL, replace(BARE, viscous=0.05, delay=0.05).array())
    prompt = simulate(TIME, SQUARE, TIME, STILL, replace(BARE, viscous=0.05).array())
    assert SQUARE[0] == 0.0
    assert np.max(np.abs(late[:, 0] - prompt[:, 0])) < 1e-9


def test_a_late_reading_is_the_reading_of_before() -> None:
    truth = replace(BARE, viscous=0.05)
    record = Recorded(TIME, SQUARE, TIME, STILL)
    late = readings(replace(truth, sensor_delay=0.03), record, ["yaw_rad"])["yaw_rad"]
    prompt = readings(truth, record, ["yaw_rad"])["yaw_rad"]
    assert np.max(np.abs(late[3:] - prompt[:-3])) < 1e-9


def test_a_clock_stretches_time() -> None:
    truth = replace(BARE, clock=float(np.log(1.1)))
    record = Recorded(TIME, np.full_like(TIME, 1.0), TIME, STILL)
    psi = readings(truth, record, ["yaw_rad"])["yaw_rad"]
    assert psi == pytest.approx(0.5 * 4.0 * (TIME / 1.1) ** 2, abs=1e-9)


def test_a_lag_answers_a_step_exponentially() -> None:
    truth = replace(BARE, I=1.0, gain=1.0, lag=0.1)
    w = simulate(TIME, COMMAND, TIME, STILL, truth.array())[:, 1]
    s = np.maximum(TIME - 0.2, 0.0)
    assert w == pytest.approx(3.0 * (s - 0.1 * (1.0 - np.exp(-s / 0.1))), abs=1e-6)


def test_a_rate_limit_makes_a_ramp() -> None:
    truth = replace(BARE, I=1.0, gain=1.0, rate_limit=6.0)
    w = simulate(TIME, COMMAND, TIME, STILL, truth.array())[:, 1]
    s = np.maximum(TIME - 0.2, 0.0)
    assert w == pytest.approx(np.where(s < 0.5, 3.0 * s**2, 3.0 * (s - 0.25)), abs=1e-9)


def test_a_stalled_motor_gets_what_the_source_resistance_leaves() -> None:
    truth = Truth(kind=0, sag=0.4, wheel_coulomb=1.0)
    i = simulate(TIME, np.full_like(TIME, 6.0), TIME, STILL, truth.array())[-1, 4]
    assert i * truth.R == pytest.approx(6.0 * truth.R / (truth.R + 0.4), rel=1e-9)


def test_a_winding_reaches_its_steady_temperature() -> None:
    truth = Truth(kind=0, L=0.0, wheel_coulomb=1.0, heat=0.01, heat_time=0.5)
    rise = run(TIME, np.full_like(TIME, 6.0), TIME, STILL, truth.array())[-1, HEAT]
    power = 6.0**2 / (truth.R * (1.0 + rise))
    assert rise == pytest.approx(truth.heat * truth.heat_time * power, rel=1e-6)


@pytest.mark.parametrize("inductance", [0.0, 0.06])
def test_a_current_limit_holds(inductance: float) -> None:
    truth = Truth(kind=0, L=inductance, current_limit=2.5)
    i = simulate(TIME, SQUARE, TIME, STILL, truth.array())[:, 5]
    assert np.max(np.abs(i)) == 2.5


def test_an_elastic_coupling_keeps_momentum_and_energy() -> None:
    truth = replace(BARE, coupling=1.0, drive_share=0.3, stiffness=2.0)
    start = np.array([0.2, 1.0, 0.0, 0.0, 0.0])
    push = np.where(TIME < 0.5, 1.0, 0.0)
    x = run(TIME, push, TIME, start, truth.array())[51:]
    momentum = 0.07 * x[:, W] + 0.03 * x[:, W_DRIVE]
    energy = 0.5 * (0.07 * x[:, W] ** 2 + 0.03 * x[:, W_DRIVE] ** 2 + 2.0 * (x[:, PSI] - x[:, PSI_DRIVE]) ** 2)
    assert momentum == pytest.approx(0.1 * 1.0 + 0.4 * 0.5, abs=1e-12)
    assert np.ptp(energy) < 1e-6 * energy[0]
    assert np.ptp(x[:, W]) > 0.1


@pytest.mark.parametrize("form", [2.0, 3.0])
def test_play_carries_nothing_inside_its_gap(form: float) -> None:
    truth = replace(BARE, coupling=form, drive_share=0.3, gap=0.1, stiffness=3000.0, damping=2.0)
    x = run(TIME, np.full_like(TIME, 0.1), TIME, STILL, truth.array())
    travel = 0.5 * 0.04 / 0.03 * TIME**2  # of the drive's side alone
    inside = travel < 0.05
    assert inside.sum() > 20
    assert np.all(x[inside, PSI] == 0.0)
    assert x[inside, PSI_DRIVE] == pytest.approx(travel[inside], abs=1e-9)
    assert np.max(x[:, PSI_DRIVE] - x[:, PSI]) < 0.052
    total = 0.07 * x[:, W] + 0.03 * x[:, W_DRIVE]
    assert total == pytest.approx(0.04 * TIME, abs=1e-9)  # impacts keep momentum


def test_a_hard_end_stop_is_never_passed_and_gives_back_its_share() -> None:
    truth = replace(BARE, stop_form=2.0, stop_high=1.0, stop_low=-1.0, restitution=0.5)
    start = np.array([0.0, 2.0, 0.0, 0.0, 0.0])
    x = simulate(TIME, np.zeros_like(TIME), TIME, start, truth.array())
    assert np.max(np.abs(x[:, 0])) <= 1.0
    assert x[60, 1] == -1.0
    pushed = simulate(TIME, np.full_like(TIME, 1.0), TIME, STILL, truth.array())
    assert np.all(pushed[-1, :2] == [1.0, 0.0])


@pytest.mark.parametrize(
    "rate", [1e-6, 0.0, -1e-6]
)  # friction may have turned it in the step in which it meets the stop
def test_an_axis_stops_where_it_meets_the_stop(rate: float) -> None:
    truth = replace(BARE, stop_form=1.0, stop_high=1.0, stop_stiffness=100.0)
    x = np.zeros(STATES)
    x[PSI], x[W] = 1.0, rate
    happen(x, STOPS, truth.array())
    assert (x[PSI], x[TOUCH]) == (1.0, 1.0)


def test_a_soft_end_stop_is_bounded_by_the_energy_it_takes() -> None:
    truth = replace(BARE, stop_form=1.0, stop_high=1.0, stop_stiffness=100.0)
    start = np.array([0.0, 2.0, 0.0, 0.0, 0.0])
    x = simulate(TIME, np.zeros_like(TIME), np.linspace(0.0, 10.0, 20_001), start, truth.array())
    assert np.max(x[:, 0]) == pytest.approx(1.0 + 2.0 * np.sqrt(0.1 / 100.0), rel=1e-4)
    assert x[-1, 1] == pytest.approx(-2.0, rel=1e-4)


@pytest.mark.parametrize(
    "law",
    [
        {"excess": 0.05},
        {"preslide_form": 1.0, "preslide_damping": 0.05},
        {"preslide_form": 2.0},
        {"preslide_form": 3.0},
        {"drift": 0.5},
        {"asymmetry": 0.03},
        {"quadratic": 0.01},
        {"memory": 2.0},
    ],
)
def test_friction_never_gives_energy_over_a_whole_coast(law: dict) -> None:
    truth = replace(BARE, **({"coulomb": 0.05, "preslide": 0.05} | law))
    start = np.array([0.0, 3.0, 0.0, 0.0, 0.0])
    w = simulate(TIME, np.zeros_like(TIME), TIME, start, truth.array())[:, 1]
    assert np.max(np.abs(w)) <= 3.0
    assert abs(w[-1]) < 0.05
    if "preslide_form" not in law:
        assert np.all(np.diff(w) <= 0.0)
        assert w[-1] == 0.0


@pytest.mark.parametrize("form", [1.0, 2.0, 3.0])
def test_elastic_friction_is_a_spring_at_first_and_slides_at_its_level(form: float) -> None:
    truth = replace(BARE, coulomb=0.05, preslide_form=form, preslide=0.02)
    held = simulate(TIME, np.full_like(TIME, 0.5 * 0.05 / 0.4), TIME, STILL, truth.array())
    assert 0.0 < np.max(held[:, 0]) < 0.1
    slid = simulate(TIME, np.full_like(TIME, 0.5), TIME, STILL, truth.array())
    assert np.diff(slid[-100:, 1]) == pytest.approx(0.01 * (0.4 * 0.5 - 0.05) / 0.1, rel=1e-6)


def test_lost_counts_stay_lost() -> None:
    truth = replace(BARE, missed=float(np.log(2.0)), missed_above=1.0)
    record = Recorded(TIME, np.where(TIME < 1.0, 1.0, 0.0), TIME, STILL)
    psi = readings(truth, record, ["yaw_rad", "yaw_rad_s"])
    whole = np.where(TIME < 1.0, 2.0 * TIME**2, 2.0 + 4.0 * (TIME - 1.0))
    slow = 2.0 * 0.25**2  # until 1 rad/s
    exact = np.where(whole < slow, whole, slow + 0.5 * (whole - slow))
    assert psi["yaw_rad"] == pytest.approx(exact, abs=5e-4)
    assert psi["yaw_rad_s"][-1] == pytest.approx(2.0)


def test_the_demo_is_made_again_byte_for_byte(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("make_demo", DEMO / "make_demo.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main(tmp_path)
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (DEMO / path.name).read_bytes(), path.name
