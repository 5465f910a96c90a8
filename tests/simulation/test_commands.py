"""The command as it acts: delays, and what was commanded before the log."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.batch import WITHOUT_LOG_AXIS, Batch, by_sample
from rwjax.simulation.commands import commands, each_window, given, whole_log
from rwjax.simulation.layout import lay_out
from rwjax.simulation.windows import plant_of_run, side_by_side
from tests.joints import GAINS, joint, servo
from tests.systems import platform, record, run
from tests.two_axes import two_axis

TIME = np.arange(201) * 0.01


def acting(rig, log: Log, effects: dict[str, dict[str, float]]) -> tuple[Batch, np.ndarray, np.ndarray]:
    """The log laid out, the voltage over every step `(s, …)` and at every sample `(n, …)` [V]."""
    structure = structure_of(rig).with_effects(*effects)
    theta = theta_of(rig, structure)
    for effect, numbers in effects.items():
        for name, value in numbers.items():
            theta[structure.names.index(f"{effect}.{name}")] = value
    batch = lay_out(structure, [log], [dict.fromkeys(log.outputs, 1.0)])

    @jax.jit
    def all_logs(theta):
        return side_by_side(lambda run: commands(plant_of_run(structure, theta, run), run)(whole_log(run)), batch)

    steps, seen = (np.asarray(one)[0] for one in all_logs(jnp.asarray(theta)))
    of_window = seen.reshape(*batch.slot_step.shape[1:], *seen.shape[1:])
    return batch, steps, by_sample(batch, 0, of_window, len(log.time))


def mean(t: np.ndarray, u: np.ndarray, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Mean of a command that is held between its samples, the first before them and the last after them."""
    edges = np.concatenate([[-1e3], t[1:], [1e3]])
    overlap = np.minimum(end[:, None], edges[1:]) - np.maximum(begin[:, None], edges[:-1])
    return np.maximum(overlap, 0.0) @ u / (end - begin)


@pytest.mark.parametrize("late", [{}, {"drive.delay": {"tau": 0.0437}}], ids=["at once", "late"])
@pytest.mark.parametrize("overlap", [{}, {"sensor.delay": {"tau": 0.1}}], ids=["", "windows overlap"])
@pytest.mark.parametrize("cut", [0, pytest.param(50, marks=pytest.mark.slow)])
def test_steps_and_readings_see_the_mean_of_the_held_command(late: dict, overlap: dict, cut: int) -> None:
    rng = np.random.default_rng(2)
    t = np.cumsum(rng.choice([0.0021, 0.01, 0.0173, 0.05], 150))
    u = rng.normal(size=len(t))
    log = record(t, u, {"yaw_rad_s": np.zeros_like(t)}).cut(cut, len(t))
    batch, steps, seen = acting(platform(), log, late | overlap)
    h, tau = batch.h[0], late.get("drive.delay", {}).get("tau", 0.0)
    grid = log.time[0] + h * np.arange(len(steps) + 1) - tau
    assert len(steps) == len(batch.step_index) * batch.windows + len(batch.overlap_index)
    assert steps == pytest.approx(mean(t, u, grid[:-1], grid[1:]), abs=1e-9)
    at = log.time - tau
    assert seen == pytest.approx(mean(t, u, at, at + min(h, np.diff(log.time).min())), abs=1e-9)


@pytest.mark.parametrize("late", [{}, {"drive.delay": {"tau": 0.0011}}], ids=["at once", "late"])
def test_of_many_samples_within_a_step_all_are_seen(late: dict) -> None:
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.choice([1e-5, 2e-5, 7e-5, 4e-4], 400))
    u = rng.normal(size=len(t))
    batch, steps, seen = acting(platform(), record(t, u, {"yaw_rad": np.zeros_like(t)}), late)
    h, tau = batch.h[0], late.get("drive.delay", {}).get("tau", 0.0)
    assert len(batch.sample_index) > 40
    grid = t[0] + h * np.arange(len(steps) + 1) - tau
    assert steps == pytest.approx(mean(t, u, grid[:-1], grid[1:]), abs=1e-9)
    at, width = t - tau, min(h, np.diff(t).min())
    assert seen == pytest.approx(mean(t, u, at, at + width), abs=1e-9 * h / width)


