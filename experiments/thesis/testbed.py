"""The yaw testbed of chapter 4 as listing A.4 has it, with the friction of eq. 3.14 (corrected) per unit of inertia."""

import numpy as np

from experiments.thesis.motor import L_CHAPTER_4, SLOPE, J, K, R, friction_from_limit_speed
from experiments.thesis.regenerate import FRICTION
from rwjax import Rig, parse_rig

INERTIA = 0.0432 + 0.3 * 0.145**2  # kg m2, listing A.4: rig, and a mass of 0.3 kg at 0.145 m
TOP = 4000.0 * 2.0 * np.pi / 60.0  # rad/s, eq. 2.1
VOLTS = 10.0  # V, limit of the thesis's tests
AMPS = 3.0  # A, listing A.3


def yaw_testbed(inductance: float = L_CHAPTER_4, friction: bool = True) -> Rig:
    """The rig; without inductance where it is 0, on a frictionless axis where there is to be none."""
    dry = f"[axis.friction]\npolynomial = {(INERTIA * FRICTION.coef).tolist()}" if friction else ""
    lag = f"inductance = {inductance}" if inductance else ""
    return parse_rig(
        f'kind = "reaction"\nname = "thesis, chapter 4"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n{lag}\n'
        f"friction = {friction_from_limit_speed(SLOPE)}\n[wheel]\ninertia = {J}\n[axis]\ninertia = {INERTIA}\n{dry}"
    )
