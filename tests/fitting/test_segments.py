"""Which runs free runs can follow, by closed forms, and fits of those that none can."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, parse_rig
from rwjax.fitting.fit import fit
from rwjax.fitting.predict import predict
from rwjax.fitting.problem import pose
from rwjax.fitting.questions.ask import questions
from rwjax.fitting.segments import FOLLOWED, LONGEST_S, PIECE_S, WITHIN, said, segment_s, with_segments
from rwjax.logs.log import Segments
from rwjax.logs.segments import cut_up
from rwjax.plant.from_rig import structure_of
from rwjax.rig.model import Rig
from tests.systems import platform, record, wheel

TIME = np.arange(2001) * 0.01


def _pendulum(rate: float = 2.0, friction: float = 0.0, free: str = '"axis.inertia"') -> Rig:
    """A pendulum of 0.1 kg m2 with its angle from the top, which it leaves by exp(rate t)."""
    return parse_rig(
        f'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = {friction}\n'
        f"[axis.gravity]\ntorque = {0.1 * rate**2}\nangle = {np.pi}\n[fit]\nfree = [{free}]"
    )


def _growth(t: np.ndarray, rate: float) -> np.ndarray:
    """Largest singular value of the state transition of psi'' = rate² psi over `t`."""
    c, s = np.cosh(rate * t), np.sinh(rate * t)
    return np.linalg.norm(np.moveaxis(np.array([[c, s / rate], [rate * s, c]]), -1, 0), 2, axis=(1, 2))


@pytest.mark.parametrize("seconds", [20.0, 200.0])  # the longer one has more windows than places
def test_a_pendulum_on_its_top_is_followed_as_long_as_the_closed_form_allows(seconds: float) -> None:
    time = np.arange(0.0, seconds + 0.005, 0.01)
    (log,) = with_segments(_pendulum(), [record(time, 0.0 * time)])
    at = float(np.interp(WITHIN, _growth(TIME, 2.0), TIME))  # 2.6 s
    length = segment_s([log])
    assert length is not None and at - 0.17 < length <= at + 0.05  # windows of 0.16 s, two digits
    grown = float(said([log])[0].partition("grows ")[2].partition(" times")[0])
    pieces = np.ceil(seconds / PIECE_S)  # the last window of each ends after it
    assert 0.98 < grown / _growth(time, 2.0)[-1] < np.exp(2.0 * 0.17 * pieces)


def test_a_short_run_of_the_same_pendulum_is_followed_whole() -> None:
    end = int(np.interp(FOLLOWED, _growth(TIME, 2.0), np.arange(len(TIME))))
    for samples, whole in ((end - 20, True), (end + 40, False)):
        log = record(TIME[:samples], 0.0 * TIME[:samples])
        assert (segment_s(with_segments(_pendulum(), [log])) is None) == whole, samples


@pytest.mark.parametrize("angle", [0.0, 1.2 * np.sin(3.0 * TIME)])
def test_a_hanging_pendulum_is_followed_whole(angle: np.ndarray | float) -> None:
    hanging = _pendulum().with_values({"axis.gravity.angle": 0.0})
    logs = with_segments(hanging, [record(TIME, 0.0 * TIME, {"yaw_rad": angle + 0.0 * TIME})])
    assert segment_s(logs) is None and said(logs) == []


def test_a_run_of_hours_is_cut_even_where_nothing_grows() -> None:
    hour = np.arange(3600) * 1.0
    log = record(hour, 0.0 * hour, {"wheel_rad_s": 0.0 * hour})
    assert segment_s(with_segments(wheel(), [log])) == LONGEST_S
    assert segment_s(with_segments(wheel(), [record(TIME, 0.0 * TIME, {"wheel_rad_s": 0.0 * TIME})])) is None


def test_a_length_that_was_asked_for_is_taken_and_a_decision_is_kept() -> None:
    logs = with_segments(platform(), [record(TIME, 0.0 * TIME)], 5.0)
    assert segment_s(logs) == 5.0 and "as asked for" in said(logs)[0]
    assert with_segments(platform(), logs) == logs
    assert segment_s(with_segments(_pendulum(), [record(TIME, 0.0 * TIME)], np.inf)) is None


def test_numbers_of_every_run_stay_those_of_runs() -> None:
    rig = platform()
    logs = [replace(record(TIME, np.sin(TIME)), name=name, segments=Segments(6.0)) for name in ("a.csv", "b.csv")]
    problem = pose(structure_of(rig), cut_up(logs), per_run=("axis.inertia",))
    assert problem.names[-2:] == ("axis.inertia in a.csv", "axis.inertia in b.csv")
    inertia = problem.batch.theta_index[:, problem.structure.names.index("axis.inertia")]
    assert list(inertia - len(problem.structure.names)) == [0, 0, 0, 0, 1, 1, 1, 1]


def test_an_effects_own_state_is_sought_where_a_segment_begins_in_motion() -> None:
    rig = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[effects."axis.presliding"]\nM_c = 0.1\nx_s = 0.01\n'
        '[fit]\nfree = ["axis.inertia"]'
    )
    log = replace(record(TIME, np.sin(TIME), {"yaw_rad": np.sin(TIME)}), segments=Segments(6.0))
    problem = pose(structure_of(rig), cut_up([log]))
    own = [k for k, name in enumerate(problem.structure.states) if ":" in name]
    assert not problem.start_free[0, own].any() and problem.start_free[1:, own].all()


def balanced(seed: int, seconds: float = 12.0) -> Log:
    """A pendulum of 0.1 kg m2 and 2.5 N m kept on its top by feedback of noisy readings; by Runge and Kutta, apart from the library."""
    rng, n, dt = np.random.default_rng(seed), round(seconds / 0.01), 0.01
    x, u, y = np.array([0.05, 0.0]), np.zeros(n), np.zeros(n)

    def rates(x: np.ndarray, u: float) -> np.ndarray:
        return np.array([x[1], (0.4 * u + 2.5 * np.sin(x[0]) - 0.02 * x[1]) / 0.1])

    for k in range(n):
        y[k] = x[0]
        asked = 14.0 * (x[0] + rng.normal(0.0, 2e-3)) + 2.5 * x[1]
        u[k] = -asked + 1.5 * np.sin(0.03 * k) + np.sign(np.sin(0.011 * k))
        for _ in range(4):
            h = dt / 4
            a = rates(x, u[k])
            b = rates(x + h / 2 * a, u[k])
            c = rates(x + h / 2 * b, u[k])
            x = x + h / 6 * (a + 2 * b + 2 * c + rates(x + h * c, u[k]))
    return record(np.arange(n) * dt, u, {"yaw_rad": y + rng.normal(0.0, 1e-3, n)})


BALANCED = '"axis.inertia", "axis.friction.viscous", "axis.gravity.torque"'


def test_a_prediction_goes_on_from_segment_to_segment() -> None:
    rig, log = _pendulum(5.0, 0.02), balanced(0, 5.0)
    found = predict(rig, log)
    assert np.array_equal(found.time, log.time)
    error = found.columns["yaw_rad"] - log.outputs["yaw_rad"]
    assert float(np.std(error)) < 0.01
    ends = [float(np.std(error[k : k + 50])) for k in range(0, 500, 50)]
    assert max(ends[0::2]) < 1.5e-3 < max(ends[1::2])  # the start's half second, and what grows until the segment ends


def test_a_balanced_pendulum_asks_for_no_other_clock() -> None:
    rig = _pendulum(5.0, 0.02)
    assert questions(rig, with_segments(rig, [balanced(1, 5.0)], 1.0)) == []


@pytest.mark.slow
def test_a_balanced_pendulum_gives_its_numbers_where_a_whole_free_run_fails() -> None:
    truth = _pendulum(5.0, 0.02, BALANCED)
    believed = truth.with_values({name: 1.4 * truth.values[name] for name in truth.free})
    logs = [replace(balanced(seed), name=f"{seed}.csv") for seed in range(3)]
    found = fit(believed, logs)
    for name in truth.free:
        error = found.rig.standard_error[name]
        assert abs(found.rig.values[name] - truth.values[name]) < 4.0 * error < 0.1 * truth.values[name], name
    assert found.json()["segment_s"] == 1.0 and found.rms["yaw_rad"] < 1.5e-3
    whole = predict(truth, logs[0], segments=np.inf).columns["yaw_rad"]  # the start's error grows 1e26 times in 12 s
    assert float(np.std(whole - logs[0].outputs["yaw_rad"])) > 1.0
