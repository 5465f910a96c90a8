"""What logs cannot tell of free numbers, before anything is fitted."""

from dataclasses import replace

import numpy as np

from rwjax.fitting.questions.numbers import NOTHING, about_numbers
from rwjax.logs.log import Log
from rwjax.rig.read import parse_rig
from rwjax.simulation.simulate import simulate

RIG = parse_rig(
    'kind = "platform"\ndrive.gain = 0.4\naxis.inertia = 0.1\naxis.friction = { viscous = 0.05, coulomb = 0.02 }\n'
    'fit.free = ["axis.inertia", "axis.friction.viscous"]'
)
T = np.arange(600) * 0.01
U = np.where(T > 0.6, 2.0 * np.sign(np.sin(2.0 * T + 0.1)), 0.0)


def log(command: np.ndarray) -> Log:
    y = np.asarray(simulate(RIG, T, command)["yaw_rad"]) + 1e-4 * np.random.default_rng(1).normal(size=len(T))
    return Log("run", T, command, {"yaw_rad": y}, {"yaw_rad": 0.0}, {}, False, None, 0.0)


def test_a_run_that_moves_tells_inertia_and_friction() -> None:
    assert about_numbers(RIG, [log(U)]) == []
    assert about_numbers(replace(RIG, free=()), [log(U)]) == []


def test_gain_inertia_and_friction_are_known_up_to_a_factor() -> None:
    """All torques may be multiplied by the same number."""
    free = ("drive.gain", "axis.inertia", "axis.friction.viscous", "axis.friction.coulomb")
    (said,) = about_numbers(replace(RIG, free=free), [log(U)])
    assert said.startswith("only a combination of ") and all(name in said for name in free) and said.endswith("fix one")


def test_a_rig_at_rest_tells_nothing() -> None:
    said = about_numbers(RIG, [log(0.0 * U)])
    assert any(
        one.startswith("a small change of axis.inertia leaves no trace in these logs") or "only a combination" in one
        for one in said
    )


def test_one_sentence_says_that_no_number_is_told() -> None:
    rig = replace(RIG, free=("axis.inertia", "axis.friction.viscous"))
    (said,) = (one for one in about_numbers(rig, [log(0.0 * U)]) if one.startswith(NOTHING))
    assert said.startswith(f"{NOTHING} axis.inertia, axis.friction.viscous: use runs in which the command changes")
    assert not any(one.startswith(NOTHING) for one in about_numbers(rig, [log(U)]))
