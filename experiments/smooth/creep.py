"""Creep: how far a body turns under a smooth sign that dry friction would hold."""

from dataclasses import replace

import numpy as np

from rwjax import Rig, simulate
from rwjax.control.breakaway import breakaway
from rwjax.simulation.solver import Solver

LASTS = 10.0  # s
SHARE = 0.5  # of the command at which the body breaks loose
LOADS = ("gravity", "bias", "deadzone")


def crept(width: float, share: float, seconds: float) -> float:
    """How far [rad] a body without viscous friction creeps under a share of its breakaway torque, in closed form.

    It settles where the smooth sign times the dry friction balances the torque: `tanh(w/width) = share`.
    """
    return width * float(np.arctanh(share)) * seconds


def unloaded(rig: Rig) -> Rig:
    """The rig without what turns it, or holds its command back, besides friction."""
    kept = {name: value for name, value in rig.numbers.items() if not any(load in name for load in LOADS)}
    effects = {name: given for name, given in rig.effects.items() if not any(load in name for load in LOADS)}
    return replace(rig, numbers=kept, effects=effects, free=(), standard_error={})


def held_command(rig: Rig) -> np.ndarray:
    """Half of the command [V] at which a body of an unloaded rig breaks loose; of two axes that of the first one."""
    n = rig.values
    if rig.kind in ("platform", "reaction"):
        return np.array(SHARE * breakaway(rig))
    if rig.kind == "wheel":
        return np.array(SHARE * n["wheel.coulomb.M_c"] * n["motor.resistance"] / n["motor.torque_constant"])
    least = n["yaw.friction.coulomb"] * n["motor_1.resistance"] / n["motor_1.torque_constant"]
    return np.array([SHARE * least, 0.0])


def creep(rig: Rig, solver: Solver) -> float:
    """How far [rad] a stuck body of the rig turns in a simulation under half of what would break it loose."""
    bare = unloaded(rig)
    time = 0.01 * np.arange(round(LASTS / 0.01) + 1)
    command = held_command(bare)
    run = simulate(bare, time, np.broadcast_to(command, (len(time), *command.shape)), solver=solver)
    if rig.kind == "wheel":  # its angle is no output: the mean rate times the time
        return LASTS * abs(float(np.mean(run["wheel_rad_s"])))
    return abs(float(run["yaw_rad"][-1] - run["yaw_rad"][0]))
