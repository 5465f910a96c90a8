"""Questions about readings: in another unit, of the other sign, or standing still where the rig should move.

No fit finds such a mistake: it bends the numbers instead.
"""

from collections.abc import Sequence

import numpy as np

from rwjax.fitting.initial_guess import starts_at_rest
from rwjax.fitting.questions.likeness import ALIKE, GIVEN, Likeness, Question, Run, likeness, motion, names_of
from rwjax.kinds import is_angle
from rwjax.logs.log import Log
from rwjax.logs.noise_level import noise_level

UNITS = {
    "_rad": (("degrees", "deg", 180.0 / np.pi),),
    "_rad_s": (("rpm", "rpm", 30.0 / np.pi), ("°/s", "deg/s", 180.0 / np.pi)),
    "_A": (("mA", "mA", 1000.0),),
}
"""Units that readings are taken in by mistake, by the end of the column's name: in words, as [columns] takes them, and how many make
the SI unit."""
COUNTED = 180.0 / np.pi
"""Ratio of an angle in degrees to one in rad; a still larger one may be in counts [1]."""
EDGES = 4.0
"""Edges that an encoder counts for each of its lines [1]."""
ALIKE_EDGES, ABOUT_EDGES = 0.97, 1.4
"""Correlation, and factor by which the rig file's numbers may be wrong besides, for a question about edges [1]."""
MILLI = 1e-3
"""Ratio of measured to simulated motion where a command is given in thousandths of its unit [1]."""
ABOUT = 1.6
"""Factor by which the rig file's numbers may be wrong besides [1]."""
COUNTS_MISSED = 20.0
"""Counts by which a reading that stands still should have moved for a question [1]."""
IN_MILLI = Question(f"all readings are a thousandth of {GIVEN}: is the command in mV? Divide it by 1000")
"""The question about a command in thousandths, beside which none about pulses fits."""
LEAST_MOTION = {"_rad": 0.02, "_rad_s": 0.2, "_A": 0.1}
"""The same for readings in SI [rad, rad/s, A]."""

NOISE_WIDTH = 10.0
"""Width of readings, in standard deviations of their noise, within which they stand still [1]."""
BEYOND_NOISE = 5.0
"""Simulated motion, in widths of the readings that stand still, for a question [1]."""


def about_readings(runs: Sequence[Run]) -> list[Question]:
    """Questions about readings that contradict a simulation with the rig file's numbers.

    Args:
        runs: Logs with their free runs.

    Returns:
        The questions, one sentence each.
    """
    return [*about_units(runs), *about_still_readings(runs)]


def about_units(runs: Sequence[Run]) -> list[Question]:
    """Questions about the unit or the sign of readings, or about a command in thousandths.

    An output is asked about where it moves the other way, or as many times as far as another unit would make it. Its
    size is the median over the logs that begin at rest, where the command alone sets the rig in motion. One question is
    about the command, where all outputs are as if it were given in thousandths.

    Args:
        runs: Logs with their free runs.

    Returns:
        The questions, one sentence each.
    """
    found, small = [], []
    for name in dict.fromkeys(name for run in runs for name in run.log.outputs):
        compared = [likeness(run, name) for run in runs if name in run.log.outputs and starts_at_rest(run.log)]
        alike, times, _ = np.median(compared, axis=0) if compared else (0.0, 0.0, 0.0)
        small.append(abs(alike) > ALIKE and 1.0 / ABOUT < abs(times) / MILLI < ABOUT)
        if abs(alike) > ALIKE:
            if times < 0.0:
                asked = f"{name} goes against {GIVEN}: is its sign, or that of the command, wrong?"
                found.append(Question(f"{asked} Write sign = -1 for the wrong one in [columns]"))
            counted = any(run.log.resolution.get(name) for run in runs)
            found += _about_counts_per_rev(name, abs(times)) if counted else _about_unit(name, abs(times))
        if any(run.log.resolution.get(name) for run in runs):
            found += _about_edges(name, compared)
    if small and all(small):
        found.append(IN_MILLI)
    return found


