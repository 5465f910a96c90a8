"""The floor and what counts as a repeated run."""

import numpy as np
import pytest

from rwjax.fitting.batched_runs import together
from rwjax.fitting.prediction import (
    Prediction,
    errors,
    every_output,
    floor_variance,
    predict_logs,
    predicted,
    repeatability,
)
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, reaction, record, run

TIME = np.arange(601) * 0.01


PUSH = 0.8 * np.sign(np.sin(2.0 * TIME + 0.1))


def moving(seed: int, speed: float = 1.0, noise: float = 1e-3):
    rig = platform()
    y = run(rig, record(TIME, PUSH), {"w": speed})["yaw_rad"]
    return record(TIME, PUSH, {"yaw_rad": y + np.random.default_rng(seed).normal(0.0, noise, len(y))})


def test_a_true_model_leaves_its_floor() -> None:
    rig = platform()
    structure = structure_of(rig)
    logs = tuple(moving(seed) for seed in range(12))
    problem = pose(structure, logs)
    found = predict_logs(problem, theta_of(rig, structure))
    floor = floor_variance(problem, found)
    left = np.mean(
        [np.mean((log.outputs["yaw_rad"] - p.outputs["yaw_rad"]) ** 2) for log, p in zip(logs, found, strict=True)]
    )
    promised = np.mean([np.mean(f["yaw_rad"]) for f in floor])
    assert left == pytest.approx(promised, rel=0.6)


def test_coast_downs_of_different_speed_do_not_repeat_one_another() -> None:
    rig = platform()
    still = np.zeros_like(TIME)
    coasts = tuple(
        record(TIME, still, {"yaw_rad": run(rig, record(TIME, still), {"w": w})["yaw_rad"]}) for w in (1.0, 2.0, 3.0)
    )
    assert repeatability(coasts) == {}
    u = np.where(TIME > 0.6, PUSH, 0.0)
    y = run(rig, record(TIME, u), {})["yaw_rad"]
    rng = np.random.default_rng(0)
    repeats = tuple(
        record(TIME, u, {"yaw_rad": y + 0.01 * rng.normal() * np.maximum(TIME - 0.6, 0.0)}) for _ in range(3)
    )
    scatter = [float(np.sqrt(np.mean(variance))) for _, variance in repeatability(repeats)["yaw_rad"]]
    assert 0.005 < scatter[0] < 0.1


def test_the_floor_is_noise_and_uncertain_start_in_closed_form() -> None:
    """A coasting axis is linear in its start: psi = psi0 + w0 (I/b)(1 - exp(-bt/I)), its rate the derivative."""
    rig, rng = platform("viscous = 0.02"), np.random.default_rng(1)
    decay = np.exp(-0.02 / 0.1 * TIME)
    by_start = {
        "yaw_rad": np.stack([np.ones_like(TIME), 5.0 * (1.0 - decay)], axis=1),
        "yaw_rad_s": np.stack([np.zeros_like(TIME), decay], axis=1),
    }
    noise = {"yaw_rad": 1e-3, "yaw_rad_s": 4e-3}
    for logged in (("yaw_rad",), ("yaw_rad", "yaw_rad_s")):
        read = {name: by_start[name] @ (0.3, 1.0) + rng.normal(0.0, noise[name], len(TIME)) for name in logged}
        problem = pose(structure_of(rig), (record(TIME, np.zeros_like(TIME), read),), noise)
        (found,) = predict_logs(problem, theta_of(rig, problem.structure))
        first = TIME <= 0.5
        known = sum(by_start[name][first].T @ by_start[name][first] / noise[name] ** 2 for name in logged)
        assert {*found.floor} == {*logged} == {*found.outputs}
        for name in logged:
            from_start = np.einsum("ta,ab,tb->t", by_start[name], np.linalg.inv(known), by_start[name])
            assert found.floor[name] == pytest.approx(np.sqrt(noise[name] ** 2 + from_start), rel=1e-5)
            assert np.max(np.abs(found.outputs[name] - by_start[name] @ found.start)) < 1e-8


def test_without_its_floor_a_prediction_is_the_same_and_takes_one_run() -> None:
    rig = reaction()
    u = 8.0 * PUSH
    start = {"w": 0.3, "i": 1.0}
    logs = [record(TIME, k * u, {"yaw_rad": run(rig, record(TIME, k * u), start)["yaw_rad"]}) for k in (1.0, 0.5)]
    problem = pose(structure_of(rig), logs, {"yaw_rad": 1e-3})
    theta, asked = theta_of(rig, problem.structure), []
    unknown = int(problem.start_free.any(axis=0).sum())

    def watched(with_floor: bool):
        steps, y = predicted(problem, theta, [1], with_floor=with_floor), None
        try:
            while True:
                asked.append(steps.send(y))
                y = yield asked[-1]
        except StopIteration as end:
            return end.value

    found = {}
    for with_floor, runs in ((False, 1), (True, 1 + unknown)):
        ((found[with_floor],),) = together([watched(with_floor)])
        assert (asked[-1].theta.shape, len(asked[-1].start)) == ((runs, len(theta)), runs)
        assert asked[-1].logs.tolist() == [1] and asked[-1].windows == problem.batch.windows
    assert found[False].floor == {} and found[True].floor.keys() == {"yaw_rad"} and found[True].log == 1
    for name, value in found[False].outputs.items():
        assert np.allclose(value, found[True].outputs[name], rtol=1e-9, atol=1e-12)
    assert found[True].floor["yaw_rad"].shape == TIME.shape and np.all(found[True].floor["yaw_rad"] >= 1e-3)