@pytest.mark.parametrize("pace", [1.0, 0.9])
def test_a_lag_runs_in_the_time_of_the_rig_and_a_reading_sees_what_is_there_at_its_time(pace: float) -> None:
    u = np.where(TIME >= 0.05, 1.0, 0.0)
    log = record(TIME, u, {"yaw_rad_s": np.zeros_like(TIME)})
    effects = {"drive.lag": {"T": 0.04, "q": 0.0}, "sensor.clock": {"e": 1.0 - pace}}
    batch, steps, seen = acting(platform(), log, effects)
    assert batch.h[0] == pytest.approx(0.005)
    edges = np.maximum(pace * (0.005 * np.arange(len(steps) + 1) - 0.05), 0.0)
    area = edges - 0.04 * (1.0 - np.exp(-edges / 0.04))  # of 1 - exp(-t/T)
    assert steps == pytest.approx(np.diff(area) / (0.005 * pace), abs=1e-9)
    there = 1.0 - np.exp(-pace * np.maximum(TIME - 0.05, 0.0) / 0.04)
    assert seen == pytest.approx(
        there, abs=0.005 * 0.01 / 0.04
    )  # as it is over a hundredth of a step behind each sample


def test_a_lag_is_seen_between_the_grid_points_too_and_one_of_no_time_acts_at_once() -> None:
    t = np.cumsum(np.tile([0.01, 0.013, 0.0071], 40))
    u = np.where(t >= t[30], 1.0, 0.0)
    log = record(t, u, {"yaw_rad_s": np.zeros_like(t)})
    seen = acting(platform(), log, {"drive.lag": {"T": 0.02, "q": 0.0}})[2]
    assert seen == pytest.approx(1.0 - np.exp(-np.maximum(t - t[30], 0.0) / 0.02), abs=0.005)
    for effect in ({"drive.lag": {"T": 0.0, "q": 0.0}}, {"drive.rate_limit": {"r": 1e12}}):
        seen = acting(platform(), log, effect)[2]
        assert seen == pytest.approx(u, abs=1e-7)


def test_of_a_lag_behind_a_rate_limit_a_reading_sees_what_shorter_steps_see() -> None:
    row = {"drive.rate_limit": {"r": 20.0}, "drive.lag": {"T": 0.015, "q": 0.6}}
    u = np.where(TIME % 0.3 < 0.15, 1.0, -0.4)
    fine = np.arange(20 * (len(TIME) - 1) + 1) * 0.0005
    held = u[np.minimum(np.floor(fine / 0.01 + 1e-9).astype(int), len(u) - 1)]
    logs = (record(t, c, {"yaw_rad_s": np.zeros_like(t)}) for t, c in ((TIME, u), (fine, held)))
    coarse, exact = (acting(platform(), log, row)[2] for log in logs)
    assert np.abs(coarse - exact[::20]).max() < 0.03 < 0.5 < np.abs(coarse - u).max()


def test_each_axis_has_its_own_command() -> None:
    u = np.stack([np.sin(9.0 * TIME), np.cos(7.0 * TIME)], axis=1)
    _, steps, seen = acting(two_axis(), record(TIME, u, {"yaw_rad_s": np.zeros_like(TIME)}), {})
    assert np.allclose(seen, u, atol=1e-12)
    assert np.allclose(steps[: 2 * len(TIME)], np.repeat(u, 2, axis=0), atol=1e-9)


def test_a_delay_of_whole_samples_shifts_the_command() -> None:
    t = np.arange(501) * 0.01
    u = np.sign(np.sin(3.0 * t))
    late = np.concatenate([np.full(4, u[0]), u[:-4]])
    delayed = run(platform(), record(t, u), {}, effects={"drive.delay": {"tau": 0.04}})
    assert np.max(np.abs(delayed["yaw_rad"] - run(platform(), record(t, late), {})["yaw_rad"])) < 1e-9


def test_a_small_change_of_delay_moves_the_motion_continuously() -> None:
    u = np.sign(np.sin(3.0 * TIME + 0.1))
    runs = [
        run(platform("viscous = 0.02"), record(TIME, u), {}, effects={"drive.delay": {"tau": tau}})["yaw_rad"]
        for tau in (0.0149, 0.015, 0.0151)  # across a grid point
    ]
    steps = [np.max(np.abs(b - a)) for a, b in zip(runs[:-1], runs[1:], strict=True)]
    # moving jumps of 0.8 N m by 0.1 ms changes w by 0.8 mrad/s; the angle by at most that times 2 s and the jumps
    assert steps[0] == pytest.approx(steps[1], rel=0.02) and 1e-5 < steps[0] < 5e-3


