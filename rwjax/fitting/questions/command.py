"""Questions about the command of a log: a fraction taken as percent, pulses taken as volts, or the command of another run."""

from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

import numpy as np

from rwjax.fitting.questions.driven import coherent_share, driven_share
from rwjax.fitting.questions.likeness import (
    ALIKE,
    GIVEN,
    Question,
    Run,
    explained,
    likeness,
    motion,
    names_of,
)
from rwjax.logs.log import Log
from rwjax.logs.noise import noise_by_output

PERCENT = 0.01
"""Share of full power that a fraction of 1 never passes where it is taken for percent [1]."""
FARTHER = 10.0
"""Measured motion over the simulated one, by their effective values, from which a command is too small [1]."""
FEW_VOLTS = 15.0
"""Command [V] above which whole numbers may be pulses."""
MOST_COUNTS = 65_535
"""Largest PWM count [1]."""
PULSES_US = (400.0, 2600.0)
"""Pulse widths that an ESC or a servo takes [us]."""
NEUTRAL_US = 1500.0
"""The usual pulse width at 0 V [us]."""
FULL_V = 12.0
"""Volts of the longest pulse, for a look at the shape of the motion alone [V]."""
SMALL = 0.3
"""Readings as a share of the simulated ones below which the command is no volts [1]."""
EXPLAINED = 0.5
"""Share explained by the command as volts, from which no question is asked [1]."""
UNLIKE = 0.7
"""Correlation of measured and simulated motion below which one does not follow the other [1]."""
DRIVEN = 0.5
"""Correlation of the acceleration with the command above which that drives it [1]."""
NOT_DRIVEN, INCOHERENT = 0.2, 0.1
"""The same correlation, and the coherence, below which motion and command have nothing to do with each other [1]."""
MOST = 0.7
"""Share of the other logs that have to move as simulated to vouch for the rig file's numbers [1]."""
COMPARABLE = 0.25
"""Energy of a motion as a share of the simulated one's, below which dry friction may hold the rig [1]."""


class Pulses(NamedTuple):
    """Commands as pulses.

    Attributes:
        neutral: Command that means 0 V [as in the log].
        words: What the command may be.
        remedy: What would be right.
    """

    neutral: float
    words: str
    remedy: str


def about_fractions(runs: Sequence[Run]) -> list[Question]:
    """A question about commands that never pass 1 % of full power, where all readings move far more than such a command moves them.

    Args:
        runs: Logs with their free runs. Those whose command is neither a duty nor beside the voltage of its supply are passed over.

    Returns:
        The question; none where a log's command is larger, or a reading moves about as simulated.
    """
    largest = [size for run in runs if (size := _of_full_power(run.log)) is not None]
    if len(largest) < len(runs) or not 0.0 < max(largest, default=0.0) <= PERCENT * (1.0 + 1e-9):
        return []
    if not all(_moves_beyond(run, FARTHER**2) for run in runs if _of_full_power(run.log)):
        return []
    return [
        Question(
            f"{names_of([run.log for run in runs])}: the command never passes {100.0 * max(largest):.2g} % of full power, and the readings "
            f"move more than {FARTHER:g} times as far as {GIVEN} under it: is it a fraction of 1, and not percent? Leave the "
            'unit "percent" out of [columns], or multiply it by 100'
        )
    ]


def _of_full_power(log: Log) -> float | None:
    """Largest command as a share of full power [1]; None where that is not known."""
    if log.input == "duty":
        return float(np.abs(log.command).max(initial=0.0))
    if log.input == "voltage_V" and log.supply is not None and log.command.ndim == 1:
        return float(np.max(np.abs(log.command) / np.maximum(np.abs(log.supply), np.finfo(float).tiny), initial=0.0))
    return None


def as_pulses(log: Log) -> Pulses | None:
    """What pulses a log's command may be: whole numbers beyond a rig's volts.

    Args:
        log: The log.

    Returns:
        The pulses, None for what is no whole number or may be volts.
    """
    size = np.abs(log.at_drive)
    if not np.array_equal(log.at_drive, np.round(log.at_drive)) or size.max(initial=0.0) < FEW_VOLTS:
        return None
    shortest, longest = PULSES_US
    if shortest <= log.at_drive.min() and log.at_drive.max() <= longest:
        return Pulses(NEUTRAL_US, "us of a pulse", "Subtract the neutral pulse and multiply by volts per us")
    if size.max() > MOST_COUNTS:
        return None
    return Pulses(
        0.0,
        "percent or in PWM counts",
        "Multiply it by the supply voltage over the number of full power (100, 255, 1023 …)",
    )


