"""What single effects do in motion, beside their closed forms."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.effects import axis_friction, drive, sensor
from tests.effects.rigs import DRY, FREE, REST, RIGS, TIME, go, motion
from tests.systems import platform, record, run
from tests.systems import wheel as wheel_rig


@pytest.mark.parametrize("tau", [0.04, 0.0373])
def test_a_late_reading_is_a_late_command_where_there_is_one_encoder(tau: float) -> None:
    u = np.where(TIME < 0.3, 0.0, 0.6 * np.sign(np.sin(2.3 * TIME)) + 0.2 * np.sin(9.0 * TIME))
    for rig, within in ((DRY, 1e-12 if tau == 0.04 else 5e-3), (FREE, 1e-5)):
        late = go(rig, u, {}, {"sensor.delay": {"tau": tau}})["yaw_rad"]
        command = go(rig, u, {}, {"drive.delay": {"tau": tau}})["yaw_rad"]
        # a late command within a step enters it by its mean, which stick and slip feel
        assert np.max(np.abs(late - command)) < within * np.max(np.abs(command))


def test_other_sensors_than_the_encoder_are_not_late() -> None:
    u = 2.0 * np.sin(3.0 * TIME)
    plain, late = (go(RIGS["reaction"], u, {}, {"sensor.delay": {"tau": tau}}) for tau in (0.0, 0.05))
    assert np.array_equal(late["wheel_rad_s"], plain["wheel_rad_s"]) and np.array_equal(
        late["current_A"], plain["current_A"]
    )
    assert np.max(np.abs(late["yaw_rad"][5:] - plain["yaw_rad"][:-5])) < 1e-12


@given(angle=st.floats(-10.0, 10.0), rate=st.floats(-5.0, 5.0))
def test_an_eccentric_encoder_reads_the_rate_of_the_angle_that_it_reads(angle: float, rate: float) -> None:
    read = partial(sensor.Eccentricity(*map(jnp.asarray, (0.1, -0.05, 0.04, 0.03))).read, motion=motion())
    psi, w = jnp.asarray(angle), jnp.asarray(rate)
    slope = jax.grad(lambda psi: read(psi, w)[0])(psi)
    assert float(read(psi, w)[1]) == pytest.approx(rate * float(slope), abs=1e-12)


def test_an_end_stop_takes_energy_and_never_pulls() -> None:
    stop = {"axis.end_stop": {"high": 1.0, "low": -1.0, "k": 40.0, "d": 1.0}}
    y = go(FREE, REST, {"w": 1.0}, stop)
    assert (
        -1.0 < y["yaw_rad_s"][TIME > 1.5][0] < -0.3 and np.min(y["yaw_rad"]) > -1.05
    )  # back, and off the other stop too
    away = (np.abs(y["yaw_rad"]) < 0.98)[1:] & (np.abs(y["yaw_rad"]) < 0.98)[:-1]
    assert np.max(np.abs(np.diff(y["yaw_rad_s"])[away])) < 1e-12


@pytest.mark.parametrize(
    ("s", "there", "back"),
    [
        (0.0, 1.0 - np.exp(-1.5), -1.0 + (2.0 - np.exp(-1.5)) * np.exp(-2.5)),
        (0.5, 1.0 - 0.25**2, -1.0 + (np.sqrt(2.0 - 0.25**2) - 1.25) ** 2),
        (1.0, 1.0, -1.0),  # elastic up to x_s, then sliding
    ],
)
def test_bent_friction_follows_its_hysteresis_whatever_the_step(s: float, there: float, back: float) -> None:
    bent = axis_friction.Presliding(M_c=jnp.asarray(0.05), x_s=jnp.asarray(0.02), s=jnp.asarray(s), d=jnp.zeros(()))
    z = jnp.zeros(())
    for travel, exact in ((0.03, there), (-0.05, back)):
        whole, parts = bent.after(z, jnp.asarray(travel)), z
        for _ in range(7):
            parts = bent.after(parts, jnp.asarray(travel / 7.0))
        z = whole
        assert float(whole) == pytest.approx(exact, rel=1e-8) and float(parts) == pytest.approx(exact, rel=1e-8)


def test_bent_friction_is_a_spring_at_first_and_dry_friction_in_the_end() -> None:
    given = {"axis.presliding": {"M_c": 0.0, "x_s": 0.05}}
    y = go(DRY, REST, {"w": 1e-4}, given)["yaw_rad"]
    assert (
        np.max(np.abs(y - 1e-5 * np.sin(np.sqrt(10.0) * TIME) * np.sqrt(10.0))[TIME < 2.0]) < 1e-6
    )  # k = M_c/x_s = 1 N m/rad
    far = go(DRY, REST, {"w": 3.0}, given)["yaw_rad_s"]
    slides = (TIME > 1.0) & (TIME < 5.0)
    assert np.max(np.abs(np.diff(far)[slides[1:]] + 0.005)) < 1e-6


def test_a_constant_torque_below_breakaway_turns_nothing() -> None:
    y = run(platform(), record(TIME, REST), {}, effects={"axis.bias_torque": {"T": -0.049}})
    assert np.ptp(y["yaw_rad"]) == 0.0


def test_commands_within_the_dead_zone_do_nothing_and_others_lose_it() -> None:
    u = np.where(TIME < 5.0, -0.29, 1.3)
    dead = run(platform(), record(TIME, u), {}, effects={"drive.deadzone": {"u_0": 0.3}})
    plain = run(platform(), record(TIME, np.where(TIME < 5.0, 0.0, 1.0)), {})
    assert np.ptp(dead["yaw_rad"][TIME < 5.0]) == 0.0
    assert np.max(np.abs(dead["yaw_rad"] - plain["yaw_rad"])) < 1e-10


def test_an_offset_is_added_to_the_command() -> None:
    u = np.sin(TIME)
    offset = run(platform(), record(TIME, u), {}, effects={"drive.bias": {"u_b": 0.2}})
    assert np.max(np.abs(offset["yaw_rad"] - run(platform(), record(TIME, u + 0.2), {})["yaw_rad"])) < 1e-12


def test_the_dead_zone_comes_before_the_offset() -> None:
    # otherwise the offset could be hidden within the zone
    both = {"drive.deadzone": {"u_0": 0.3}, "drive.bias": {"u_b": 0.2}}
    y = run(platform(), record(TIME, REST), {}, effects=both)
    assert y["yaw_rad"][-1] == pytest.approx(run(platform(), record(TIME, REST + 0.2), {})["yaw_rad"][-1], rel=1e-12)


def test_a_braked_wheel_stops_when_the_closed_form_says() -> None:
    # open circuit is not in the plant: at V = 0 back-EMF brakes too, b_e = b + K^2/R
    K, R, b, J, M_c, Omega0 = 0.0182, 0.83, 4.07e-6, 1.24e-4, 2e-3, 30.0
    t = TIME[:301]
    log = record(t, np.zeros_like(t), {"wheel_rad_s": np.zeros_like(t)})
    y = run(wheel_rig(0.0), log, {"Omega": Omega0}, effects={"wheel.coulomb": {"M_c": M_c}})
    braking = b + K**2 / R
    stop = J / braking * np.log1p(braking * Omega0 / M_c)
    exact = np.where(t < stop, (Omega0 + M_c / braking) * np.exp(-braking / J * t) - M_c / braking, 0.0)
    assert 0.2 < stop < 2.5
    assert np.max(np.abs(y["wheel_rad_s"] - exact)) < 1e-10 * Omega0  # samples beside the stop are exact too
    assert np.all(y["wheel_rad_s"][t > stop + 0.01] == 0.0)


def test_a_curve_has_one_slope_by_its_bend_on_either_side_of_none() -> None:
    def by_c(c: float, u: float) -> float:
        given = {"p": jnp.asarray(0.1), "u_1": jnp.asarray(3.0)}
        return float(jax.grad(lambda c: drive.Curvature(c=c, **given).command(jnp.asarray(u)))(jnp.asarray(c)))

    for u in (2.0, -2.0):
        assert by_c(0.0, u) == pytest.approx(by_c(1e-9, u), rel=1e-6) == pytest.approx(by_c(-1e-9, u), rel=1e-6)
