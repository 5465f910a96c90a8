"""All questions about logs, against free runs with the rig file's own numbers."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from rwjax.errors import LogError, refuses_other_types
from rwjax.fitting.initial_guess import START_S
from rwjax.fitting.problem import Problem, pose
from rwjax.fitting.questions.after_a_fit import about_what_a_fit_leaves
from rwjax.fitting.questions.angles import about_degrees, from_degrees
from rwjax.fitting.questions.clock import about_clock
from rwjax.fitting.questions.command import about_fractions, about_other_runs, about_pulses
from rwjax.fitting.questions.free_runs import free_runs, logs_read, numbers_of_runs
from rwjax.fitting.questions.likeness import Question, Run
from rwjax.fitting.questions.rates import about_rates
from rwjax.fitting.questions.readings import IN_MILLI, about_readings
from rwjax.fitting.questions.servo import about_servos
from rwjax.fitting.questions.signs import about_lost_signs
from rwjax.logs.driven import driven
from rwjax.logs.dropouts import dropouts, without_dropouts
from rwjax.logs.findings import leaping
from rwjax.logs.log import Log
from rwjax.logs.segments import cut_up, runs_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig


@refuses_other_types
def questions(rig: Rig, logs: Sequence[Log]) -> list[Question]:
    """Questions to ask before a rig's numbers are fitted to logs, or a gap between them is searched.

    A fit bends the numbers where a log is in other units, of another clock, or of another run, and a diagnosis names an
    effect that is not there.

    Args:
        rig: The rig as its file has it.
        logs: The logs, at least one.

    Returns:
        The questions, one sentence each; none where the logs are roughly what the rig file's numbers give.

    Raises:
        LogError: There is no log.
        InputError: An argument is of another type.
    """
    if not logs:
        raise LogError("no log to ask about; give at least one")
    how, runs = driven(rig, logs)
    structure = structure_of(how)
    return ask(pose(structure, cut_up(runs)), theta_of(how, structure)) or about_what_a_fit_leaves(rig, logs)


def ask(problem: Problem, theta: np.ndarray) -> list[Question]:
    """`questions` about a problem that is already posed.

    Args:
        problem: Logs and structure.
        theta: The rig file's own numbers `(t,)` [SI].

    Returns:
        The questions, one sentence each.
    """
    dropped, problem, theta = _without_dropouts(problem, theta)
    outputs = problem.structure.outputs
    if leap := [Question(f"{log.name}: {says}") for log in logs_read(problem) for says in leaping(log, outputs)]:
        return [*dropped, *leap]  # behind which no free run is near
    if contradicted := about_servos(logs_read(problem), problem.structure.unsigned):
        return [*dropped, *contradicted]  # no simulation tells more of readings that contradict one another
    runs = free_runs(problem, theta, problem.batch, problem.start)
    if unsigned := about_lost_signs(runs):
        problem, theta = _posed_anew(problem, theta, logs_read(problem), unsigned)
        runs = free_runs(problem, theta, problem.batch, problem.start)
    if fractions := about_fractions(runs):  # beside which every reading is too large, and in no unit
        return [*dropped, *unsigned.values(), *fractions]
    whole = not any(
        log.goes_on for log in problem.logs
    )  # in less time a segment hardly leaves its start: no sign of a clock
    clocks = about_clock(runs, lambda factor: _in_time(problem, theta, factor)) if whole else {}
    pulses = about_pulses(runs, lambda volts: _under(problem, theta, volts))
    explained = {k for numbers in (*clocks.values(), *pulses.values()) for k in numbers}
    readings = about_readings(runs)
    asks = "psi" in problem.structure.angles and not explained and not readings  # else a run may begin at any angle
    degrees = about_degrees(runs, lambda: _in_rad(problem, theta)) if asks else []
    if degrees:
        return [*dropped, *unsigned.values(), *degrees]
    steps = [] if IN_MILLI in readings else [*pulses]  # a command is in thousandths or in steps of a PWM, not both
    asked = [*readings, *clocks, *steps, *about_other_runs(runs, explained)]
    asked = asked or about_rates(
        logs_read(problem), problem.structure.unsigned
    )  # last, since a clock shows in a rate, too
    return [*dropped, *unsigned.values(), *asked]


def _without_dropouts(problem: Problem, theta: np.ndarray) -> tuple[list[Question], Problem, np.ndarray]:
    """Questions about drop-outs, and the problem and its numbers without any drop-out."""
    found = [(log, dropouts(log)) for log in logs_read(problem)]
    asked = [Question(f"{log.name}: {one.says}") for log, several in found for one in several]
    if not asked:
        return [], problem, theta
    return asked, *_posed_anew(problem, theta, [without_dropouts(log, several) for log, several in found])


def _posed_anew(
    problem: Problem, theta: np.ndarray, logs: Sequence[Log], unsigned: Collection[str] = ()
) -> tuple[Problem, np.ndarray]:
    """The problem of other logs in the place of those that are read, of some outputs the size alone, and its numbers."""
    structure = problem.structure
    structure = structure._replace(unsigned=tuple(sorted({*structure.unsigned, *unsigned})))
    other = pose(structure, cut_up(logs), problem.noise, per_run=problem.per_run, solver=problem.solver)
    shared, numbers = len(structure.names), runs_of(problem.logs)[[run[0] for run in numbers_of_runs(problem)]]
    own = theta[shared:].reshape(-1, max(len(problem.per_run), 1))[numbers] if problem.per_run else np.zeros(0)
    return other, np.concatenate([theta[:shared], own.ravel()])


def _in_time(problem: Problem, theta: np.ndarray, factor: float) -> list[Run]:
    """Free runs in the logs' time multiplied by a factor; first rates that were taken from angles change with it."""
    if factor > 1.0 and all(np.ptp(log.time) < START_S for log in problem.logs):
        return _laid_out_in_time(problem, theta, factor)
    batch, start = problem.batch, problem.start.copy()
    for k, log in enumerate(problem.logs):
        for _, rate, _, rate_name in problem.structure.turning:
            if rate_name not in log.outputs:
                start[k, problem.structure.states.index(rate)] /= factor
    scaled = batch._replace(h=factor * batch.h, t_command=factor * batch.t_command, t0=factor * batch.t0)
    return free_runs(problem, theta, scaled, start)


def _laid_out_in_time(problem: Problem, theta: np.ndarray, factor: float) -> list[Run]:
    """`_in_time` of runs so short that their steps would be coarse in the other time, and that no part of them is their first 0.5 s."""
    logs = [
        replace(
            log,
            time=factor * log.time,
            origin=factor * log.origin,
            earlier=(factor * log.earlier[0], log.earlier[1]),
        )
        for log in logs_read(problem)
    ]
    other, theta = _posed_anew(problem, theta, logs)
    return free_runs(other, theta, other.batch, other.start)


def _in_rad(problem: Problem, theta: np.ndarray) -> list[Run]:
    """Free runs of the logs that are read, their angles taken for degrees."""
    other, theta = _posed_anew(problem, theta, [from_degrees(log) for log in logs_read(problem)])
    return free_runs(other, theta, other.batch, other.start)


def _under(problem: Problem, theta: np.ndarray, volts: Sequence[np.ndarray]) -> list[Run]:
    """Free runs of the logs that are read under other commands."""
    logs = [replace(log, command=u) for log, u in zip(logs_read(problem), volts, strict=True)]
    other, theta = _posed_anew(problem, theta, logs)
    return free_runs(other, theta, other.batch, other.start)
