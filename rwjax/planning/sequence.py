"""The runs of a campaign as they are played: each alone, or one after the other within a limited travel."""

from collections.abc import Iterator
from itertools import groupby
from math import isclose
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from rwjax.planning.amplitude import COASTING, KEPT, LARGE, LEVELS, SizedDesign, moves, rounded_levels, try_designs
from rwjax.planning.designs import BACK, LONGEST_S
from rwjax.planning.envelope import Envelope
from rwjax.planning.experiment import Experiment
from rwjax.planning.motion import WAIT_S, coasting_angle, peaks, simulated_motion
from rwjax.rig.model import Rig

ALIKE = 0.1
"""Share by which amplitudes or offsets of two runs of one shape have to differ for both to be in a plan [1]."""


class PlayedRun(NamedTuple):
    """A run as simulated.

    Attributes:
        experiment: The experiment.
        reaches: Peaks of the outputs [SI] by name.
        angle_range: Lowest and highest angle [rad] from where it began; None where travel is not limited.
    """

    experiment: Experiment
    reaches: dict[str, float]
    angle_range: tuple[float, float] | None


class Played(NamedTuple):
    """Designs as they are played, each once.

    Attributes:
        runs: The runs of each design, as many as it repeats.
        twins: Designs that would repeat one of these, by name, with the name of that one; they are not played.
    """

    runs: dict[str, list[PlayedRun]]
    twins: dict[str, str]


def play_runs(rig: Rig, within: Envelope, sized: dict[str, SizedDesign]) -> Played:
    """Every design at the largest amplitude up to its own that keeps to the limits.

    Where travel is limited, the runs are played one after the other, each beginning where the one before has ended.

    Args:
        rig: The rig.
        within: Its limits.
        sized: Designs by name with their largest amplitude and pace.

    Returns:
        The runs of each design that keeps to the limits and comes out as no earlier one, and those that do.
    """
    return (_in_sequence if within.limits_travel else _each_alone)(rig, within, sized)


def _each_alone(rig: Rig, within: Envelope, sized: dict[str, SizedDesign]) -> Played:
    """The runs where travel is not limited, each from angle 0."""
    if not sized:
        return Played({}, {})
    designs = {name: each.design for name, each in sized.items()}
    levels = rounded_levels(np.array([each.amplitude for each in sized.values()]), LARGE)
    paces = [each.pace for each in sized.values()]
    tried = try_designs(rig, within, designs, levels, paces)  # once more as it will be played
    found = Played({}, {})
    for d, (name, each) in enumerate(sized.items()):
        if (size := tried.allowed[d] - 1) >= 0:
            reaches = {output: float(values[d, size]) for output, values in tried.peaks.items()}
            one = PlayedRun(each.design.at(levels[d, size], each.pace, column=within.input), reaches, None)
            _add(found, {name: [one] * each.design.repeats})
    return found


def _in_sequence(rig: Rig, within: Envelope, sized: dict[str, SizedDesign]) -> Played:
    """The runs one after the other, each as large as the travel that is left allows.

    Each takes the direction that allows more, or the one that ends nearer the middle where both allow the same. A design and
    its way back are one: the same size, opposite directions. Where the way back comes first, it keeps its name.
    """
    found, begin = Played({}, {}), 0.0
    for _, group in groupby(sized, key=lambda name: name.removesuffix(BACK)):
        names = list(group)
        options = _play_options(rig, within, [sized[name] for name in names], begin)
        if not options.good.any():
            continue
        best = min(np.flatnonzero(options.good), key=lambda k: (-options.size[k], abs(options.end[k])))
        runs = iter(options.runs)
        played = [[next(runs)[best] for _ in range(sized[name].design.repeats)] for name in names]
        turned = played[0][0].experiment.amplitude * sized[names[0]].design.direction < 0.0
        if _add(found, dict(zip(reversed(names) if turned else names, played, strict=True))):
            begin = options.end[best]
    return found


