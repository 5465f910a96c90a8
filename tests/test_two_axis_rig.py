"""A rig with two axes the whole way: commands, simulation, fit, candidates, diagnosis."""

from dataclasses import replace
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from rwjax import read_log, read_rig
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.diagnosis.hypothesis import (
    Hypothesis,
    candidates,
    coordinate_of,
    free_names,
    handed_on,
    structure_for,
)
from rwjax.effects.library import included_numbers
from rwjax.errors import InputError
from rwjax.fitting.fit import fit
from rwjax.fitting.predict import predict
from rwjax.fitting.problem import pose
from rwjax.logs.read import read_logs
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.batch import WITHOUT_LOG_AXIS
from rwjax.simulation.commands import commands, whole_log
from tests.systems import record
from tests.two_axes import GIMBAL, GRAVITY, TILTING, motion, two_axis

DATA = Path(__file__).parents[1] / "data" / "two_axis"
WHOLE = two_axis(GIMBAL + GRAVITY + TILTING)


def with_effects(rig: Rig, **effects: dict[str, float]) -> Rig:
    return replace(rig, effects=rig.effects | {name.replace("__", "."): given for name, given in effects.items()})


T = 0.01 * np.arange(60)


@pytest.mark.parametrize("command", ["region", "compare", "slew"])
def test_what_knows_one_axis_says_so(command: str) -> None:
    from rwjax.cli.main import app

    arguments = [command, str(DATA / "rig.toml"), *([str(DATA / "square.csv")] if command == "compare" else [])]
    arguments += ["--angle", "45"] if command == "slew" else []
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, InputError)
    assert "kind `two_axis` has two axes, and this is for one" in str(result.exception)


def test_each_drive_delays_its_own_command() -> None:
    rig = with_effects(WHOLE, drive_2__delay={"tau": 0.1}, drive_1__bias={"u_b": 0.5})
    u = np.stack([np.sign(np.sin(20.0 * T)), np.cos(30.0 * T)], axis=1)
    problem = pose(structure_of(rig), [record(T, u)])
    run = problem.batch.__class__(*(v if k in WITHOUT_LOG_AXIS else v[0] for k, v in problem.batch._asdict().items()))
    theta = jnp.asarray(theta_of(rig, problem.structure))
    steps, readings = jax.jit(lambda theta: commands(plant_of(problem.structure, theta), run)(whole_log(run)))(theta)
    per = round(0.01 / float(run.h))
    np.testing.assert_allclose(steps[: 50 * per : per, 0], u[:50, 0] + 0.5, atol=1e-9)
    np.testing.assert_allclose(steps[15 * per : 50 * per : per, 1], u[5:40, 1], atol=1e-9)
    assert readings.shape == (run.slot_step.size, 2)


def test_the_yaw_encoder_may_read_a_part_of_pitch_and_both_may_be_late() -> None:
    rig = with_effects(
        WHOLE, sensor_1__misalignment={"e": 0.1}, sensor_2__scale={"s": 0.5}, sensor__delay={"tau": 0.02}
    )
    structure = structure_of(rig)
    plant = plant_of(structure, jnp.asarray(theta_of(rig, structure)))
    x, seen = (tuple(map(jnp.asarray, np.linspace(a, a + 1.0, len(structure.states)))) for a in (0.2, 0.1))
    y = dict(zip(structure.outputs, plant.outputs(jnp.asarray(1.0), x, jnp.ones(2), seen), strict=True))
    now, late = (dict(zip(structure.states, v, strict=True)) for v in (x, seen))
    assert float(y["yaw_rad"]) == pytest.approx(float(late["psi_1"] + 0.1 * late["psi_2"]))
    assert float(y["yaw_rad_s"]) == pytest.approx(float(late["w_1"] + 0.1 * late["w_2"]))
    assert float(y["pitch_rad"]) == pytest.approx(1.5 * float(late["psi_2"]))
    assert float(y["wheel_2_rad_s"]) == pytest.approx(float(now["Omega_2"]))


@pytest.mark.slow
def test_a_late_run_is_the_same_run_later() -> None:
    rig = read_rig(DATA / "rig.toml")
    log = replace(read_log(DATA / "square.csv", rig).cut(0, 300), outputs={})
    y = predict(rig, log)
    late = predict(with_effects(rig, sensor__delay={"tau": 0.02}, sensor_1__misalignment={"e": 0.1}), log)
    for name in ("pitch_rad", "pitch_rad_s"):
        np.testing.assert_allclose(late[name][2:], y[name][:-2], atol=1e-12)
    np.testing.assert_allclose(late["yaw_rad"][2:], (y["yaw_rad"] + 0.1 * y["pitch_rad"])[:-2], atol=1e-12)
    np.testing.assert_array_equal(late["wheel_1_rad_s"], y["wheel_1_rad_s"])  # other sensors read at once
    assert np.ptp(y["pitch_rad"]) > 0.1


