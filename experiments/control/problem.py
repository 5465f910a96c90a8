"""The rig, gains and references of the benchmark of control."""

import numpy as np

from rwjax import Rig, parse_rig

K, R, L, b, J, I = 0.0182, 0.83, 0.0641, 4.07e-6, 1.24e-4, 0.0495
VISCOUS, COULOMB, STATIC, V_S = 0.0026, 0.010, 0.016, 0.2
LIMIT, SMOOTH, PERIOD, STEPS, SAMPLES = 10.0, 0.02, 0.01, 4, 1000  # V, s, s; 10 s
SIGMA = 0.5


def rig(dry: bool = True) -> Rig:
    """The thesis's testbed, with Stribeck friction or without dry friction."""
    friction = f"coulomb = {COULOMB}\nstatic = {STATIC}\nstribeck_velocity = {V_S}" if dry else ""
    return parse_rig(
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\ninductance = {L}\nfriction = {b}\n[wheel]\n'
        f"inertia = {J}\n[axis]\ninertia = {I}\n[axis.friction]\nviscous = {VISCOUS}\n{friction}"
    )


def reference() -> np.ndarray:
    """A square wave of 0.35 rad, 5 s each way [rad]."""
    return np.where((PERIOD * np.arange(SAMPLES)) % 10.0 < 5.0, 0.35, 0.0)


def gains(count: int) -> tuple[np.ndarray, np.ndarray]:
    """About `count` gain pairs, a multiple of 8, of a square grid: kp and kd."""
    side = int(np.ceil(np.sqrt(count) / 8.0)) * 8
    kp, kd = np.meshgrid(np.linspace(5.0, 100.0, side), np.linspace(1.0, 40.0, side), indexing="ij")
    return np.ascontiguousarray(kp.ravel()), np.ascontiguousarray(kd.ravel())
