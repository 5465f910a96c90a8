"""Rigs, logs and free runs for tests."""

import numpy as np

from rwjax import Log, parse_rig
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.batch import by_sample
from rwjax.simulation.free_run import free_run

MOTOR = """
[motor]
torque_constant = 0.0182
resistance = 0.83
inductance = 0.0641
friction = 4.07e-6
[wheel]
inertia = 1.24e-4
"""
AXIS = """
[axis]
inertia = 0.0495
[axis.friction]
viscous = 0.0026
"""


def wheel(inductance: float = 0.0641) -> Rig:
    """The thesis's motor and wheel."""
    text = MOTOR.replace("0.0641", repr(inductance))
    return parse_rig(f'kind = "wheel"\n{text}\n[fit]\nfree = ["wheel.inertia", "motor.friction"]')


def platform(friction: str = "viscous = 0.02\ncoulomb = 0.05", free: str = '"axis.inertia"') -> Rig:
    """A platform of 0.1 kg m2 and 0.4 N m/V."""
    return parse_rig(
        f'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\n{friction}\n[fit]\nfree = [{free}]'
    )


def reaction(friction: str = "viscous = 0.0026") -> Rig:
    """The thesis's testbed in yaw."""
    axis = AXIS.replace("viscous = 0.0026", friction)
    return parse_rig(f'kind = "reaction"\n{MOTOR}{axis}\n[fit]\nfree = ["axis.inertia"]')


def record(time: np.ndarray, command: np.ndarray, outputs: dict[str, np.ndarray] | None = None, **more: object) -> Log:
    """A log in memory; readings that are not given are zero and only ask for the output."""
    given = outputs if outputs is not None else {"yaw_rad": np.zeros_like(time)}
    fields = dict(resolution=dict.fromkeys(given, 0.0), notes={}, validate=False, supply=None, origin=float(time[0]))
    return Log(name="test.csv", time=time, command=command, outputs=given, **(fields | more))


def run(
    rig: Rig,
    log: Log,
    start: dict[str, float],
    *,
    effects: dict[str, dict[str, float]] | None = None,
    refine: int = 1,
) -> dict[str, np.ndarray]:
    """Readings of a free run at the log's times, from a start by state name (others 0)."""
    effects = effects or {}
    structure = structure_of(rig).with_effects(*effects)
    theta = theta_of(rig, structure)
    for effect, given in effects.items():
        for name, value in given.items():
            theta[structure.names.index(f"{effect}.{name}")] = value
    problem = pose(structure, (log,), dict.fromkeys(log.outputs, 1.0), refine=refine)
    x0 = np.array([[start.get(name, 0.0) for name in structure.states]])
    y, _ = free_run(structure, theta, x0, problem.batch)
    readings = by_sample(problem.batch, 0, np.asarray(y)[0], len(log.time))
    return {name: readings[:, k] for k, name in enumerate(structure.outputs)}
