"""What logs cannot tell of free numbers, before anything is fitted."""

from dataclasses import replace

import numpy as np

from rwjax.fitting.questions.numbers import NothingTold, about_numbers, tells_something
from rwjax.logs.log import Log
from rwjax.rig.read import parse_rig
from rwjax.rig.write import write_rig
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


def test_a_rig_at_rest_tells_nothing_which_is_said_once() -> None:
    (said,) = about_numbers(RIG, [log(0.0 * U)])
    assert isinstance(said, NothingTold) and not tells_something(RIG, [log(0.0 * U)])
    assert said.startswith("these logs tell nothing of axis.inertia, axis.friction.viscous: use runs in which the")


def test_logs_that_tell_one_number_or_a_combination_tell_something() -> None:
    angle = parse_rig(write_rig(RIG) + "\n[axis.gravity]\ntorque = 0.0\nangle = 0.3\n")  # the direction of a load of 0
    for free in (("axis.inertia", "axis.gravity.angle"), (*RIG.free, "axis.friction.coulomb", "drive.gain")):
        rig = replace(angle, free=free)
        said = about_numbers(rig, [log(U)])
        assert said and not any(isinstance(one, NothingTold) for one in said) and tells_something(rig, [log(U)])


def test_a_number_on_its_bound_may_leave_a_trace_off_it() -> None:
    rig = replace(RIG, effects={"axis.presliding": {"s": 0.0}}, free=("axis.presliding.s",))
    assert about_numbers(rig, [log(U)]) == [] and tells_something(rig, [log(U)])
    both = replace(rig, free=("axis.presliding.s", "axis.inertia"))
    (said,) = about_numbers(both, [log(0.0 * U)])
    assert isinstance(said, NothingTold) and not tells_something(both, [log(0.0 * U)])


def test_where_nothing_is_free_nothing_is_said_to_be_silent() -> None:
    assert tells_something(replace(RIG, free=()), [log(0.0 * U)])
