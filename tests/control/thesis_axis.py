"""The axis of the thesis, and the grid of its gains."""

import numpy as np

from rwjax import parse_rig

J, b, R, L, K, I = 1.24e-4, 4.07e-6, 0.83, 0.1, 0.0182, 0.0432 + 0.3 * 0.145**2
SLOPE = -5.2491e-2  # 1/s, b2/I of listing A.4
THESIS = parse_rig(
    f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\ninductance = {L}\nfriction = {b}\n[wheel]\n'
    f"inertia = {J}\n[axis]\ninertia = {I}\n[axis.friction]\n"
    f"polynomial = [{0.3757 * I}, {SLOPE * I}, {0.020461 * I}, {-6.8912e-4 * I}]"
)
GRID = np.linspace(0.0, 100.0, 101)
