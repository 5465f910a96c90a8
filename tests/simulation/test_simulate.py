"""The free run of a rig under a command."""

import re
from dataclasses import replace
from fractions import Fraction
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.errors import InputError
from rwjax.fitting.predict import predict
from rwjax.simulation.exact import EXACT
from rwjax.simulation.simulate import simulate
from rwjax.simulation.smooth import Smooth
from rwjax.simulation.solver import Solver
from rwjax.simulation.trajectory import Trajectory
from tests.joints import joint
from tests.systems import platform, reaction, record
from tests.two_axes import two_axis

T = np.arange(51) * 0.01
U = np.full_like(T, 0.5)


def test_a_sliding_platform_follows_the_closed_form() -> None:
    I, b, M_c, k = 0.1, 0.02, 0.05, 0.4
    found = simulate(platform(), T, U, start={"w": 2.0})
    steady = (k * 0.5 - M_c) / b  # rad/s
    assert found["yaw_rad_s"] == pytest.approx(steady + (2.0 - steady) * np.exp(-b / I * T), rel=1e-9)
    assert [*found] == ["yaw_rad", "yaw_rad_s"] and np.array_equal(found.time, T)


def test_from_rest_it_is_what_predict_gives_for_a_log_without_readings() -> None:
    rig = reaction()
    found, predicted = simulate(rig, T + 3.0, 4.0 * U), predict(rig, record(T + 3.0, 4.0 * U, {}))
    for name in (*found, *predicted):
        assert found[name] == pytest.approx(predicted[name], rel=1e-12, abs=1e-15), name


def test_a_rig_with_two_axes_takes_two_commands() -> None:
    found = simulate(two_axis(), T, np.stack([U, -U], axis=1))
    assert found["wheel_1_rad_s"][-1] > 0.1 and found["wheel_2_rad_s"][-1] < -0.1


