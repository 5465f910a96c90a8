"""What a fit says of a rig with a reaction wheel."""

import numpy as np

from rwjax.control.fit_estimate import FitEstimate

NAMES = ("axis.inertia", "motor.torque_constant", "axis.friction.viscous")
MEAN = np.array([0.0495, 0.0182, 0.0026])
ROOT = np.diag(0.1 * MEAN) @ np.array([[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.3, 0.9]])
ESTIMATE = FitEstimate(NAMES, MEAN, ROOT @ ROOT.T)