def test_before_the_log_the_first_command_counts_as_held() -> None:
    late = run(platform(), record(TIME, np.full_like(TIME, 0.7)), {}, effects={"drive.delay": {"tau": 0.0437}})
    plain = run(platform(), record(TIME, np.full_like(TIME, 0.7)), {})
    assert np.max(np.abs(late["yaw_rad"] - plain["yaw_rad"])) < 1e-12 * np.ptp(plain["yaw_rad"]) * len(TIME)


def test_a_delayed_command_from_before_a_cut_still_arrives() -> None:
    rig = platform()
    t = np.arange(1001) * 0.01
    u = np.where(t < 5.0, 0.5, -0.8)
    effects = {"drive.delay": {"tau": 0.3}}
    whole = record(t, u)
    y = run(rig, whole, {}, effects=effects)
    cut = 510  # 0.1 s after the command changed, 0.2 s before it acts
    part = whole.cut(cut, len(t))
    start = {"psi": float(y["yaw_rad"][cut]), "w": float(y["yaw_rad_s"][cut])}
    assert run(rig, part, start, effects=effects)["yaw_rad"] == pytest.approx(y["yaw_rad"][cut:], abs=1e-9)


OFF = {"enabled": np.sin(9.0 * TIME) > -0.3}
GOAL = {"input": "goal_rad", "origin": -0.0013}
BY_DUTY = servo(joint(), acts_on="duty", **GAINS)
LATE, READ_LATE, SLOW = {"drive.delay": {"tau": 0.0123}}, {"sensor.delay": {"tau": 0.1}}, {"sensor.clock": {"e": 0.02}}
COMMANDED = {
    "a command": (platform(), {}, {}),
    "a late one": (platform(), LATE | READ_LATE | SLOW, {}),
    "one that lags": (platform(), {"drive.lag": {"T": 0.04, "q": 0.0}} | READ_LATE, {}),
    "two commands": (two_axis(), READ_LATE, {}),
    "torque off at times": (joint(), READ_LATE, OFF),
    "a goal": (servo(joint(), **GAINS), {}, GOAL),
    "a late goal": (servo(joint(), **GAINS), LATE | SLOW, GOAL | OFF),
    "a goal and the supply": (BY_DUTY, {}, GOAL | {"supply": 7.0 + np.sin(TIME)}),
}


LONGER = ("two commands", "a goal", "a goal and the supply")  # to compile than those that they are like


@pytest.mark.parametrize("case", [pytest.param(c, marks=pytest.mark.slow) if c in LONGER else c for c in COMMANDED])
def test_each_window_is_told_what_the_whole_log_has_there(case: str) -> None:
    rig, effects, more = COMMANDED[case]
    u = np.random.default_rng(5).normal(size=(len(TIME), 2) if rig.kind == "two_axis" else len(TIME))
    rig, (log,) = driven(rig, [record(TIME, u, **more)])
    structure = structure_of(rig).with_effects(*effects)
    theta = dict(zip(structure.names, theta_of(rig, structure), strict=True))
    theta |= {f"{effect}.{name}": value for effect, own in effects.items() for name, value in own.items()}
    batch = lay_out(structure, [log], [{"yaw_rad": 1.0}])
    one = Batch(*(v if k in WITHOUT_LOG_AXIS else v[0] for k, v in batch._asdict().items()))

    @jax.jit
    def told(numbers: jnp.ndarray) -> tuple:
        acts = given(plant_of_run(structure, numbers, one), one)
        return acts(whole_log(one)), jax.vmap(acts)(each_window(one))

    (whole, at_reading), (steps, seen) = told(jnp.asarray([*theta.values()]))
    there = each_window(one).points[:, :-1]
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b[there], rtol=0.0, atol=1e-9), steps, whole)
    np.testing.assert_allclose(seen, at_reading.reshape(seen.shape), rtol=0.0, atol=1e-9)
    if structure.servo is not None:  # what is logged holds from its sample on
        begin = float(one.h) * np.arange(len(whole.supply)) + 1e-9
        sample = np.minimum(np.searchsorted(TIME, begin, side="right") - 1, len(TIME) - 1)
        assert np.array_equal(whole.supply, np.ones_like(TIME)[sample] if log.supply is None else log.supply[sample])
        assert np.array_equal(whole.on, np.ones(len(begin), bool) if log.enabled is None else log.enabled[sample])
