"""How far experiments move a rig, by simulation: from rest, until some time after their end."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from rwjax.fitting.problem import pose
from rwjax.logs.driven import driven_by
from rwjax.logs.log import Log
from rwjax.planning.experiment import TICK_HZ, Experiment
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.batch import by_sample
from rwjax.simulation.free_run import free_run

TAIL_S = 5.0
"""Time [s] simulated after the end of an experiment: what coasts may go on into a stop."""
WAIT_S = 60.0
"""Time [s] simulated where travel is limited: `rwjax.link.play_plan` waits as long for a rig to come to rest."""
DECAY_S = 30.0
"""Time [s] over which a rate has to fall for the angle that is left to go to be told from it."""
STANDS = 1e-6
"""Rate [rad/s] up to which an axis stands: where friction just holds a load, a rate that is left over need not fall."""


def command_log(experiment: Experiment, name: str, seconds: float) -> Log:
    """The command of an experiment as a log without outputs.

    Args:
        experiment: The experiment.
        name: Name of the log.
        seconds: Length of the log [s]; the command is 0 where the experiment is over.

    Returns:
        The log.
    """
    _, given = experiment.command()
    on = experiment.enabled()
    time = np.arange(round(TICK_HZ * seconds)) / TICK_HZ
    more = max(len(time) - len(given), 0)
    return Log(
        name=name,
        time=time,
        command=np.pad(given, (0, more))[: len(time)],
        outputs={},
        resolution={},
        notes={},
        validate=False,
        supply=None,
        origin=0.0,
        input=experiment.input,
        enabled=np.pad(on, (0, more), mode="edge")[: len(time)] if experiment.switches else None,
    )


def simulated_outputs(
    structure: Structure,
    theta: Float[np.ndarray, " p"],
    experiments: Sequence[Experiment],
    seconds: float,
    begin: Float[np.ndarray, " e"] | None = None,
    supply: float | None = None,
) -> Float[np.ndarray, "e t y"]:
    """Outputs of a plant in experiments from rest, at `TICK_HZ`.

    Args:
        structure: Structure of the plant.
        theta: Parameter vector of that structure, `(p,)` [SI].
        experiments: e experiments.
        seconds: Time that is simulated [s].
        begin: Angle of the axis from which each experiment begins [rad], `(e,)`; 0 without it.
        supply: Voltage of the supply [V] of which a servo gives a share, where the plant does not know it.

    Returns:
        Outputs [SI] in the structure's order, `(e, t, y)`.
    """
    logs = [command_log(experiment, experiment.kind, seconds) for experiment in experiments]
    if supply is not None:
        logs = [replace(log, supply=np.full(len(log.time), supply)) for log in logs]
    problem = pose(structure, logs, {})
    start = np.zeros_like(problem.start)
    if begin is not None:
        start[:, structure.states.index("psi")] = begin
    y, _ = free_run(structure, theta, start, problem.batch, solver=problem.solver)
    return np.stack([by_sample(problem.batch, k, np.asarray(y[k]), len(log.time)) for k, log in enumerate(logs)])


def simulated_motion(
    rig: Rig, experiments: Sequence[Experiment], seconds: float, begin: Float[np.ndarray, " e"] | None = None
) -> dict[str, Float[np.ndarray, "e t"]]:
    """Outputs of a rig in experiments from rest, by name.

    Args:
        rig: The rig.
        experiments: e experiments.
        seconds: Time that is simulated [s].
        begin: Angle of the axis from which each experiment begins [rad], `(e,)`; 0 without it.

    Returns:
        Each output [SI] at `TICK_HZ`, `(e, t)`.

    Raises:
        RigError: Where the command of the first experiment cannot drive the rig.
    """
    rig = driven_by(rig, experiments[0].input, any(experiment.switches for experiment in experiments))
    structure = structure_of(rig)
    found = simulated_outputs(structure, theta_of(rig, structure), experiments, seconds, begin)
    return {name: found[..., k] for k, name in enumerate(structure.outputs)}


def peaks(moved: Mapping[str, np.ndarray]) -> dict[str, Float[np.ndarray, " e"]]:
    """Largest size of every output over time; of an angle that began at 0 this is the travel.

    Args:
        moved: Outputs [SI] by name, `(e, t)` each.

    Returns:
        Peaks [SI] by name, `(e,)` each.
    """
    return {name: np.max(np.abs(y), axis=-1) for name, y in moved.items()}


def coasting_angle(rate: Float[np.ndarray, "e t"]) -> Float[np.ndarray, " e"]:
    """Angle [rad] through which each axis goes on after its last sample.

    Its rate is taken to fall on as it fell over the last `DECAY_S`.

    Args:
        rate: Rate of the axis [rad/s] at `TICK_HZ`, `(e, t)`.

    Returns:
        The angle [rad], `(e,)`; 0 where the axis stands, infinite where the rate did not fall.
    """
    n = round(TICK_HZ * TAIL_S)
    late, back = np.max(np.abs(rate[:, -n:]), axis=1), round(TICK_HZ * DECAY_S)
    early = np.max(np.abs(rate[:, -n - back : -back]), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        falls = np.log(early / late)
        angle = np.where(falls > 0.0, late * DECAY_S / falls, np.inf)
    return np.where(late <= STANDS, 0.0, angle)
