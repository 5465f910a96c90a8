"""rwjax: a rig file with inertia and viscous friction alone; the diagnosis has to find what it lacks."""

import numpy as np

import rwjax

RIG = rwjax.parse_rig("""
kind = "platform"
drive.gain = 35.15065
axis.inertia = 80.0
axis.friction.viscous = 250.0
fit.free = ["axis.inertia", "axis.friction.viscous"]
""")
sentence: list[str] = []


def fit(t: np.ndarray, u: np.ndarray, x: np.ndarray) -> rwjax.Rig:
    """The corrected rig."""
    found = rwjax.diagnose(RIG, [rwjax.Log.from_arrays(RIG, time=t, voltage_V=u, position_m=x)])
    sentence[:] = [found.sentence]
    return found.corrected


def run(rig: rwjax.Rig, t: np.ndarray, u: np.ndarray, first: float) -> np.ndarray:
    """A free run."""
    return np.asarray(rwjax.simulate(rig, t, u, start={"psi": first})["yaw_rad"])


def says() -> str:
    """What it names."""
    return sentence[0]
