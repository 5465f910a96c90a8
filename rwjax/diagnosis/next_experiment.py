"""Next experiment: among commands that the rig can run, the one on which the rivals differ most beside their error."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.effects.library import BY_NAME
from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import Problem
from rwjax.planning.amplitude import COASTING
from rwjax.planning.designs import DESIGNS, LONGEST_S
from rwjax.planning.envelope import LIMITS, Envelope
from rwjax.planning.experiment import REST_S, TICK_HZ, Experiment
from rwjax.planning.files import Plan, Run
from rwjax.planning.motion import WAIT_S, coasting_angle, peaks, simulated_outputs

SHARES = (1.0, 0.6, 0.35, 0.2)
"""Of the largest command of the logs."""
PACES = (1.0, 0.25)
"""Shares of a design's period and length."""


BEYOND = 1.1
"""How far a run may go, over what the logs show: less would refuse what they themselves reach."""


class Proposal(NamedTuple):
    """A sentence that names the next experiment, and a plan of it where it is a command that can be played."""

    sentence: str
    plan: Plan | None = None


class Rival(NamedTuple):
    """An hypothesis as fitted: its names, all logs with its structure, and its numbers."""

    names: tuple[str, ...]
    problem: Problem
    theta: np.ndarray


def commands(top: float) -> list[Experiment]:
    """Those of the campaign, of several sizes and as fast as one likes, within `top` volts."""
    sizes = [(share, pace) for share in SHARES for pace in PACES]
    return [d.at(share * top / (1.0 + d.offset), pace) for d in DESIGNS.values() for share, pace in sizes]


def shown(rival: Rival, train: Sequence[int]) -> Envelope:
    """How far the training logs have gone: their largest command, and rates, current and travel as the rival has them."""
    runs = predict_logs(rival.problem, rival.theta, with_floor=False)
    moved = [
        {name: y - y[0] if name == "yaw_rad" else y for name, y in runs[k].outputs.items() if name in LIMITS}
        for k in train
    ]
    most = {name: max(float(np.max(np.abs(run[name]))) for run in moved) for name in moved[0]}
    return Envelope(max(float(np.max(np.abs(rival.problem.logs[k].command))) for k in train), most)


def propose(rig: str, rivals: Sequence[Rival], train: Sequence[int], remains: dict[str, float]) -> Proposal:
    """The command on which two rivals differ most, hardly further than the logs in `train` have gone, and by how much.

    `rig`: its name, for the plan. `remains`: RMS error [SI] by output that the rivals leave on the logs they were judged on; a
    difference below it tells nothing. Where a rival has end stops, the way until the rig rests counts.
    """
    problem, within = rivals[0].problem, shown(rivals[0], train)
    outputs = sorted({name for k in train for name in problem.logs[k].outputs})
    error = np.array([max(problem.noise[name], remains.get(name, 0.0)) for name in outputs])
    experiments = commands(within.volts)
    during = round(TICK_HZ * LONGEST_S)
    length = np.array([REST_S + e.length for e in experiments])
    lasts = np.arange(during) < TICK_HZ * length[:, None]  # (e, t)
    stops = any(BY_NAME[e].ends_travel for rival in rivals for e in rival.problem.structure.effects)
    runs, holds = [], np.ones(len(experiments), bool)
    for rival in rivals:
        structure = rival.problem.structure
        y = simulated_outputs(structure, rival.theta, experiments, LONGEST_S + (WAIT_S if stops else 0.0))
        moved = {name: y[..., k] for k, name in enumerate(structure.outputs)}
        peak = peaks(moved)
        if stops:  # as in a plan whose travel is limited
            coasts = coasting_angle(moved["yaw_rad_s"])
            peak["yaw_rad"] = peak["yaw_rad"] + coasts
            holds &= coasts <= COASTING * within.limits["yaw_rad"]
        holds &= within.largest_share(peak) <= BEYOND
        runs.append((np.stack([moved[name][:, :during] for name in outputs], axis=-1) / error, peak))
    with np.errstate(over="ignore", invalid="ignore"):  # what leaves the range of numbers holds no limit
        apart = np.sum((runs[0][0] - runs[1][0]) ** 2, axis=-1)
    telling = np.where(holds, np.sqrt(np.sum(np.where(lasts, apart, 0.0), axis=1) / lasts.sum(axis=1)), 0.0)
    best = int(np.argmax(telling))
    names = [" + ".join(rival.names) for rival in rivals]
    if not holds.any():
        rest = f", or not let it come to rest within {WAIT_S:g} s" if stops else ""
        return Proposal(
            f"none found that separates {' and '.join(names)}: every command would take the rig further than these logs have gone{rest}"
        )
    if telling[best] < 1.0:
        return Proposal(
            f"no command within {within.volts:.3g} V, hardly further than these logs have gone, separates {' and '.join(names)}: "
            "there they are the same thing for this rig"
        )
    run = Run(
        name="next",
        experiment=experiments[best],
        role="train",
        why=f"separates {names[0]} from {names[1]}",
        tells_apart=tuple(dict.fromkeys(name for rival in rivals for name in rival.names)),
        reaches={name: float(values[best]) for name, values in runs[0][1].items()},
    )
    return Proposal(
        f"run {in_words(run.experiment)}: there {' and '.join(names)} differ by {telling[best]:.1f} times the error that is left",
        Plan(rig, within.known, (run,)),
    )


def in_words(e: Experiment) -> str:
    """An experiment as one would tell it."""
    if e.kind == "coast-down":
        return f"{e.amplitude:.3g} V for {e.period:g} s, then 0 V until standstill (coast-down)"
    between = f"between {e.offset - abs(e.amplitude):.3g} and {e.offset + abs(e.amplitude):.3g} V"
    return f"a {e.kind} {between} with a period of {e.period:g} s for {e.length:g} s"
