"""Whether a motion has anything to do with its command, of systems that are no rig's model."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rwjax.fitting.questions.driven import coherent_share, driven_share
from rwjax.logs.log import Log
from tests.systems import record

TIME = np.arange(2000) * 0.01
RANDOM = np.random.default_rng(1).choice([-1.0, 0.0, 1.0], 100)[(TIME / 0.2).astype(int)]
OTHER = np.random.default_rng(2).choice([-1.0, 0.0, 1.0], 100)[(TIME / 0.2).astype(int)]


def pendulum(start: float, gain: float) -> Log:
    """A pendulum that turns over or swings, under a torque and a controller that holds it against the torque."""

    def motion(t: float, x: np.ndarray) -> list[float]:
        u = RANDOM[min(int(t / 0.01), len(RANDOM) - 1)] - gain * x[0]
        return [x[1], 4.0 * u - 9.0 * np.sin(x[0]) - 0.1 * x[1]]

    x = solve_ivp(motion, (0.0, TIME[-1]), [start, 0.0], t_eval=TIME, max_step=0.01).y
    return record(TIME, RANDOM - gain * x[0], {"yaw_rad": x[0], "yaw_rad_s": x[1]})


@pytest.mark.parametrize(("start", "gain"), [(0.0, 0.0), (np.pi, 0.0), (0.3, 5.0)])
def test_a_command_drives_a_pendulum_that_hangs_turns_over_or_is_held(start: float, gain: float) -> None:
    assert driven_share(pendulum(start, gain)) > 0.9


def test_the_command_of_another_run_does_not() -> None:
    log = pendulum(0.0, 0.0)
    wrong = record(TIME, OTHER, log.outputs)
    assert driven_share(wrong) < 0.35 and coherent_share(wrong) < 0.25 < coherent_share(log)


def test_coherence_is_one_for_what_is_linear_in_the_command() -> None:
    smooth = np.convolve(RANDOM, np.exp(-np.arange(100) / 20.0))[: len(TIME)]
    noise = np.random.default_rng(3).normal(size=len(TIME))
    assert coherent_share(record(TIME, RANDOM, {"yaw_rad_s": smooth})) > 0.9
    assert coherent_share(record(TIME, RANDOM, {"yaw_rad_s": noise})) < 0.25


@pytest.mark.parametrize("command", [np.full(2000, 3.0), np.where(TIME < 5.0, 0.0, 3.0)])
def test_a_command_that_hardly_changes_says_nothing(command: np.ndarray) -> None:
    log = record(TIME, command, {"yaw_rad_s": np.random.default_rng(3).normal(size=len(TIME))})
    assert driven_share(log) == coherent_share(log) == 1.0


def test_a_short_log_says_nothing() -> None:
    log = record(TIME[:200], RANDOM[:200], {"yaw_rad_s": OTHER[:200]})
    assert driven_share(log) == coherent_share(log) == 1.0


def test_a_log_of_many_samples_in_a_few_ms_says_nothing() -> None:
    log = pendulum(0.0, 0.0)
    fast = record(1e-3 * TIME, log.command, log.outputs)
    assert driven_share(fast) == coherent_share(fast) == 1.0
