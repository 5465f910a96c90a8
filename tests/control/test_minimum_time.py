"""The search for the least time, on a manoeuvre with a closed form: a free platform turned from rest to rest."""

import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from rwjax import parse_rig
from rwjax.control.drive_limits import Limits
from rwjax.control.minimum_time import (
    PIECES,
    REACHED,
    SEARCH,
    STEPS,
    Guess,
    Manoeuvre,
    Task,
    least_in_pieces,
    minimum_time,
)
from rwjax.control.open_loop import Trajectory
from rwjax.plant.from_rig import structure_of, theta_of

RIG = parse_rig('kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1')
ANGLE, VOLTS = 0.5, 2.0
LEAST = 2.0 * np.sqrt(ANGLE / (4.0 * VOLTS))  # s: 4 rad/s2 per V, half the way each


def _there(found: Trajectory, numbers: Array) -> tuple[Array, Array]:
    """The axis rests at its angle."""
    return jnp.stack([found.angle[-1] / numbers[0] - 1.0, found.rate[-1] * numbers[1] / numbers[0]]), jnp.zeros(0)


def _task(angle: float, seconds: float) -> Task:
    structure = structure_of(RIG)
    theta, rest = jnp.asarray(theta_of(RIG, structure)), jnp.zeros(len(structure.states))
    return Task(theta, Limits(VOLTS), jnp.array([angle, LEAST]), rest, seconds, 1.0)


@pytest.mark.slow
def test_a_free_platform_turns_by_full_command_one_way_and_the_other() -> None:
    guess = Guess(np.where(np.arange(PIECES + 1) < PIECES / 2, 0.6, -0.6) * VOLTS, VOLTS)
    best, missed = minimum_time(Manoeuvre(structure_of(RIG), _there, PIECES), _task(ANGLE, 1.4 * LEAST), guess)
    assert missed == 0.0
    assert float(best.angle[-1]) == pytest.approx(ANGLE, rel=REACHED)
    assert abs(float(best.rate[-1])) * LEAST / ANGLE < REACHED
    # one piece of 30 in which the command changes its sign takes a little longer than a jump
    assert LEAST * (1.0 - REACHED) < float(best.time[-1]) < 1.01 * LEAST
    assert np.max(np.abs(best.command)) <= VOLTS


def test_a_manoeuvre_without_a_way_says_how_far_it_falls_short() -> None:
    def never(found: Trajectory, numbers: Array) -> tuple[Array, Array]:
        return jnp.zeros(1), jnp.array([-1.0])

    guess = Guess(np.zeros(PIECES + 1), VOLTS)
    told: list[str] = []
    _, missed = minimum_time(Manoeuvre(structure_of(RIG), never, PIECES), _task(ANGLE, LEAST), guess, told.append)
    assert missed == pytest.approx(1.0)
    assert told[0] == "looking for the least time: search 1 of 4 at most, step 1 of 200 at most"


def test_the_steps_of_a_search_are_counted_and_none_is_said_beyond_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SEARCH, "maxiter", 3)
    guess = Guess(np.where(np.arange(PIECES + 1) < PIECES / 2, 0.6, -0.6) * VOLTS, VOLTS)
    told: list[str] = []
    minimum_time(Manoeuvre(structure_of(RIG), _there, PIECES), _task(ANGLE, 1.4 * LEAST), guess, told.append)
    begin = "looking for the least time: search 1 of 4 at most, step"
    assert [line for line in told if line.startswith(begin)] == [f"{begin} {k} of 3 at most" for k in (1, 2, 3, 3)]


def test_commands_run_straight_between_their_values() -> None:
    z = np.append(np.linspace(-1.0, 1.0, PIECES + 1), 1.5)
    commands, seconds = _task(ANGLE, 2.0).scaled(jnp.asarray(z))
    middle = (np.arange(PIECES * STEPS) + 0.5) / (PIECES * STEPS)
    assert np.asarray(commands) == pytest.approx(VOLTS * (2.0 * middle - 1.0)) and float(seconds) == 3.0


def test_the_least_of_a_piece_counts_both_its_ends() -> None:
    values = np.ones(PIECES * STEPS + 1)
    values[STEPS] = 0.5  # the end of the first piece and the beginning of the second one
    values[5 * STEPS + 3] = 0.2
    found = np.asarray(least_in_pieces(jnp.asarray(values)))
    assert found[[0, 1, 5]].tolist() == [0.5, 0.5, 0.2] and np.sum(found != 1.0) == 3
