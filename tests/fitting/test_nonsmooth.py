"""Secant steps of a nonsmooth cost."""

import numpy as np
import pytest

from rwjax.diagnosis.budget import Stopped
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.nonsmooth import beyond_stairs, leaves_no_trace, past_ridges, secant_steps, sticks
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from tests.fitting.heavier import believed_heavier
from tests.fitting.logs import log_of
from tests.fitting.moving_runs import SMOOTH, STEP_OF_COMMAND, starting_with_a_jump, with_jump
from tests.systems import platform, record, run


def test_secant_steps_heed_a_prior() -> None:
    problem, moves, theta = believed_heavier()
    begun = least_squares(problem, moves, theta, most_steps=0)
    found = secant_steps(begun)
    again = least_squares(problem, moves, found.theta, start=found.start, most_steps=0)
    assert found.cost < 0.2 * begun.cost and found.cost == pytest.approx(again.cost, rel=1e-9)
    assert found.theta[problem.names.index("axis.inertia")] == pytest.approx(0.12, rel=0.05)


def test_friction_in_proportion_to_the_load_sticks_like_any_other() -> None:
    smooth = platform("viscous = 0.02")
    problem = pose(structure_of(smooth).with_effects("axis.load_friction"), [log_of(smooth)])
    theta = np.zeros(len(problem.names))
    assert not sticks(problem, theta)
    theta[problem.names.index("axis.load_friction.mu")] = 0.1
    assert sticks(problem, theta)


def test_a_fit_goes_on_where_a_threshold_lies_between_two_commands() -> None:
    problem = starting_with_a_jump(0.25)
    theta, moves = with_jump(problem, 0.2)
    found = least_squares(problem, moves, theta)
    assert leaves_no_trace(found) and found.cost > 1e3 and not sticks(problem, found.theta)
    assert past_ridges(found).cost < 1e-3
    smooth, moves, theta = believed_heavier()
    assert not leaves_no_trace(least_squares(smooth, moves, theta, most_steps=0))


@pytest.mark.parametrize(("jump", "begun"), [(0.1, 0.4), (0.4, 0.25), (0.0, 0.6)])
def test_a_number_without_trace_is_found_many_steps_of_its_stairs_away(jump: float, begun: float) -> None:
    problem = starting_with_a_jump(jump)
    theta, moves = with_jump(problem, begun)
    found = least_squares(problem, moves, theta)
    assert found.cost > 1e3 and leaves_no_trace(found)
    better = beyond_stairs(found)
    assert better.cost < 1e-3
    assert better.theta[moves.index[0]] == pytest.approx(jump, abs=STEP_OF_COMMAND)


@pytest.mark.parametrize(("peak", "begun"), [(4.0, 0.06), (2.0, 0.14), (2.0, 0.3)])
def test_it_is_found_too_where_the_other_numbers_have_settled_on_another_step(peak: float, begun: float) -> None:
    """Every command that is lost or kept turns the axis to another place for good, so that the cost goes up and down from step to step."""
    t = np.arange(1100) * 0.01
    triangles = peak * 2.0 / np.pi * np.arcsin(np.sin((0.5 if peak > 3.0 else 0.8) * t)) * (1.0 + t / 220.0)
    log = record(t, np.where(t > 0.6, triangles, 0.0))
    y = run(SMOOTH, log, {}, effects={"drive.deadzone": {"j": 0.1}})
    structure = structure_of(SMOOTH).with_effects("drive.deadzone")
    problem = pose(structure, [record(t, log.command, {"yaw_rad": y["yaw_rad"]})], {"yaw_rad": 1e-4})
    theta, jump = theta_of(SMOOTH, structure), structure.names.index("drive.deadzone.j")
    theta[jump] = begun
    free = np.isin(structure.names, ("axis.inertia", "axis.friction.viscous", "drive.deadzone.j"))
    moves = coordinates(theta, free, bounds_of(SMOOTH, structure), np.maximum(np.abs(theta), 0.01))
    found = least_squares(problem, moves, theta)
    assert found.cost > 1e3 and leaves_no_trace(found)
    better, sizes = beyond_stairs(found), np.unique(np.abs(log.command))
    assert better.cost < 1e-3
    middle = (sizes[sizes < 0.1][-1] + sizes[sizes > 0.1][0]) / 2.0
    assert better.theta[jump] == pytest.approx(middle, rel=0.01)


