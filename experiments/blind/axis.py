"""The axis: its dry and smooth friction, loads, play or elasticity towards the drive, end stops."""

import numpy as np
from numba import njit

from experiments.blind.drive import SLOT, chance
from experiments.blind.truth import CONTACT, ELEMENTS, MEMORY, PSI, PSI_DRIVE, REST, TOUCH, W_DRIVE, W

WAVES = 7  # of the coloured noise of the torque


@njit
def fall(w, p):
    """Breakaway friction above the sliding friction, at a speed."""
    v, n = abs(w) / p.v_s, p.exponent
    if p.form == 1.0:
        return p.excess / (1.0 + v * v)
    power = v * v if n == 2.0 else (v if n == 1.0 else v**n)
    return p.excess * np.exp(-power)


@njit
def around(psi, p):
    """Factor on the dry friction by angle."""
    if p.angle_form == 1.0:
        spot = 0.5 + 0.5 * np.cos(psi + p.angle_phase)
        return 1.0 + p.angle_friction * spot**4
    return 1.0 + p.angle_friction * np.sin(p.angle_order * psi + p.angle_phase)


@njit
def rough(psi, p):
    """Factor on the dry friction by angle that never repeats from turn to turn."""
    waves = np.sin(3.713 * psi) + np.sin(9.137 * psi + 1.0) + np.sin(17.391 * psi + 2.0)
    return 1.0 + p.roughness * waves / 3.0


@njit
def dry_level(x, resting, load, warm, p):
    """Dry friction of the axis, before its difference between the directions."""
    level = p.coulomb
    if p.excess != 0.0:
        level += fall(x[W], p)
    if p.angle_friction != 0.0:
        level *= max(around(x[PSI], p), 0.0)
    if p.roughness != 0.0:
        level *= max(rough(x[PSI], p), 0.0)
    if p.drift != 0.0:
        level *= 1.0 + p.drift * warm
    if p.memory != 0.0:
        level *= 1.0 + p.memory * x[MEMORY]
    if p.dwell != 0.0 and resting:
        level += p.dwell * (1.0 - np.exp(-x[REST] / p.dwell_time))
    return level + p.load_friction * abs(load)


@njit
def warmth(t, p):
    """What is left of the cold rig's additional friction after a time: 1 at first, later 0."""
    if p.drift_form == 1.0:
        return max(1.0 - t / p.drift_time, 0.0)
    return np.exp(-t / p.drift_time)


@njit
def rumbling(t, salt):
    """Coloured noise of RMS 1 at a time of a run: waves of 0.2 to 13 Hz, of which slow ones are the larger."""
    total, power = 0.0, 0.0
    for k in range(WAVES):
        rate = 2.0 * np.pi * 0.2 * 2.0**k * (0.75 + 0.5 * chance(k, salt, 4.0))
        size = 2.0 ** (-0.5 * k)
        total += size * np.sin(rate * t + 2.0 * np.pi * chance(k, salt, 5.0))
        power += 0.5 * size * size
    return total / np.sqrt(power)


@njit
def push(t, p):
    """Torque on the axis (the wheel where there is no axis) that depends on time alone."""
    torque = p.bias_torque
    if p.periodic != 0.0:
        angle = p.periodic_rate * t + p.periodic_phase
        torque += p.periodic * (np.sin(angle) + p.periodic_2 * np.sin(2.0 * angle))
    if p.bursts != 0.0:
        slot = np.floor(t / SLOT)
        if slot > 0.0 and chance(slot, p.salt, 2.0) < 0.3:
            torque += p.bursts * (2.0 * chance(slot, p.salt, 3.0) - 1.0) * np.sin(np.pi * (t / SLOT - slot))
    if p.rumble != 0.0:
        torque += p.rumble * rumbling(t, p.salt)
    return torque


@njit
def smooth_load(x, warm, p):
    """Torques against the axis that are smooth in angle and speed: viscous, drag, gravity, spring, stop."""
    psi, w = x[PSI], x[W]
    torque = p.viscous * w
    if p.drift_viscous != 0.0:
        torque *= 1.0 + p.drift_viscous * warm
    if p.quadratic != 0.0:
        torque += p.quadratic * w * (abs(w) if p.quadratic_power == 2.0 else abs(w) ** (p.quadratic_power - 1.0))
    if p.gravity != 0.0:
        torque += p.gravity * np.sin(psi + p.gravity_angle)
    if p.imbalance != 0.0:
        torque += p.imbalance * np.sin(psi + p.imbalance_phase)
        if p.imbalance_2 != 0.0:
            torque += p.imbalance_2 * np.sin(2.0 * psi + p.imbalance_2_phase)
    if p.spring != 0.0:
        stretch = psi - p.spring_zero
        torque += p.spring * stretch + p.spring_3 * stretch**3
    if p.stop_form == 1.0:
        torque += soft_stop(x, p)
    return torque


@njit
def soft_stop(x, p):
    """Torque of the elastic end stop that the axis touches, which pushes and never pulls."""
    if x[TOUCH] > 0.0:
        return max(p.stop_stiffness * (x[PSI] - p.stop_high) + p.stop_damping * x[W], 0.0)
    if x[TOUCH] < 0.0:
        return min(p.stop_stiffness * (x[PSI] - p.stop_low) + p.stop_damping * x[W], 0.0)
    return 0.0


@njit
def coupling_torque(x, p):
    """Torque that an elastic coupling carries from the drive to the axis; none inside the gap."""
    twist, rate = x[PSI_DRIVE] - x[PSI], x[W_DRIVE] - x[W]
    if p.coupling == 1.0:
        return p.stiffness * twist + p.damping * rate
    if x[CONTACT] > 0.0:
        return max(p.stiffness * (twist - 0.5 * p.gap) + p.damping * rate, 0.0)
    if x[CONTACT] < 0.0:
        return min(p.stiffness * (twist + 0.5 * p.gap) + p.damping * rate, 0.0)
    return 0.0


@njit
def inertia(w, p):
    """Inertia of the axis; loads that move outwards raise it."""
    if p.moving_inertia == 0.0:
        return p.I
    return p.I * (1.0 + p.moving_inertia * w * w / (w * w + p.moving_speed**2))


@njit
def deflect(share, w, h, p, out):
    """Elastic friction after moving at `w` for `h`: share of the dry friction that each element carries."""
    travel = w * h / p.preslide
    if p.preslide_form == 3.0:
        for k in range(ELEMENTS):  # element k slips at (k + 1) / 2 of the reference displacement
            slip = 2.0 / (k + 1.0)
            out[k] = min(max(share[k] + slip * travel, -1.0), 1.0)
        return
    toward = np.sign(w)
    out[0] = toward + (share[0] - toward) * np.exp(-abs(travel))


@njit
def elastic_friction(share, w, forward, backward, p):
    """Dry friction in presliding, between -backward and forward."""
    total = share[0]
    if p.preslide_form == 3.0:
        total = (share[0] + share[1] + share[2] + share[3]) / ELEMENTS
    torque = total * (forward if total > 0.0 else backward)
    return torque + p.preslide_damping * (w - abs(w) * share[0]) if p.preslide_form == 1.0 else torque
