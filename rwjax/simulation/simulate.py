"""Free run of a rig under a command, for users: `simulate`."""

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jax.flatten_util import ravel_pytree

from rwjax.errors import InputError, nearest, refuses_other_types
from rwjax.kinds import GIVEN, GOAL, TWO_AXIS
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.effect_section import rig_value
from rwjax.rig.model import Rig
from rwjax.simulation.exact import EXACT
from rwjax.simulation.free_run import free_run
from rwjax.simulation.layout import finer, lay_out
from rwjax.simulation.solver import Solver
from rwjax.simulation.trajectory import Trajectory, trajectory_of


@refuses_other_types
def simulate(
    rig: Rig,
    time: np.ndarray,
    command: Any,
    *,
    numbers: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    solver: Solver = EXACT,
) -> Trajectory:
    """Free run of a rig under a command, which is held between samples.

    A pure function of `numbers`, `start` and `command`: `jax.jit`, `vmap`, `grad` and `jacfwd` go through it, and through what
    is worked out from the run. With a smooth solver and more than 64 traced values, as of a whole command, it knows reverse mode
    alone. A run that fails, as of an unstable rig, is infinite from there on. Through the exact solver a derivative is that of the
    motion with its times of stick and slip: right where it exists.

    Args:
        rig: The rig, with its effects.
        time: Times of the samples `(n,)` [s], increasing; the run begins at the first one.
        command: Command at these times `(n,)`, of a rig with two axes `(n, 2)` [V]. Or what a log's columns say, by their names,
            as `{"goal_rad": …, "enabled": …}`, each `(n,)`.
        numbers: Values [SI] in place of the rig's own, by name, as `{"axis.inertia": 0.2}`.
        start: First values of states by name, as `{"w": 2.0}` [SI]; those not given are 0, at rest.
        solver: What moves the plant through the run; none of its numbers may be traced.

    Returns:
        Every output that the kind of rig has, at these times.

    Raises:
        InputError: Times or command are unusable, the rig lacks a number or a state that is given, a rig file may not give a number
            this value, the solver is traced, or an argument is of another type.
        jax.errors.JAXTypeError: `time`, or what is beside the command, is traced.
    """
    numbers, start = dict(numbers or {}), dict(start or {})
    if any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(solver)):
        raise InputError("a number of the solver is traced; make the solver outside of what JAX transforms")
    columns = dict(command) if isinstance(command, Mapping) else {"voltage_V": command}
    rig, (log,) = driven(rig, [_log_of(rig, time, columns)])
    command = columns[log.input] if log.input in columns else log.supply * columns["duty"]
    structure = structure_of(rig)
    _check_names("number", numbers, [name for name in structure.names if name not in rig.tied])
    _check_names("state", start, structure.states)
    solver = solver.suited(rig, (log,))
    batch = lay_out(structure, (log,), [{}], refine=finer(structure, (log,)))
    held = np.minimum(np.arange(batch.u_command.shape[1]), len(log.time) - 1)
    varies = {"numbers": numbers, "start": start} | ({"command": command} if isinstance(command, Tracer) else {})
    solver = solver.by_commands() if "command" in varies else solver
    own = theta_of(rig, structure), np.zeros(len(structure.states))

    def run(solver: Solver, given: Mapping[str, Any]) -> Any:
        theta, first = (
            _with(values, names, given[key])
            for values, names, key in zip(own, (structure.names, structure.states), ("numbers", "start"), strict=True)
        )
        u = batch._replace(u_command=given["command"][held][None]) if "command" in given else batch
        return free_run(structure, theta, first[None], u, solver=solver)[0][0]

    if any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(varies)):
        z, unravel = ravel_pytree(jax.tree.map(lambda value: jnp.asarray(value, float), varies))
        readings = solver.of_vector(lambda solver, z: run(solver, unravel(z)), z)
    else:
        readings = np.asarray(run(solver, varies))
    return trajectory_of(structure, batch, log, readings)


