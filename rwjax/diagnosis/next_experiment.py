"""Next experiment: among commands that the rig can run, the one on which the rivals differ most beside their error."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.hypothesis import as_written
from rwjax.diagnosis.settings import NextExperimentSettings
from rwjax.effects.library import BY_NAME, is_outside
from rwjax.fitting.prediction import every_output, predict_logs
from rwjax.fitting.problem import Problem
from rwjax.planning.amplitude import COASTING
from rwjax.planning.designs import DESIGNS, LONGEST_S
from rwjax.planning.envelope import LIMITS, Envelope
from rwjax.planning.experiment import REST_S, TICK_HZ, Experiment
from rwjax.planning.files import Plan, Run
from rwjax.planning.motion import WAIT_S, coasting_angle, peaks, simulated_outputs
from rwjax.rig.columns import unit_of


class Proposal(NamedTuple):
    """A sentence that names the next experiment, and a plan of it where it is a command that can be played."""

    sentence: str
    plan: Plan | None = None


class Rival(NamedTuple):
    """A hypothesis as fitted: its names, all logs with its structure, and its parameter vector (t,) [SI]."""

    names: tuple[str, ...]
    problem: Problem
    theta: np.ndarray


class _Simulated(NamedTuple):
    """Experiments as the rivals would run them.

    `runs`: readings of each rival (e, time, y) in units of the error that is left; `peak`: largest size of every output in the
    first rival's runs (e,); `holds`: whether each experiment stays where the logs have been (e,); `lasts`: whether it still runs
    (e, time).
    """

    runs: list[np.ndarray]
    peak: dict[str, np.ndarray]
    holds: np.ndarray
    lasts: np.ndarray


def _commands(top: float, limits: NextExperimentSettings) -> list[Experiment]:
    """Those of the campaign, of several sizes and paces, within `top` volts."""
    sizes = [(share, pace) for share in limits.amplitudes for pace in limits.paces]
    return [d.at(share * top / (1.0 + d.offset), pace) for d in DESIGNS.values() for share, pace in sizes]


def _shown(rival: Rival, train: Sequence[int]) -> Envelope:
    """How far the training logs have gone: their largest command, and rates, current and travel as the rival has them."""
    start = np.stack([run.start for run in predict_logs(rival.problem, rival.theta, with_floor=False)])
    runs = every_output(rival.problem, rival.theta, start)
    moved = [
        {name: y - y[0] if name == "yaw_rad" else y for name, y in runs[k].items() if name in LIMITS} for k in train
    ]
    most = {name: max(float(np.max(np.abs(run[name]))) for run in moved) for name in moved[0]}
    return Envelope(max(float(np.max(np.abs(rival.problem.logs[k].command))) for k in train), most)


def _simulated(
    rivals: Sequence[Rival],
    experiments: list[Experiment],
    outputs: list[str],
    error: np.ndarray,
    within: Envelope,
    beyond: float,
) -> _Simulated:
    """Runs every experiment with every rival. Where a rival has end stops, the way until the rig rests counts."""
    during = round(TICK_HZ * LONGEST_S)
    length = np.array([REST_S + e.length for e in experiments])
    lasts = np.arange(during) < TICK_HZ * length[:, None]  # (e, t)
    stops = _has_stops(rivals)
    runs, every_peak, holds = [], [], np.ones(len(experiments), bool)
    for rival in rivals:
        structure = rival.problem.structure.with_every_output()
        seconds = LONGEST_S + (WAIT_S if stops else 0.0)
        y = simulated_outputs(structure, rival.theta, experiments, seconds, supply=_supply(rival.problem))
        moved = {name: y[..., k] for k, name in enumerate(structure.outputs)}
        peak = peaks(moved)
        if stops:  # as in a plan whose travel is limited
            coasts = coasting_angle(moved["yaw_rad_s"])
            peak["yaw_rad"] = peak["yaw_rad"] + coasts
            holds &= coasts <= COASTING * within.limits["yaw_rad"]
        holds &= within.largest_share(peak) <= beyond
        runs.append(np.stack([moved[name][:, :during] for name in outputs], axis=-1) / error)
        every_peak.append(peak)
    return _Simulated(runs, every_peak[0], holds, lasts)


def _supply(problem: Problem) -> float | None:
    """Mean voltage of the supply in the logs [V], None where one does not hold it."""
    held = [log.supply for log in problem.logs if log.supply is not None]
    return float(np.mean(np.concatenate(held))) if len(held) == len(problem.logs) else None


def _has_stops(rivals: Sequence[Rival]) -> bool:
    return any(BY_NAME[e].ends_travel for rival in rivals for e in rival.problem.structure.effects)


def _differences(found: _Simulated) -> np.ndarray:
    """RMS difference of the first two rivals in every experiment (e,), 0 where it does not hold the limits."""
    with np.errstate(over="ignore", invalid="ignore"):  # what leaves the range of numbers holds no limit
        apart = np.sum((found.runs[0] - found.runs[1]) ** 2, axis=-1)
    square = np.sum(np.where(found.lasts, apart, 0.0), axis=1) / found.lasts.sum(axis=1)
    return np.where(found.holds, np.sqrt(square), 0.0)


def propose(
    rig: str,
    rivals: Sequence[Rival],
    train: Sequence[int],
    remains: dict[str, float],
    limits: NextExperimentSettings,
) -> Proposal:
    """The command on which two rivals differ most, hardly further than the training logs have gone.

    Args:
        rig: the rig's name, for the plan.
        rivals: two hypotheses as fitted, or more, of which the first two are told apart.
        train: numbers of the training logs.
        remains: RMS error by output [SI] that the rivals leave on the logs they were judged on; a smaller difference tells nothing.
        limits: the commands to choose among.

    Returns:
        The proposal, without a plan where no command tells the rivals apart.
    """
    problem, within = rivals[0].problem, _shown(rivals[0], train)
    outputs = sorted({name for k in train for name in problem.logs[k].outputs})
    error = np.array([max(problem.noise[name], remains.get(name, 0.0)) for name in outputs])
    experiments = _commands(within.volts, limits)
    found = _simulated(rivals, experiments, outputs, error, within, limits.beyond)
    telling = _differences(found)
    by = problem.logs[0].input
    unit = f" {unit_of(by)}".rstrip()
    best = int(np.argmax(telling))
    names = [" + ".join(as_written(name) for name in rival.names) for rival in rivals]
    if not found.holds.any():
        rest = f", or not let it come to rest within {WAIT_S:g} s" if _has_stops(rivals) else ""
        return Proposal(
            f"none found that separates {' and '.join(names)}: every command would take the rig further than these logs have "
            f"gone{rest}"
        )
    if telling[best] < 1.0:
        largest = f"{within.volts:.3g}{unit}" if unit else f"{within.volts:.3g} of full scale"
        return Proposal(
            f"no command within {largest}, hardly further than these logs have gone, separates {' and '.join(names)}: "
            "there they are the same thing for this rig"
        )
    run = Run(
        name="next",
        experiment=experiments[best],
        role="train",
        why=f"separates {names[0]} from {names[1]}",
        tells_apart=tuple(dict.fromkeys(name for rival in rivals for name in rival.names if not is_outside(name))),
        reaches={name: float(values[best]) for name, values in found.peak.items()},
    )
    return Proposal(
        f"run {_in_words(run.experiment, by, unit)}: there {' and '.join(names)} differ by {telling[best]:.1f} times the error that is left",
        Plan(rig, within.known, (run,)) if by == "voltage_V" else None,  # a board plays voltages
    )


def _in_words(e: Experiment, by: str, unit: str) -> str:
    """An experiment as one would tell it, whose command stands in the column `by`."""
    of = "" if by == "voltage_V" else f" of `{by}`"
    if e.kind == "coast-down":
        return f"{e.amplitude:.3g}{unit}{of} for {e.period:g} s, then 0{unit} until standstill (coast-down)"
    between = f"between {e.offset - abs(e.amplitude):.3g} and {e.offset + abs(e.amplitude):.3g}{unit}"
    return f"a {e.kind}{of} {between} with a period of {e.period:g} s for {e.length:g} s"
