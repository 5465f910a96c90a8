"""A rig whose current alone limits its torque."""

import numpy as np

from rwjax.control.drive_limits import Limits

K, R, J, I = 0.0182, 0.83, 1.24e-4, 0.0495
AMPS, TOP = 3.0, 4000.0 * 2.0 * np.pi / 60.0
LIMITS = Limits(20.0, AMPS, TOP)  # V: so high that the current alone limits the torque