def wide_steps(begun: float, prior: dict[str, tuple[float, float]] | None = None) -> Fit:
    """A fit, begun at a jump [V], to a run whose commands lie 0.2 V apart, of a drive whose jump of 0.3 V lies between two of them."""
    t = np.arange(600) * 0.01
    log = record(t, np.where(t > 0.6, 0.2 * np.round(8.0 * np.sin(1.7 * t)), 0.0))
    y = run(SMOOTH, log, {}, effects={"drive.deadzone": {"j": 0.3}})
    structure = structure_of(SMOOTH).with_effects("drive.deadzone")
    problem = pose(structure, [record(t, log.command, {"yaw_rad": y["yaw_rad"]})], {"yaw_rad": 1e-3}, prior=prior or {})
    return least_squares(problem, *reversed(with_jump(problem, begun)))


@pytest.mark.parametrize("begun", [0.05, 0.21, 0.3, 0.38, 0.9])
def test_it_has_the_middle_of_its_step_however_wide(begun: float) -> None:
    found = beyond_stairs(wide_steps(begun))
    assert found.cost < 1e-3 and found.numbers()["drive.deadzone.j"] == pytest.approx(0.3, rel=0.03)


def test_it_is_not_moved_away_from_what_is_known_of_it() -> None:
    found = wide_steps(0.212, {"drive.deadzone.j": (0.212, 1e-4)})
    better = beyond_stairs(found)
    assert better.cost <= found.cost < 1e-3 and better.numbers()["drive.deadzone.j"] == pytest.approx(0.212, abs=1e-3)


def test_the_search_can_be_ended_between_any_few_runs() -> None:
    asked = [0]

    def check() -> None:
        asked[0] += 1
        if asked[0] > 3:
            raise Stopped

    with pytest.raises(Stopped):
        beyond_stairs(wide_steps(0.9), check)


def test_a_number_that_may_as_well_be_0_is_0() -> None:
    problem = starting_with_a_jump(0.0)
    theta, moves = with_jump(problem, 0.2 * STEP_OF_COMMAND)
    assert least_squares(problem, moves, theta).theta[moves.index[0]] > 0.0
    found = beyond_stairs(least_squares(problem, moves, theta))
    assert found.theta[moves.index[0]] == 0.0 and found.cost < 1e-3


def test_a_fit_whose_numbers_all_leave_a_trace_stays_what_it_is() -> None:
    smooth, moves, theta = believed_heavier()
    found = least_squares(smooth, moves, theta)
    assert beyond_stairs(found) is found


@pytest.mark.parametrize("limit", [30.0, 1e6])
def test_a_number_of_which_the_logs_tell_nothing_stays_though_the_other_numbers_settle_further(limit: float) -> None:
    """A limit far above all commands, beside a drag that the rig does not have."""
    rig, t = platform("viscous = 0.02"), 0.01 * np.arange(600)
    log = record(t, np.where(t > 0.6, np.sign(np.sin(2.0 * t)) + 0.3 * np.sin(5.0 * t), 0.0))
    y = run(rig, log, {}, effects={"axis.quadratic_drag": {"c": 0.02}})["yaw_rad"]
    structure = structure_of(rig).with_effects("drive.saturation")
    problem = pose(structure, [record(t, log.command, {"yaw_rad": y})], {"yaw_rad": 1e-3})
    free = np.isin(structure.names, ("axis.inertia", "axis.friction.viscous", "drive.saturation.u_m"))
    theta = np.where(np.array(structure.names) == "drive.saturation.u_m", limit, theta_of(rig, structure))
    moves = coordinates(theta, free, bounds_of(rig, structure), np.maximum(np.abs(theta), 0.01))
    found = least_squares(problem, moves, theta)
    assert leaves_no_trace(found) and beyond_stairs(found).numbers()["drive.saturation.u_m"] == limit


def test_a_number_that_nothing_tells_stays_what_it_is() -> None:
    problem = starting_with_a_jump(0.1)
    theta, _ = with_jump(problem, 0.1)
    at = {name: k for k, name in enumerate(problem.structure.names)}
    theta[at["drive.gain"]] = 0.0  # so that the lost command shows in no reading
    free = np.array([name == "drive.deadzone.u_0" for name in at])
    moves = coordinates(theta, free, bounds_of(platform(), problem.structure), np.full(len(theta), 0.25))
    theta[at["drive.deadzone.u_0"]] = 0.2
    begun = least_squares(problem, moves, theta)
    assert leaves_no_trace(begun)
    assert beyond_stairs(begun).theta[at["drive.deadzone.u_0"]] == 0.2