@pytest.mark.slow
def test_the_fit_finds_the_numbers_and_the_tilt() -> None:
    """The example's testbed has s = 1 (data/two_axis/make_logs.py); the fit begins at half of it and with wrong inertias."""
    rig = read_rig(DATA / "rig.toml")
    truth = rig.values | {"wheel_1.gyroscopic.s": 1.0}
    rig = with_effects(rig, wheel_1__gyroscopic={"s": 0.5}).with_values({"yaw.inertia": 0.06, "pitch.inertia": 0.018})
    rig = replace(rig, free=(*rig.free, "wheel_1.gyroscopic.s"))
    found = fit(rig, [read_log(DATA / f"{name}.csv", rig).cut(0, 350) for name in ("square", "sines")])
    assert not found.notes, found.notes
    for name in rig.free:
        assert abs(found.rig.values[name] - truth[name]) < 4.0 * found.rig.standard_error[name], name
    assert found.rig.standard_error["wheel_1.gyroscopic.s"] < 0.02


def test_candidates_are_named_by_part_and_levels_are_kept_apart() -> None:
    every = candidates(WHOLE)
    assert {"yaw.stribeck", "pitch.imbalance", "wheel_2.cogging", "sensor_1.misalignment", "sensor.clock"} <= {*every}
    assert not any(name.startswith(("axis.", "wheel.", "drive.", "sensor.scale")) for name in every)
    assert "wheel_1.gyroscopic" not in every and "wheel_1.gyroscopic" in candidates(replace(WHOLE, effects={}))
    both = Hypothesis(("yaw.stribeck", "pitch.stribeck", "pitch.coulomb"))
    free = free_names(WHOLE, both, ())
    assert "yaw.stribeck.M_c" in free and "pitch.stribeck.M_c" not in free
    assert both.contains(Hypothesis(("yaw.coulomb",))) and not both.contains(Hypothesis(("wheel_1.coulomb",)))
    assert handed_on(included_numbers(), {"yaw.stribeck.M_c"}, {"pitch.coulomb.M_c"}) == []
    assert handed_on(included_numbers(), {"yaw.stribeck.M_c"}, {"yaw.coulomb.M_c"}) == [
        ("yaw.stribeck.M_c", "yaw.coulomb.M_c")
    ]
    assert coordinate_of("pitch.stribeck") == "pitch_rate" and coordinate_of("parameter.pitch.inertia") == "load"
    structure = structure_for(WHOLE, Hypothesis(("yaw.coulomb",)))
    assert "yaw.coulomb" in structure.effects and "pitch.coulomb" not in structure.effects


@pytest.mark.slow
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_pitch_runs_into_both_of_its_stops(way: float) -> None:
    """Against an integration of pitch and its wheel alone: yaw stays where it is, since the gimbal has no product with y."""
    rig = read_rig(DATA / "rig.toml")
    u = np.zeros((400, 2))
    u[:, 1] = way * np.where(np.arange(400) < 150, 10.0, -10.0)
    n, stop, found = rig.values, rig.effects["pitch.end_stop"], motion(rig, {}, u, 0.01 / 64, 64)

    def rates(t: float, x: np.ndarray) -> list[float]:
        angle, w, Omega = x
        volts = u[min(int(t / 0.01 + 1e-9), 399), 1]
        tau = n["motor_2.torque_constant"] * (volts - n["motor_2.torque_constant"] * Omega) / n["motor_2.resistance"]
        over = angle - np.clip(angle, stop["low"], stop["high"])
        push = max(stop["k"] * abs(over) + stop["d"] * w * np.sign(over), 0.0) * np.sign(over)
        friction = n["pitch.friction.viscous"] * w + n["pitch.friction.coulomb"] * np.tanh(w / 1e-4)
        a = (-tau - friction - push - n["pitch.gravity.torque"] * np.sin(angle)) / n["pitch.inertia"]
        return [w, a, tau / n["wheel_2.inertia"] - a]

    exact = solve_ivp(rates, (0.0, 4.0), [0.0, 0.0, 0.0], "LSODA", 0.01 * np.arange(401), rtol=1e-8, max_step=1e-3)
    assert max(exact.y[0]) > 0.72 and min(exact.y[0]) < -0.72  # beyond 40 degrees both ways
    np.testing.assert_allclose(found["psi_2"], exact.y[0], atol=2e-3)
    assert not found["psi_1"].any()


@pytest.mark.slow
def test_the_diagnosis_of_the_example_names_what_its_rig_file_lacks() -> None:
    rig = read_rig(DATA / "rig.toml")
    found = diagnose(rig, read_logs(sorted(DATA.glob("*.csv")), rig))
    assert found.verdict == "effect" and list(found.effects) == ["wheel_1.gyroscopic"]
