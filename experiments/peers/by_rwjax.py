"""rwjax: the four terms that the authors published, fitted."""

import numpy as np

import rwjax

RIG = rwjax.parse_rig("""
kind = "platform"
drive.gain = 35.15065
axis.inertia = 80.0
axis.friction.viscous = 250.0
axis.friction.coulomb = 10.0
[effects."axis.bias_torque"]
T = 0.0
[fit]
free = ["axis.inertia", "axis.friction.viscous", "axis.friction.coulomb", "axis.bias_torque.T"]
""")
SAYS = "nothing: the four terms were put in by hand"


def fit(t: np.ndarray, u: np.ndarray, x: np.ndarray) -> rwjax.Rig:
    """The four terms."""
    return rwjax.fit(RIG, [rwjax.Log.from_arrays(RIG, time=t, voltage_V=u, position_m=x)]).rig


def run(rig: rwjax.Rig, t: np.ndarray, u: np.ndarray, first: float) -> np.ndarray:
    """A free run."""
    return np.asarray(rwjax.simulate(rig, t, u, start={"psi": first})["yaw_rad"])
