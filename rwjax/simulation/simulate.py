"""Free run of a rig under a command, for users: `simulate`."""

from collections.abc import Mapping

import numpy as np

from rwjax.errors import InputError, nearest
from rwjax.kinds import TWO_AXIS
from rwjax.logs.log import Log
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from rwjax.simulation.free_run import free_run
from rwjax.simulation.layout import lay_out
from rwjax.simulation.stepper import Stepper
from rwjax.simulation.trajectory import Trajectory, trajectory_of


def simulate(
    rig: Rig,
    time: np.ndarray,
    command: np.ndarray,
    *,
    start: Mapping[str, float] | None = None,
    stepper: Stepper = EXPONENTIAL_STEP,
) -> Trajectory:
    """Free run of a rig under a command, which is held between samples.

    Args:
        rig: The rig, with its effects.
        time: Times of the samples `(n,)` [s], increasing; the run begins at the first one.
        command: Command at these times `(n,)`, of a rig with two axes `(n, 2)` [V].
        start: First values of states by name, as `{"w": 2.0}` [SI]; those not given are 0, at rest.
        stepper: What moves the plant over one time step.

    Returns:
        Every output that the kind of rig has, at these times.

    Raises:
        InputError: Times or command are unusable, or the rig lacks a state that is given.
    """
    structure, log = structure_of(rig), _log_of(rig, time, command)
    first = np.array([_start_of(structure, start or {})])
    batch = lay_out(structure, (log,), [{}])
    y, _ = free_run(structure, theta_of(rig, structure), first, batch, stepper=stepper)
    return trajectory_of(structure, batch, 0, log, np.asarray(y)[0])


def _log_of(rig: Rig, time: np.ndarray, command: np.ndarray) -> Log:
    """Log without readings; raises `InputError` where times or command are unusable."""
    time, command = np.asarray(time, float), np.asarray(command, float)
    if time.ndim != 1 or len(time) < 2:
        raise InputError(f"`time` has the shape {time.shape}; give the times of at least two samples, (n,)")
    shape = (len(time), 2) if rig.kind in TWO_AXIS else (len(time),)
    if command.shape != shape:
        raise InputError(f"`command` has the shape {command.shape}; a `{rig.kind}` rig takes {shape} here, in volts")
    if not (np.isfinite(time).all() and np.isfinite(command).all()):
        raise InputError("`time` and `command` have to be finite numbers")
    if not np.all(np.diff(time) > 0.0):
        late = int(np.argmin(np.diff(time) > 0.0)) + 1
        raise InputError(f"`time` does not increase: {time[late]:g} s follows {time[late - 1]:g} s at sample {late}")
    return Log(rig.name, time, command, {}, {}, {}, False, None, float(time[0]))


def _start_of(structure: Structure, start: Mapping[str, float]) -> list[float]:
    """First state; raises `InputError` for a name that is no state of the rig."""
    for name, value in start.items():
        if name not in structure.states:
            like, states = nearest(name, structure.states), ", ".join(structure.states)
            raise InputError(f"no state `{name}`, nearest `{like}`; this rig has {states}")
        if not np.isfinite(value):
            raise InputError(f"start `{name}` {value:g}: has to be a finite number")
    return [float(start.get(name, 0.0)) for name in structure.states]