def test_where_a_run_leaves_the_range_of_numbers_the_floor_is_the_noise() -> None:
    rig, time = (
        platform("viscous = 0.02"),
        np.arange(300) * 0.005,
    )  # so fine that some readings are near the range's end
    y = 0.01 * np.random.default_rng(0).normal(size=len(time)) + time
    problem = pose(structure_of(rig), (record(time, np.zeros_like(time), {"yaw_rad": y}),), {"yaw_rad": 0.5})
    theta = theta_of(rig, problem.structure)
    theta[problem.structure.names.index("axis.friction.viscous")] = -100.0  # no rig's, but a search may try it
    (found,) = predict_logs(problem, theta)
    assert not np.isfinite(found.outputs["yaw_rad"]).all() and np.all(found.floor["yaw_rad"] == 0.5)


def test_the_scatter_of_repeats_is_that_about_their_mean_and_an_angle_begins_anywhere() -> None:
    u = np.where(TIME > 0.6, PUSH, 0.0)
    late = np.maximum(TIME - 0.6, 0.0)
    rng = np.random.default_rng(3)

    def log(k: int, begin: float, command: np.ndarray = u):
        read = {"yaw_rad": 7.0 * k + k**2 * late, "yaw_rad_s": 0.1 * k * late}
        return record(begin + TIME + rng.uniform(-2e-4, 2e-4, len(TIME)), command, read)

    alone = log(9, 0.0, 0.5 * u)
    found = repeatability((alone, log(0, 0.0), log(1, 100.0), log(2, 3.0)))
    assert {name: [k for k, _ in each] for name, each in found.items()} == {
        "yaw_rad": [1, 2, 3],
        "yaw_rad_s": [1, 2, 3],
    }
    for _, variance in found["yaw_rad"]:  # of 0, 1 and 4: mean 5/3, squared distances 25/9, 4/9 and 49/9
        assert variance == pytest.approx(13.0 / 3.0 * late**2, abs=1e-9)
    for _, variance in found["yaw_rad_s"]:
        assert variance == pytest.approx(0.01 * late**2, abs=1e-9)
    two = repeatability((log(0, 0.0), alone, log(1, 0.0)))
    assert [k for k, _ in two["yaw_rad"]] == [0, 2]
    assert two["yaw_rad"][0][1] == pytest.approx(0.5 * late**2, abs=1e-9)


def test_repeats_that_share_no_reading_of_an_output_still_repeat_in_others() -> None:
    u, late = np.where(TIME > 0.6, PUSH, 0.0), np.maximum(TIME - 0.6, 0.0)
    odd = np.arange(len(TIME)) % 2 == 1
    reads = [
        {"yaw_rad": np.where(odd == k, 0.0, np.nan), "yaw_rad_s": 0.1 * k * late, "wheel_rad": 0.0 * TIME}
        for k in (0, 1)
    ]
    found = repeatability(tuple(record(TIME, u, read) for read in reads))
    assert {*found} == {"yaw_rad_s", "wheel_rad"}
    assert found["yaw_rad_s"][0][1] == pytest.approx(0.005 * late**2)


def test_an_error_is_measured_minus_predicted() -> None:
    read = np.where(TIME == 1.0, np.nan, 2.0 * TIME)
    problem = pose(
        structure_of(platform()), [record(TIME, PUSH, {"yaw_rad": y}) for y in (TIME, read)], {"yaw_rad": 1.0}
    )
    outputs = {"yaw_rad": 0.5 * TIME, "yaw_rad_s": TIME}
    (found,) = errors(problem, [Prediction(1, outputs, np.zeros(2), {})])
    assert {*found} == {"yaw_rad"}
    assert np.array_equal(found["yaw_rad"], np.where(TIME == 1.0, np.nan, 1.5 * TIME), equal_nan=True)


@pytest.mark.parametrize("scatter", [0.1, 3.0])
def test_repeats_raise_a_floor_that_is_below_their_scatter(scatter: float) -> None:
    u = np.where(TIME > 0.6, PUSH, 0.0)
    rest = TIME <= 0.6
    reads = [np.where(rest, 0.0, sign * scatter / np.sqrt(2.0)) for sign in (1.0, -1.0)]
    reads[0][100] = reads[1][100] = np.nan
    problem = pose(structure_of(platform()), [record(TIME, u, {"yaw_rad": y}) for y in reads], {"yaw_rad": 1.0})
    floor = np.full(len(TIME), 0.5)
    (found,) = floor_variance(problem, [Prediction(1, {}, np.zeros(2), {"yaw_rad": floor})])
    expected = np.where(rest, 0.0, scatter**2)
    expected[100] = np.mean(np.delete(expected, 100))  # no reading: as large as elsewhere
    assert found["yaw_rad"] == pytest.approx(expected if scatter > 1.0 else floor**2)


def test_every_output_is_simulated_where_one_alone_is_logged() -> None:
    rig, command = platform("viscous = 0.05"), np.sin(3.0 * TIME)
    log = record(TIME, command)
    problem = pose(structure_of(rig), (log,), {"yaw_rad": 1.0})
    assert problem.structure.outputs == ("yaw_rad",) and problem.batch.reading.shape[-1] == 1
    (found,) = every_output(problem, theta_of(rig, problem.structure), np.zeros((1, 2)))
    both = dict.fromkeys(("yaw_rad", "yaw_rad_s"), np.zeros_like(TIME))
    exact = run(rig, record(TIME, command, both), {})
    for name in both:
        assert found[name] == pytest.approx(exact[name], abs=1e-9) and np.any(found[name])