def about_pulses(
    runs: Sequence[Run], under: Callable[[Sequence[np.ndarray]], Sequence[Run]]
) -> dict[Question, list[int]]:
    """Questions about commands in pulses, where the motion has the shape that volts in proportion to them give.

    Args:
        runs: Logs with their free runs.
        under: The same logs with their free runs under other commands, which are given log by log [V].

    Returns:
        The questions, each with the numbers of the logs that it is about.
    """
    pulses = {k: found for k, run in enumerate(runs) if (found := as_pulses(run.log)) and explained(run) < EXPLAINED}
    if not pulses:
        return {}
    volts = [_volts(run.log.at_drive, pulses[k]) if k in pulses else run.log.at_drive for k, run in enumerate(runs)]
    shaped = [all(abs(likeness(run, name).correlation) > ALIKE for name in run.log.outputs) for run in under(volts)]
    asked: dict[Pulses, list[int]] = {}
    for k, found in pulses.items():
        if shaped[k] and (found.neutral or _small(runs[k])):
            asked.setdefault(found, []).append(k)
    return {_question([runs[k].log for k in numbers], found): numbers for found, numbers in asked.items()}


def _question(logs: Sequence[Log], pulses: Pulses) -> Question:
    largest = max(float(np.abs(log.at_drive).max()) for log in logs)
    return Question(
        f"{names_of(logs)}: the command reaches {largest:g}, and the readings are not {GIVEN} under so many volts: is it in "
        f"{pulses.words}? {pulses.remedy}"
    )


def _volts(command: np.ndarray, pulses: Pulses) -> np.ndarray:
    """A command [V] in proportion to pulses."""
    away = command - pulses.neutral
    return FULL_V * away / np.abs(away).max(initial=1.0)


def _small(run: Run) -> bool:
    """Whether all readings are far below the simulated ones."""
    return all(abs(likeness(run, name).times) < SMALL for name in run.log.outputs)


def about_other_runs(runs: Sequence[Run], asked: Collection[int]) -> list[Question]:
    """Questions about logs whose readings have nothing to do with their command.

    Such a log does not move as simulated, and its command does not drive its acceleration. Besides, either most other logs
    move as simulated, which vouches for the rig file's numbers, or its motion is incoherent with its command as well.

    Args:
        runs: Logs with their free runs.
        asked: Numbers of the logs that are asked about otherwise.

    Returns:
        The questions, one for each such log.
    """
    follows = np.array([max(abs(likeness(run, name).correlation) for name in run.log.outputs) for run in runs])
    found = []
    for k, run in enumerate(runs):
        if k in asked or follows[k] > UNLIKE or not _moves_enough(run):
            continue
        vouched = len(runs) > 1 and np.mean(np.delete(follows, k) > ALIKE) > MOST
        driven = driven_share(run.log)
        if (vouched and driven < DRIVEN) or (driven < NOT_DRIVEN and coherent_share(run.log) < INCOHERENT):
            found.append(
                Question(
                    f"{run.log.name}: the readings do not follow the command (correlation {follows[k]:.2f} with {GIVEN}): is it the "
                    "command of another run?"
                )
            )
    return found


def _moves_enough(run: Run) -> bool:
    """Whether the rig moves about as far as simulated: dry friction that the rig file lacks may hold it otherwise."""
    return any(own > COMPARABLE * given > 0.0 for own, given in _squares(run))


def _moves_beyond(run: Run, times: float) -> bool:
    """Whether the square of every reading's motion is more than so many times that of the simulated one, and of its noise."""
    least = (2.0 * len(run.log.time) * noise**2 for noise in noise_by_output(run.log).values())
    return all(own > times * max(given, none) for (own, given), none in zip(_squares(run), least, strict=True))


def _squares(run: Run) -> list[tuple[float, float]]:
    """Sum of the squares of every reading's motion, and of the simulated one beside it [SI]."""
    found = []
    for name in run.log.outputs:
        a, b = motion(run.log, name, np.stack([run.log.outputs[name], run.simulated[name]]))
        found.append((float(np.nansum(a**2)), float(np.nansum(b[np.isfinite(a)] ** 2))))
    return found