def _with(values: np.ndarray, names: Sequence[str], given: Mapping[str, Any]) -> Any:
    """A vector with some values, which may be traced, in place of its own."""
    if not any(isinstance(value, Tracer) for value in given.values()):
        return np.array([given.get(name, value) for name, value in zip(names, values, strict=True)], float)
    return jnp.stack([jnp.asarray(given.get(name, value), float) for name, value in zip(names, values, strict=True)])


def _array(argument: str, values: Any) -> np.ndarray:
    """Numbers as an array; raises `InputError` for anything else, and JAX's own error for what is traced."""
    try:
        return np.asarray(values, float)
    except jax.errors.JAXTypeError:  # traced: JAX says it best
        raise
    except (TypeError, ValueError, OverflowError) as error:
        several = isinstance(values, Sequence) and not isinstance(values, str)
        lengths = {len(row) if isinstance(row, Sequence | np.ndarray) else 0 for row in values} if several else set()
        if isinstance(error, OverflowError):
            what = "holds a number that is too large"
        elif len(lengths) > 1 and not any(isinstance(row, str) for row in values):
            what = "holds rows of different lengths"
        else:
            what = "holds what is no number" if several else f"is a `{type(values).__name__}`"
        raise InputError(f"`{argument}` {what}; it has to be an array of numbers") from None


def _check_names(what: str, given: Mapping[str, Any], names: Sequence[str]) -> None:
    """Raises `InputError` for a name that the rig does not have, and for a value that is no finite number or none that a file may hold."""
    for name, value in given.items():
        if name not in names:
            raise InputError(f"no {what} `{name}`, nearest `{nearest(name, names)}`; this rig has {', '.join(names)}")
        if isinstance(value, Tracer):
            continue
        number = np.ndim(value) == 0 and isinstance(value, Real | np.ndarray | jax.Array)
        try:
            finite = number and np.isfinite(float(value))
        except OverflowError:
            raise InputError(f"{what} `{name}` is too large: has to be a finite number") from None
        if not finite:
            raise InputError(f"{what} `{name}` {value}: has to be a finite number")
        if what == "number":
            rig_value(name, float(value))


def _log_of(rig: Rig, time: np.ndarray, columns: Mapping[str, Any]) -> Log:
    """Log without readings; raises `InputError` where times or command are unusable."""
    beside = {name: _array(name, columns[name]) for name in ("enabled", "supply_V") if name in columns}
    inputs = [name for name in columns if name not in beside]
    if len(inputs) != 1 or inputs[0] not in (*GIVEN, GOAL):
        said = ", ".join(f"`{name}`" for name in columns) or "nothing"
        raise InputError(
            f"`command` holds {said}; it has one of {', '.join((*GIVEN, GOAL))}, and `enabled` and `supply_V` beside"
        )
    command, time = columns[inputs[0]], _array("time", time)
    command = np.zeros(command.shape) if isinstance(command, Tracer) else _array("command", command)
    if time.ndim != 1 or len(time) < 2:
        raise InputError(f"`time` has the shape {time.shape}; give the times of at least two samples, (n,)")
    shape = (len(time), 2) if rig.kind in TWO_AXIS else (len(time),)
    if command.shape != shape:
        raise InputError(
            f"`command` has the shape {command.shape}; a `{rig.kind}` rig takes {shape} here, in the unit of `{inputs[0]}`"
        )
    if wrong := next((name for name, values in beside.items() if values.shape != time.shape), None):
        raise InputError(f"`{wrong}` has the shape {beside[wrong].shape}; it takes {time.shape} here")
    if not all(np.isfinite(values).all() for values in (time, command, *beside.values())):
        raise InputError("`time` and `command` have to be finite numbers")
    if not np.all(np.diff(time) > 0.0):
        late = int(np.argmin(np.diff(time) > 0.0)) + 1
        raise InputError(f"`time` does not increase: {time[late]:g} s follows {time[late - 1]:g} s at sample {late}")
    return Log(
        rig.name,
        time,
        command,
        {},
        {},
        {},
        False,
        beside.get("supply_V"),
        float(time[0]),
        input=inputs[0],
        enabled=beside["enabled"] > 0.0 if "enabled" in beside else None,
    )
