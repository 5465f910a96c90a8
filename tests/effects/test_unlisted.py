"""Laws outside the list of effects: what they do, and that no rig file and no answer has one."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.special import erf

from rwjax import RigError, parse_rig, write_rig
from rwjax.diagnosis.hypothesis import candidates
from rwjax.effects.library import BY_NAME, UNLISTED, of_kind, passing_for
from rwjax.kinds import KINDS
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.reference import simulate_adaptively
from tests.effects.rigs import motion
from tests.systems import platform, reaction, record, run, wheel

GROWS = "axis.growing_stiction"
GAIN, M_C, M_E, TAU = 0.4, 0.05, 0.1, 2.0  # N m/V, N m, N m, s


def rates(command: np.ndarray, t: np.ndarray) -> np.ndarray:
    return run(platform(), record(t, command), {}, effects={GROWS: {"M_e": M_E, "tau": TAU}})["yaw_rad_s"]


def test_a_ramp_breaks_away_where_it_meets_the_grown_level() -> None:
    t = np.arange(1001) * 0.01
    w = rates(0.05 * t, t)
    level = M_C + M_E * (1.0 - np.exp(-t / TAU))
    away = t[np.flatnonzero(GAIN * 0.05 * t > level)[0]]
    assert 4.0 < away < 8.0 and t[np.flatnonzero(w)[0]] == pytest.approx(away, abs=0.02)


def test_sliding_friction_is_the_rigs_own_and_the_time_at_rest_begins_anew_after_it() -> None:
    t = np.arange(801) * 0.01
    u = np.select([t < 3.0, t < 4.0, t < 4.3, t < 5.5], [0.0, 0.25, 0.5, 0.0], 0.25)
    w = rates(u, t)
    assert np.all(w[t < 4.0] == 0.0)  # 0.1 N m against 0.05 + 0.1 (1 - exp(-3/2)) = 0.13 N m
    assert np.any(w[(t > 4.0) & (t < 4.3)] > 0.0) and np.all(w[(t > 5.3) & (t < 5.5)] == 0.0)
    assert np.all(w[t > 5.52] > 0.0)  # the same 0.1 N m after 0.3 s of rest
    slides, values = (t > 5.6) & (t < 6.0), platform().values
    drag = values["axis.friction.viscous"] * (w[1:] + w[:-1]) / 2.0
    torque = (values["axis.inertia"] * np.diff(w) / 0.01 + drag)[slides[1:]]
    assert torque == pytest.approx(GAIN * 0.25 - M_C, rel=1e-3)


INERTIA = {"axis.growing_inertia": {"p": 0.8, "w_0": 2.0}}


def momentum(w: np.ndarray) -> np.ndarray:
    """Integral of the inertia over the rate, as a multiple of that at standstill [rad/s]."""
    p, w_0 = INERTIA["axis.growing_inertia"].values()
    return (1.0 + p) * w - p * w_0 * np.sqrt(np.pi) / 2.0 * erf(w / w_0)


def test_momentum_is_the_impulse_of_the_drive_and_of_dry_friction_whatever_the_inertia() -> None:
    rig, t = platform("coulomb = 0.05"), np.arange(801) * 0.01
    on = t < 2.0
    w = run(rig, record(t, np.where(on, 0.4, 0.0)), {}, effects=INERTIA, refine=4)["yaw_rad_s"]
    impulse = np.where(on, (GAIN * 0.4 - M_C) * t, (GAIN * 0.4 - M_C) * 2.0 - M_C * (t - 2.0))
    assert rig.values["axis.inertia"] * momentum(w) == pytest.approx(np.maximum(impulse, 0.0), abs=2e-5)
    assert w.max() > 1.5 and w[-1] == 0.0


def test_a_wheel_whose_friction_turns_and_holds_it_gives_the_axis_its_momentum() -> None:
    rig, t = reaction("coulomb = 0.0"), np.arange(601) * 0.01
    effects = INERTIA | {"wheel.coulomb": {"M_c": 0.02}}
    log = record(t, np.select([t < 2.0, t < 4.0], [6.0, -6.0], 0.5), {"yaw_rad_s": 0.0 * t, "wheel_rad_s": 0.0 * t})
    found = run(rig, log, {"w": 1.5}, effects=effects, refine=4)
    w, Omega = found["yaw_rad_s"], found["wheel_rad_s"]
    whole = rig.values["axis.inertia"] * momentum(w) + rig.values["wheel.inertia"] * Omega
    assert np.sum(np.diff(np.sign(Omega[Omega != 0.0])) != 0) >= 1 and np.any(Omega[200:] == 0.0) and np.ptp(w) > 0.1
    assert whole == pytest.approx(np.full(len(t), whole[0]), abs=1e-5)


@pytest.mark.slow
def test_smooth_friction_and_the_reference_know_it_too() -> None:
    rig, (p, w_0) = platform("coulomb = 0.05"), INERTIA["axis.growing_inertia"].values()
    structure = structure_of(rig).with_effects("axis.growing_inertia")
    theta = theta_of(rig, structure)
    theta[-2:] = [{"p": p, "w_0": w_0}[name.rpartition(".")[2]] for name in structure.names[-2:]]
    plant, zero, w = plant_of(structure, jnp.asarray(theta)), jnp.zeros(()), jnp.asarray(1.5)
    inertia = rig.values["axis.inertia"] * (1.0 + p * (1.0 - np.exp(-((1.5 / w_0) ** 2))))
    rates = plant.with_smooth_friction(zero, (zero, w), jnp.asarray(0.5), jnp.asarray(0.5))
    assert float(rates[1]) == pytest.approx((GAIN * 0.5 - M_C * np.tanh(3.0)) / inertia)
    t = np.arange(201) * 0.01
    log = record(t, np.where(t < 1.0, 0.5, -0.5))
    exact = simulate_adaptively(plant, log, np.zeros(2))["yaw_rad_s"]
    assert run(rig, log, {}, effects=INERTIA, refine=8)["yaw_rad_s"] == pytest.approx(exact, abs=1e-5)
    assert exact.max() > 1.0 and exact.min() < -0.1


def test_friction_that_was_worked_away_never_drives() -> None:
    law = BY_NAME["axis.worked_friction"](d=jnp.asarray(-2.0), tau=jnp.asarray(1.0))
    m = motion(w=1.0)._replace(own={"axis.worked_friction:v": jnp.asarray(3.0)})
    assert float(law.share(m)) == -1.0


def test_on_a_wheel_alone_it_is_the_wheels() -> None:
    rig, t = wheel(inductance=0.0), np.arange(201) * 0.01
    law = {"axis.growing_inertia": {"p": 0.8, "w_0": 100.0}}
    log = record(t, np.full(len(t), 6.0), {"wheel_rad_s": np.zeros(len(t))})
    end = run(rig, log, {}, effects=law, refine=4)["wheel_rad_s"][-1]
    K, R, b = (rig.values[f"motor.{name}"] for name in ("torque_constant", "resistance", "friction"))

    def inverse_rate(speed: float) -> float:
        inertia = rig.values["wheel.inertia"] * (1.0 + 0.8 * (1.0 - np.exp(-((speed / 100.0) ** 2))))
        return inertia / (K * (6.0 - K * speed) / R - b * speed)

    assert quad(inverse_rate, 0.0, end)[0] == pytest.approx(t[-1], rel=1e-4) and end > 100.0


def test_worked_friction_coasts_as_a_linear_system() -> None:
    d, tau, t = 0.4, 0.7, np.arange(121) * 0.01
    rig, log = platform("coulomb = 0.05"), record(t, np.zeros(len(t)))
    w = run(rig, log, {"w": 2.0}, effects={"axis.worked_friction": {"d": d, "tau": tau}})["yaw_rad_s"]
    slope = M_C / rig.values["axis.inertia"]
    A = np.array([[0.0, -slope * d, -slope], [1.0 / tau, -1.0 / tau, 0.0], [0.0, 0.0, 0.0]])
    assert w == pytest.approx([(expm(A * at) @ [2.0, 0.0, 1.0])[0] for at in t], abs=1e-5) and w[-1] > 0.0


ANGLE_GAIN = {"s_1": 0.3, "c_1": -0.2, "s_2": 0.1, "c_2": 0.05}


def work(psi: np.ndarray) -> np.ndarray:
    """Integral of the gain, as a multiple of its mean, over the angle [rad]."""
    s_1, c_1, s_2, c_2 = ANGLE_GAIN.values()
    once, twice = s_1 * (1.0 - np.cos(psi)) + c_1 * np.sin(psi), s_2 * (1.0 - np.cos(2 * psi)) + c_2 * np.sin(2 * psi)
    return psi + once + twice / 2.0


def test_a_gain_that_goes_with_the_angle_does_the_work_of_the_drive_over_it() -> None:
    rig, t = platform("coulomb = 0.0\nviscous = 0.0"), np.arange(601) * 0.01
    log = record(t, np.full(len(t), 0.5), {"yaw_rad": 0.0 * t, "yaw_rad_s": 0.0 * t})
    found = run(rig, log, {}, effects={"axis.angle_gain": ANGLE_GAIN}, refine=4)
    energy = rig.values["axis.inertia"] * found["yaw_rad_s"] ** 2 / 2.0
    assert (
        energy == pytest.approx(GAIN * 0.5 * work(found["yaw_rad"]), rel=1e-3, abs=1e-6) and found["yaw_rad"][-1] > 6.0
    )


def test_on_a_reaction_rig_it_is_of_the_torque_that_the_wheel_gives_back() -> None:
    rig, t = reaction("coulomb = 0.0\nviscous = 0.0"), np.arange(401) * 0.01
    log = record(t, np.full(len(t), 6.0), {"yaw_rad": 0.0 * t, "yaw_rad_s": 0.0 * t, "wheel_rad_s": 0.0 * t})
    cancelled = {"axis.angle_gain": {"s_1": 0.0, "c_1": 0.0, "s_2": 0.0, "c_2": -0.999999}}
    still = run(rig, log, {}, effects=cancelled, refine=4)
    assert np.max(np.abs(still["yaw_rad_s"])) < 1e-4 and still["wheel_rad_s"][-1] > 10.0


@pytest.mark.parametrize("kind", KINDS)
def test_no_rig_file_and_no_answer_has_one(kind: str) -> None:
    assert not {law.name for law in UNLISTED} & {*of_kind(kind)}


def test_what_a_rig_file_with_one_is_told() -> None:
    with pytest.raises(RigError, match=f"no effect `{GROWS}`"):
        parse_rig(write_rig(platform()) + f'\n[effects."{GROWS}"]\nM_e = 0.1\ntau = 2.0\n')
    assert GROWS not in candidates(platform())


def test_each_passes_for_an_effect_of_the_list_and_its_programs_are_kept() -> None:
    for law in UNLISTED:
        assert law.passes_for and all(not BY_NAME[name].passes_for for name in law.passes_for)
    assert passing_for("axis.stribeck") == (GROWS,) and passing_for("pitch.stribeck") == ("pitch.growing_stiction",)
    assert (
        passing_for("sensor.missed_counts") == ("axis.growing_inertia",) and passing_for("sensor_1.missed_counts") == ()
    )
    assert passing_for("axis.coulomb") == () == passing_for("parameter.axis.inertia")
    assert structure_of(platform()).with_effects(GROWS).from_library