def _about_unit(name: str, times: float) -> list[Question]:
    """Questions about an output that moves so many times as far as simulated."""
    found = []
    size = f"{name} is {times:.3g} times {GIVEN}"
    units = next((units for end, units in UNITS.items() if name.endswith(end)), ())
    for words, unit, many in units:
        if 1.0 / ABOUT < times / many < ABOUT:
            found.append(
                Question(
                    f'{size}: are the readings in {words}? Write unit = "{unit}" in [columns], or divide them by {many:.5g}'
                )
            )
    if is_angle(name) and times > ABOUT * COUNTED:
        turn, column = f"about {2.0 * np.pi * times:.2g} to a turn", name.removesuffix("_rad") + "_counts"
        found.append(Question(f"{size}: are the readings counts, {turn}? Their column is called {column}"))
    return found


def _about_counts_per_rev(name: str, times: float) -> list[Question]:
    """A question about a counted output that moves at least as many times as far as simulated as degrees would make it."""
    if times < COUNTED / ABOUT:
        return []
    size = f"{name} is {times:.3g} times {GIVEN}"
    return [Question(f"{size}: is its encoder's counts_per_rev right, and the unit of the command?")]


def _about_edges(name: str, compared: Sequence[Likeness]) -> list[Question]:
    """Questions about an encoder's edges, of a counted output that moves about 4 times as far as simulated, or a quarter.

    Dry friction that the rig file lacks leaves a quarter of a motion as well, but not of every run alike, nor in its shape.
    """
    for many, do in ((EDGES, "times 4"), (1.0 / EDGES, "divided by 4")):
        alike = [
            one.correlation > ALIKE_EDGES and 1.0 / ABOUT_EDGES < one.times / many < ABOUT_EDGES for one in compared
        ]
        if alike and all(alike):
            times = float(np.median([one.times for one in compared]))
            size = f"{name} is {times:.3g} times {GIVEN}"
            return [Question(f"{size}: a line has 4 edges; should its encoder's counts_per_rev be {do}?")]
    return []


def about_still_readings(runs: Sequence[Run]) -> list[Question]:
    """Questions about readings that stay the same while the command moves and should move them far.

    Dry friction holds a rig in some runs. So either the reading stands still in every run, or it lacks even the noise that it
    has in others.

    Args:
        runs: Logs with their free runs.

    Returns:
        The questions, one for each output.
    """
    found = []
    for name in dict.fromkeys(name for run in runs for name in run.log.outputs):
        commanded = [run for run in runs if name in run.log.outputs and np.ptp(run.log.at_drive, axis=0).any()]
        dead = all(_stands_still(run.log, name) for run in commanded)
        noisy = any(_width(run.log, name) > 0.0 for run in commanded)
        asked = [
            run.log
            for run in commanded
            if (dead or (noisy and _is_constant(run.log, name))) and _should_move(run, name)
        ]
        if asked:
            found.append(
                Question(
                    f"{names_of(asked)}: {name} stays the same while the command changes and should move it far: is the sensor "
                    "connected, or was the rig held?"
                )
            )
    return found


def _is_constant(log: Log, name: str) -> bool:
    """Whether readings in SI, of which no two are equal in a live sensor, are all equal."""
    return log.resolution.get(name, 0.0) == 0.0 and _width(log, name) == 0.0


def _width(log: Log, name: str) -> float:
    """Range of an output's readings [SI]."""
    values = log.outputs[name]
    return float(np.ptp(values[np.isfinite(values)]))


def _stands_still(log: Log, name: str) -> bool:
    """Whether readings stay within a count or within their noise."""
    values = log.outputs[name]
    noise = noise_level(values[np.isfinite(values)])
    return _width(log, name) <= max(log.resolution.get(name, 0.0), NOISE_WIDTH * noise)


def _should_move(run: Run, name: str) -> bool:
    """Whether the simulated output moves far beyond a count and beyond the width of the readings."""
    count = run.log.resolution.get(name, 0.0)
    least = COUNTS_MISSED * count or next(size for end, size in LEAST_MOTION.items() if name.endswith(end))
    moves = float(np.max(np.abs(motion(run.log, name, run.simulated[name])), initial=0.0))
    return moves > max(least, BEYOND_NOISE * _width(run.log, name))
