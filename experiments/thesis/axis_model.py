"""Eq. 4.7 to 4.9: the axis with its friction, linearised with the static part fed forward, against what this leaves out."""

from pathlib import Path

import jax.numpy as jnp
import numpy as np

from experiments.thesis.regenerate import FRICTION
from experiments.thesis.table import row
from experiments.thesis.testbed import INERTIA, RIG
from rwjax import Rig, parse_rig
from rwjax.control.breakaway import breakaway
from rwjax.control.linear import linearised
from rwjax.control.open_loop import open_loop
from rwjax.control.transfer import Transfer, transfer
from rwjax.kinds import COEFFICIENTS
from rwjax.plant.from_rig import structure_of, theta_of

TORQUE, RATES = 0.01, (0.0, 1.38, 5.0)  # N m beyond what is fed forward; rad/s
TIMES, STEP = (1.0, 2.0, 4.0), 1e-3  # s


def axis() -> Rig:
    """Chapter 4's axis alone, driven by a torque: 1 V stands for 1 N m."""
    return parse_rig(
        f'kind = "platform"\nname = "axis of chapter 4"\n[drive]\ngain = 1.0\n[axis]\ninertia = {INERTIA}\n[axis.friction]\n'
        f"polynomial = {[RIG.numbers[name] for name in COEFFICIENTS]}"
    )


def linear() -> Transfer:
    """Eq. 4.9, torque to angle."""
    return transfer(linearised(axis()))


def linear_rate(torque: float, t: float) -> float:
    """Rate [rad/s] of eq. 4.9 after a time under a torque [N m]."""
    slope = FRICTION.coef[1]
    return torque / INERTIA / -slope * np.expm1(-slope * t)


def rates(torque: float) -> np.ndarray:
    """Rates [rad/s] of the nonlinear axis at `TIMES` under a torque besides the breakaway friction, fed forward."""
    structure = structure_of(axis())
    count = round(TIMES[-1] / STEP)
    commands = jnp.full(count, breakaway(axis()) + torque)
    start = jnp.zeros(len(structure.states))
    found = open_loop(structure, jnp.asarray(theta_of(axis(), structure)), commands, TIMES[-1], start)
    return np.asarray(found.rate)[[round(t / STEP) for t in TIMES]]


def axis_model(folder: Path) -> None:
    """Eq. 4.7 to 4.9: friction of the axis, and its linearisation with the static part fed forward."""
    printed = ", ".join(f"{INERTIA * FRICTION(w):.4f}" for w in RATES)
    row("eq. 4.7: friction at 0, 1.38 and 5 rad/s [N m]", "", printed)
    row("… torque at which the rig breaks loose, to be fed forward [N m]", "", f"{breakaway(axis()):.4f}")
    plant, slope = linear(), FRICTION.coef[1]
    row(
        "eq. 4.9: gain 1/I [1/(kg m2)]; poles 0 and -b2/I [1/s]",
        f"{1.0 / INERTIA:.3f}; 0, {-slope:.4f}",
        f"{plant.num[0]:.3f}; " + ", ".join(f"{p:.4f}" for p in sorted(np.roots(plant.den).real)),
    )
    row(
        f"rate after {', '.join(f'{t:g}' for t in TIMES)} s of {1e3 * TORQUE:g} mN m beyond that, eq. 4.9 and eq. 4.7 [rad/s]",
        ", ".join(f"{linear_rate(TORQUE, t):.3f}" for t in TIMES),
        ", ".join(f"{w:.3f}" for w in rates(TORQUE)),
    )


if __name__ == "__main__":
    axis_model(Path())