@pytest.mark.parametrize(
    ("time", "command", "start", "message"),
    [
        (T[:1], U[:1], {}, "give the times of at least two samples"),
        (
            T,
            U[:-1],
            {},
            r"`command` has the shape \(50,\); a `platform` rig takes \(51,\) here, in the unit of `voltage_V`",
        ),
        (T, np.where(T > 0.2, np.nan, U), {}, "have to be finite numbers"),
        (np.where(T == T[7], 0.0, T), U, {}, "`time` does not increase: 0 s follows 0.06 s at sample 7"),
        (T, U, {"omega": 1.0}, "no state `omega`, nearest `.*`; this rig has psi, w"),
        (T, U, {"w": np.inf}, "state `w` inf: has to be a finite number"),
    ],
)
def test_what_cannot_be_simulated_is_said(time: np.ndarray, command: np.ndarray, start: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        simulate(platform(), time, command, start=start)


def test_a_number_that_the_rig_lacks_is_said() -> None:
    with pytest.raises(InputError, match=r"no number `axis.mass`, nearest `axis.inertia`; this rig has drive.gain, "):
        simulate(platform(), T, U, numbers={"axis.mass": 1.0})
    with pytest.raises(InputError, match="number `axis.inertia` nan: has to be a finite number"):
        simulate(platform(), T, U, numbers={"axis.inertia": np.nan})
    with pytest.raises(InputError, match="number `axis.inertia` heavy: has to be a finite number"):
        simulate(platform(), T, U, numbers={"axis.inertia": "heavy"})
    with pytest.raises(InputError, match="number `axis.inertia` None: has to be a finite number"):
        simulate(platform(), T, U, numbers={"axis.inertia": None})  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"time": {"time_s": T}, "command": U}, "simulate: `time` is a `dict`; it has to be an array of numbers"),
        ({"time": T, "command": "full"}, "`command` is a `str`; it has to be an array of numbers"),
        (
            {"time": T, "command": {"voltage_V": U, "supply_V": {}}},
            "`supply_V` is a `dict`; it has to be an array of numbers",
        ),
        (
            {"time": T, "command": U, "numbers": [0.2]},
            "simulate: `numbers` is a `list`; it has to be values by name, as {name: value}",
        ),
        (
            {"time": T, "command": U, "start": 2.0},
            "simulate: `start` is a `float`; it has to be values by name, as {name: value}",
        ),
        (
            {"time": T, "command": U, "numbers": {"axis.inertia": 10**400}},
            "number `axis.inertia` is too large: has to be a finite number",
        ),
        (
            {"time": T, "command": U, "start": {"w": -(10**400)}},
            "state `w` is too large: has to be a finite number",
        ),
        (
            {"time": T, "command": [10**400]},
            "`command` holds a number that is too large; it has to be an array of numbers",
        ),
        (
            {"time": T, "command": [[1.0, 2.0], [3.0]]},
            "`command` holds rows of different lengths; it has to be an array of numbers",
        ),
        ({"time": T, "command": [1.0, "full"]}, "`command` holds what is no number; it has to be an array of numbers"),
    ],
)
def test_an_argument_that_holds_no_numbers_is_told_in_one_line(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^{re.escape(message)}$"):
        simulate(platform(), **given)


def test_a_number_that_no_rig_file_may_hold_is_refused_in_its_words() -> None:
    with pytest.raises(InputError, match=r"^`axis.inertia` is -1.0; it has to be positive$"):
        simulate(platform(), T, U, numbers={"axis.inertia": np.float64(-1.0)})
    assert len(simulate(platform(), T, U, numbers={"axis.inertia": Fraction(1, 20)}).time) == len(T)
    late = replace(platform(), effects={"drive.delay": {"tau": 0.01}})
    with pytest.raises(InputError, match=r"^`drive.delay.tau` is -0.1; "):
        simulate(late, T, U, numbers={"drive.delay.tau": jnp.asarray(-0.1)})


def test_a_solver_whose_number_is_traced_is_refused() -> None:
    with pytest.raises(InputError, match="^a number of the solver is traced; make the solver outside of what JAX"):
        jax.jit(lambda solver: simulate(platform(), T, U, solver=solver))(Smooth(0.01))


@pytest.mark.parametrize("name", ["time", "supply_V"])
def test_traced_times_or_supplies_are_told_by_jaxs_own_error(name: str) -> None:
    def run(traced: jax.Array) -> Trajectory:
        if name == "time":
            return simulate(platform(), traced, U)  # pyright: ignore[reportArgumentType]
        return simulate(platform(), T, {"voltage_V": U, "supply_V": traced})

    with pytest.raises(jax.errors.TracerArrayConversionError):
        jax.jit(run)(jnp.asarray(T))


SMOOTH = Smooth(0.01, diffrax.Tsit5())


@pytest.mark.parametrize("solver", [EXACT, pytest.param(SMOOTH, marks=pytest.mark.slow)], ids=["exact", "smooth"])
def test_a_run_goes_through_jit_and_vmap_with_the_values_of_one_by_one(solver: Solver) -> None:
    def run(I: jax.Array) -> Trajectory:
        return simulate(platform(), T, U, numbers={"axis.inertia": I}, start={"w": 1}, solver=solver)

    every = jax.jit(jax.vmap(run))(jnp.asarray([0.1, 0.2]))
    assert isinstance(every, Trajectory) and every.time.shape == (2, len(T))
    for k, I in enumerate((0.1, 0.2)):
        one = simulate(platform(), T, U, numbers={"axis.inertia": I}, start={"w": 1}, solver=solver)
        assert [*one] == [*every]
        for y in one:
            np.testing.assert_allclose(every[y][k], one[y], rtol=1e-6, atol=1e-9, err_msg=y)


@pytest.mark.slow
def test_a_whole_command_is_differentiated_through_the_smooth_solver_by_reverse_mode() -> None:
    time, solver = np.arange(81) * 0.01, Smooth(0.01, diffrax.Tsit5(), rtol=1e-9, atol=1e-11)
    u = jnp.asarray(0.5 * np.cos(time))

    def last(u: jax.Array) -> jax.Array:
        return simulate(platform("viscous = 0.02"), time, u, start={"w": 2.0}, solver=solver)["yaw_rad_s"][-1]

    # I w' = k u - b w: a sample held over a step h changes the end by k/b (1 - e^(-b h/I)) e^(-b (t_end - t - h)/I)
    left = time[-1] - time[:-1] - 0.01
    expected = 0.4 / 0.02 * (1.0 - np.exp(-0.2 * 0.01)) * np.exp(-0.2 * left)
    np.testing.assert_allclose(jax.jit(jax.grad(last))(u)[:-1], expected, rtol=1e-5)


@pytest.mark.slow
def test_a_duty_is_differentiable_beside_a_logged_supply() -> None:
    duty = 0.1 * np.sin(9.0 * T)

    def end(scale: jax.Array) -> jax.Array:
        columns = {"duty": scale * jnp.asarray(duty), "supply_V": np.full_like(T, 12.0)}
        return simulate(joint(), T, columns)["yaw_rad"][-1]

    one = jnp.ones(())
    assert abs(float(end(one))) > 1e-3
    assert float(jax.grad(end)(one)) == pytest.approx(float(end(one)), rel=1e-9)  # a linear joint
