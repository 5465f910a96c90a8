"""How far experiments move a rig, by simulation: from rest, until some time after their end."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from jaxtyping import Float

from rwjax.fitting.problem import pose
from rwjax.logs.log import Log
from rwjax.planning.experiment import TICK_HZ, Experiment
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.batch import by_sample
from rwjax.simulation.shooting import free_run

TAIL_S = 5.0
"""Simulated after the end of an experiment: what coasts may go on into a stop."""
WAIT_S = 60.0
"""Simulated where travel is limited: `rwjax.link.play_plan` waits as long for a rig to come to rest."""
DECAY_S = 30.0
"""Over which a rate that is left has to fall, for the way that is left to be told from it."""


def log_of(experiment: Experiment, name: str, seconds: float, outputs: Collection[str] = ()) -> Log:
    """The experiment's command as a log of so many seconds, 0 V where it is over; of `outputs` there are only zeros."""
    _, volts = experiment.command()
    time = np.arange(round(TICK_HZ * seconds)) / TICK_HZ
    return Log(
        name=name,
        time=time,
        command=np.pad(volts, (0, max(len(time) - len(volts), 0)))[: len(time)],
        outputs={y: np.zeros_like(time) for y in outputs},
        resolution=dict.fromkeys(outputs, 0.0),
        notes={},
        validate=False,
        supply=None,
        origin=0.0,
    )


def readings(
    structure: Structure,
    theta: np.ndarray,
    experiments: Sequence[Experiment],
    seconds: float,
    begin: Float[np.ndarray, " e"] | None = None,
) -> Float[np.ndarray, "e t y"]:
    """Outputs of the rig, in the order of the structure's, at 100 Hz for so many seconds, from rest.

    `begin`: the angle [rad] of the axis from which each experiment begins, 0 without it.
    """
    logs = [log_of(experiment, experiment.kind, seconds) for experiment in experiments]
    problem = pose(structure, logs, {})
    start = np.zeros_like(problem.start)
    if begin is not None:
        start[:, structure.states.index("psi")] = begin
    y, _ = free_run(structure, theta, start, problem.batch)
    return np.stack([by_sample(problem.batch, k, np.asarray(y[k]), len(log.time)) for k, log in enumerate(logs)])


def motion(
    rig: Rig, experiments: Sequence[Experiment], seconds: float, begin: Float[np.ndarray, " e"] | None = None
) -> dict[str, Float[np.ndarray, "e t"]]:
    """`readings` of a rig by the name of the output."""
    structure = structure_of(rig)
    found = readings(structure, theta_of(rig, structure), experiments, seconds, begin)
    return {name: found[..., k] for k, name in enumerate(structure.outputs)}


def peaks(moved: Mapping[str, np.ndarray]) -> dict[str, Float[np.ndarray, " e"]]:
    """Largest size of every output over time; of an angle that is the travel from where it began."""
    return {name: np.max(np.abs(y), axis=-1) for name, y in moved.items()}


def left(rate: Float[np.ndarray, "e t"]) -> Float[np.ndarray, " e"]:
    """How far each axis [rad] goes on after its last sample, if its rate falls on as it fell over the last `DECAY_S`;
    infinite where it did not fall."""
    n = round(TICK_HZ * TAIL_S)
    late, back = np.max(np.abs(rate[:, -n:]), axis=1), round(TICK_HZ * DECAY_S)
    early = np.max(np.abs(rate[:, -n - back : -back]), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        falls = np.log(early / late)
        way = np.where(falls > 0.0, late * DECAY_S / falls, np.inf)
    return np.where(late == 0.0, 0.0, way)