def _add(found: Played, group: dict[str, list[PlayedRun]]) -> bool:
    """Adds the runs of one or two designs, or that they all repeat earlier ones; whether they are played."""
    twins = {name: twin for name, (run, *_) in group.items() if (twin := _twin(found, run.experiment))}
    if played := len(twins) < len(group):
        found.runs.update(group)
    else:
        found.twins.update(twins)
    return played


def _twin(found: Played, one: Experiment) -> str | None:
    """The design that is played with the same experiment, in all but `ALIKE` of amplitude and offset."""
    for name, (run, *_) in found.runs.items():
        other = run.experiment
        shapes = {(each.kind, each.period, each.length) for each in (one, other)}
        sizes = (one.amplitude, other.amplitude), (one.offset, other.offset)
        if len(shapes) == 1 and all(isclose(a, b, rel_tol=ALIKE) for a, b in sizes):
            return name
    return None


class _Options(NamedTuple):
    """Ways to play one or two designs, o of them: both directions, each at all amplitudes.

    `size`: index of the amplitude; `good`: whether it keeps to the limits; `end`: angle [rad] at which it leaves the axis;
    `runs`: for every run its outcome by option.
    """

    size: np.ndarray
    good: Bool[np.ndarray, " o"]
    end: Float[np.ndarray, " o"]
    runs: list[list[PlayedRun]]


def _play_options(rig: Rig, within: Envelope, parts: list[SizedDesign], begin: float) -> _Options:
    """All ways to play designs one after the other from an angle [rad], simulated side by side."""
    levels = rounded_levels(np.array([part.amplitude for part in parts]), 1.0 / LEVELS)
    options = [(sign, k) for sign in (1.0, -1.0) for k in range(levels.shape[1])]
    at, good = np.full(len(options), begin), np.ones(len(options), bool)
    runs: list[list[PlayedRun]] = []
    for experiments, reverses in _experiments(parts, levels, options, within.input):
        moved = simulated_motion(rig, experiments, LONGEST_S + WAIT_S, at)
        peak, rest = peaks(moved), coasting_angle(moved["yaw_rad_s"])
        good &= rest <= COASTING * within.limits["yaw_rad"]
        good &= moves(rig, moved, np.full(len(options), reverses))
        low, high = moved["yaw_rad"].min(axis=1) - rest, moved["yaw_rad"].max(axis=1) + rest
        for origin in (np.zeros(len(options)), at):  # within the travel in its place, and where it is played alone
            peak["yaw_rad"] = np.maximum(high - origin, origin - low)
            good &= within.largest_share(peak) <= KEPT
        ranges = zip((low - at).tolist(), (high - at).tolist(), strict=True)
        runs.append(_outcomes(experiments, peak, list(ranges)))
        onward = np.sign(moved["yaw_rad_s"][:, -1]) * np.where(np.isfinite(rest), rest, 0.0)
        at = moved["yaw_rad"][:, -1] + onward
    return _Options(np.array([k for _, k in options]), good, at, runs)


def _experiments(
    parts: list[SizedDesign], levels: Float[np.ndarray, "d a"], options: list[tuple[float, int]], column: str
) -> Iterator[tuple[list[Experiment], bool]]:
    """For every run the experiment of each option (sign, index of the amplitude), and whether it has to reverse the rig."""
    for d, part in enumerate(parts):
        experiments = [part.design.at(levels[d, k], part.pace, sign, column) for sign, k in options]
        for _ in range(part.design.repeats):
            yield experiments, part.design.reverses


def _outcomes(
    experiments: list[Experiment], peak: dict[str, np.ndarray], ranges: list[tuple[float, float]]
) -> list[PlayedRun]:
    """What each option of a run does."""
    return [
        PlayedRun(experiment, {name: float(values[k]) for name, values in peak.items()}, angle_range)
        for k, (experiment, angle_range) in enumerate(zip(experiments, ranges, strict=True))
    ]
