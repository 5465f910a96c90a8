"""Commands in pulses and commands of other runs are asked about, right ones are not."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.questions.command import about_fractions, about_other_runs, about_pulses, as_pulses
from rwjax.fitting.questions.likeness import Run
from rwjax.logs.log import Log
from tests.fitting.questions.runs import LOGS, beside


def commanded(log: Log, command: np.ndarray) -> Log:
    return replace(log, command=np.resize(command, log.command.shape))


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ([-255.0, 0.0, 200.0], "percent or in PWM counts"),
        ([0.0, 60.0], "percent or in PWM counts"),
        ([1500.0, 1900.0], "us of a pulse"),
        ([0.0, 3000.0], "percent or in PWM counts"),
    ],
)
def test_whole_numbers_beyond_volts_may_be_pulses(command: list[float], words: str) -> None:
    found = as_pulses(commanded(LOGS[0], np.array(command)))
    assert found is not None and found.words == words


@pytest.mark.parametrize("command", [[0.0, 12.0], [0.0, 24.5], [0.0, 1e6]])
def test_volts_are_no_pulses(command: list[float]) -> None:
    assert as_pulses(commanded(LOGS[0], np.array(command))) is None


@pytest.mark.parametrize(
    ("per_volt", "neutral", "says"),
    [
        (60.0, 0.0, "PWM counts? Multiply it by the supply voltage over"),
        (100.0, 1500.0, "us of a pulse? Subtract the neutral pulse"),
    ],
)
def test_pulses_taken_as_volts_are_asked_about(per_volt: float, neutral: float, says: str) -> None:
    logs = [commanded(log, np.round(neutral + per_volt * log.command)) for log in LOGS[:2]]
    runs = [beside(log) for log in logs]
    found = about_pulses(runs, lambda volts: [beside(commanded(log, u)) for log, u in zip(logs, volts, strict=True)])
    ((question, numbers),) = found.items()
    assert question.startswith("square.csv and chirp.csv: the command reaches") and says in question
    assert numbers == [0, 1]


def test_whole_volts_that_move_the_rig_as_they_should_are_not_asked_about() -> None:
    def never(volts: object) -> list[Run]:
        raise AssertionError("simulated in vain")

    assert about_pulses([beside(log) for log in LOGS], never) == {}
    large = [Run(commanded(log, 20.0 * np.sign(log.command)), log.outputs) for log in LOGS]
    assert about_pulses(large, never) == {}


def test_the_command_of_another_run_is_asked_about_and_only_there() -> None:
    runs = [beside(commanded(LOGS[0], LOGS[1].command)), *(beside(log) for log in LOGS[1:])]
    (question,) = about_other_runs(runs, ())
    assert question.startswith("square.csv: the readings do not follow") and question.endswith("of another run?")
    assert about_other_runs(runs, {0}) == []  # another question explains it
    assert about_other_runs([beside(log) for log in LOGS], ()) == []


def test_logs_that_vouch_for_nothing_are_asked_about_where_motion_and_command_are_unrelated() -> None:
    assert len(about_other_runs([beside(commanded(LOGS[2], LOGS[0].command))], ())) == 1


def test_a_rig_that_the_model_does_not_describe_but_its_command_drives_is_not_asked_about() -> None:
    backwards = {name: y[::-1].copy() for name, y in LOGS[0].outputs.items()}
    assert about_other_runs([Run(LOGS[0], backwards)], ()) == []


def test_a_rig_that_hardly_moves_may_stick_and_is_not_asked_about() -> None:
    log = replace(LOGS[0], outputs={name: 0.1 * y[::-1] for name, y in LOGS[0].outputs.items()})
    assert about_other_runs([Run(log, LOGS[0].outputs), *(beside(log) for log in LOGS[1:])], ()) == []


@pytest.mark.parametrize("supplied", [False, True])
def test_a_fraction_that_is_taken_for_percent_is_asked_about(supplied: bool) -> None:
    """The rig's command is a duty of up to a third at 12 V, which a hundredth of it moves a hundredth as far."""

    def taken(log: Log, times: float) -> Log:
        duty = times * log.command / 12.0
        if supplied:
            return replace(log, command=12.0 * duty, supply=np.full(len(duty), 12.0))
        return replace(log, command=duty, input="duty")

    def runs(times: float) -> list[Run]:
        simulated = (beside(commanded(log, times * log.command)).simulated for log in LOGS)
        return [Run(taken(log, times), found) for log, found in zip(LOGS, simulated, strict=True)]

    (question,) = about_fractions(runs(0.01))
    assert question.startswith("square.csv and 2 more: the command never passes 0.33 % of full power")
    assert "is it a fraction of 1, and not percent?" in question
    assert about_fractions(runs(1.0)) == []
    small = [run._replace(log=replace(run.log, outputs=dict(run.simulated))) for run in runs(0.01)]
    assert about_fractions(small) == []  # the readings are what so small a command gives


def test_a_rig_that_so_small_a_command_leaves_at_rest_is_not_asked_about() -> None:
    """Beside a simulation at rest every noise is large."""
    rng, still = np.random.default_rng(0), np.zeros(len(LOGS[0].time))
    noise = {name: 1e-3 * rng.normal(size=len(still)) for name in LOGS[0].outputs}
    log = replace(LOGS[0], command=1e-3 * LOGS[0].command, input="duty", outputs=noise)
    assert about_fractions([Run(log, dict.fromkeys(noise, still))]) == []
    moved = {name: y + LOGS[0].outputs[name] for name, y in noise.items()}
    assert about_fractions([Run(replace(log, outputs=moved), dict.fromkeys(noise, still))])


def test_of_a_command_whose_full_power_is_not_known_no_share_is_asked_about() -> None:
    assert about_fractions([Run(commanded(log, 1e-3 * log.command), beside(log).simulated) for log in LOGS]) == []
