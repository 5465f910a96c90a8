"""A rig with a reaction wheel whose limits are sized."""

import numpy as np

from rwjax import parse_rig

K, R, I = 0.0182, 0.83, 0.0495
TOP = 4000.0 * 2.0 * np.pi / 60.0


def rig(friction: float, J: float = 1.24e-4, more: str = ""):
    return parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\n[wheel]\ninertia = {J}\n'
        f"[axis]\ninertia = {I}\n[axis.friction]\ncoulomb = {friction}\n{more}"
    )


LOADED = '[effects."axis.load_friction"]\nmu = 0.3'
