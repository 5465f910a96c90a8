"""Truth: rigs simulated with exact stick and slip in steps of 0.1 ms; shares no code with `rwjax`.

Command (`drive`), winding and wheel (`motor`), axis (`axis`); what the encoders make of it is in `sensors`. A body at
rest stays at exactly 0 while the torque on it is below breakaway. Steps are midpoint steps of fixed direction; where a
speed would change its sign, an end stop is met or a gap closes, the step is cut at the crossing of its chord and the
rest of the step decides anew.
"""

import numpy as np
from numba import njit

from experiments.blind.axis import (
    coupling_torque,
    deflect,
    dry_level,
    elastic_friction,
    inertia,
    push,
    smooth_load,
    warmth,
)
from experiments.blind.drive import SLOT, follow, shape
from experiments.blind.motor import current, current_rate, heat_rate, motor_torque, wheel_level, wheel_losses
from experiments.blind.truth import (
    AMPERE,
    CONTACT,
    ELEMENTS,
    HEAT,
    LAG_1,
    LAG_2,
    LOAD,
    LOST,
    MEMORY,
    MOVED,
    OMEGA,
    PLAY,
    PSI,
    PSI_DRIVE,
    REST,
    SHARE,
    SLEW,
    STATES,
    THETA,
    TOUCH,
    W_DRIVE,
    Truth,
    W,
)

__all__ = ["STEP", "Truth", "run", "simulate"]

STEP = 1e-4  # s
CUTS = 8  # most events resolved within one step
BOUNCE = 0.01  # rad/s, below which a body stays at a hard stop
NOTHING, AXIS_RESTS, WHEEL_RESTS, STOPS, GAP_CLOSES, CAPPED = range(6)


@njit
def friction(rate, torque, level_forward, level_backward):
    """Dry friction that opposes `rate`, or holds against `torque` at rest."""
    if rate > 0.0:
        return level_forward
    if rate < 0.0:
        return -level_backward
    return min(max(torque, -level_backward), level_forward)


@njit
def missed_rate(w, p):
    """Speed by which an encoder that loses counts falls behind."""
    over = abs(w) - p.missed_above
    if p.missed == 0.0 or over <= 0.0:
        return 0.0
    share = 1.0 - np.exp(-p.missed)
    return share * (w if p.missed_form == 0.0 else np.sign(w) * over)


@njit
def wheel_rates(x, spin, v, burst, p, out):
    """Rates of wheel and winding; returns the torque that moves the wheel and pushes the body back."""
    omega = x[OMEGA]
    i = current(x, v, p)
    free = motor_torque(i, p) - wheel_losses(x, p) + burst
    level = wheel_level(omega, p)
    shaft = free - friction(spin, free, level, level)
    out[THETA], out[OMEGA] = omega, shaft / p.J
    if p.kind == 0.0:
        if p.moving_inertia != 0.0:
            out[OMEGA] *= p.I / inertia(omega, p)
        out[LOST] = missed_rate(omega, p)
    out[AMPERE] = 0.0 if p.L == 0.0 else current_rate(x, v, p)
    out[HEAT] = heat_rate(x, i, p)
    return shaft


@njit
def apart(x, p):
    """Whether drive and axis move on their own; at a closed hard gap they are one body."""
    return p.coupling != 0.0 and not (p.coupling == 3.0 and x[CONTACT] != 0.0)


@njit
def axis_rates(x, slide, drive, outer, warm, p, out):
    """Rates of the axis and of the drive's side of a coupling under the torque `drive`."""
    w, mass = x[W], inertia(x[W], p)
    out[PSI], out[LOST] = w, missed_rate(w, p)
    carried = drive
    if p.coupling == 1.0 or p.coupling == 2.0:
        carried = coupling_torque(x, p)
    elif apart(x, p):
        carried = 0.0
    level = dry_level(x, slide == 0.0, carried, warm, p)
    forward, backward = max(level + p.asymmetry, 0.0), max(level - p.asymmetry, 0.0)
    free = carried + outer - smooth_load(x, warm, p)
    if p.preslide_form > 0.0:
        dry = elastic_friction(x[SHARE : SHARE + ELEMENTS], w, forward, backward, p)
    else:
        dry = friction(slide, free, forward, backward)
    if p.coupling == 0.0:
        out[W] = (free - dry) / mass
        out[PSI_DRIVE], out[W_DRIVE] = out[PSI], out[W]
        return
    out[PSI_DRIVE] = x[W_DRIVE]
    if apart(x, p):
        out[W] = (free - dry) / (mass * (1.0 - p.drive_share))
        out[W_DRIVE] = (drive - carried) / (mass * p.drive_share)
    else:
        out[W] = (free - dry) / mass
        out[PSI_DRIVE], out[W_DRIVE] = w, out[W]


@njit
def rates(x, slide, spin, v, outer, warm, p, out):
    """Rates of the moved states; the directions of sliding are given, 0 is at rest."""
    drive = 0.0
    if p.kind != 1.0:
        drive = -wheel_rates(x, spin, v, outer if p.kind == 0.0 else 0.0, p, out)
    if p.kind != 0.0:
        if p.kind == 1.0:
            drive = p.gain * v
        if p.angle_gain != 0.0:
            drive *= np.exp(p.angle_gain * np.sin(x[PSI] + p.angle_gain_phase))
        axis_rates(x, slide, drive, outer, warm, p, out)
    return drive


@njit
def crossing(old, new):
    """Share of the way from `old` to `new` at which 0 is passed; above 1 where it is not."""
    return old / (old - new) if old * new < 0.0 else 2.0


@njit
def meeting(ahead, motion):
    """Share of a motion at which a body `ahead` (negative) of an obstacle meets it; above 1 where it does not."""
    if motion <= 0.0 or ahead + motion <= 0.0:
        return 2.0
    return max(-ahead, 0.0) / motion


@njit
def next_event(x, k, h, p):
    """What happens first on the chord of a step, and at which share of it."""
    cut, event = 1.0, NOTHING
    if p.preslide_form == 0.0 and p.kind != 0.0:
        share = crossing(x[W], x[W] + h * k[W])
        if share < cut:
            cut, event = share, AXIS_RESTS
    if p.wheel_coulomb > 0.0:
        share = crossing(x[OMEGA], x[OMEGA] + h * k[OMEGA])
        if share < cut:
            cut, event = share, WHEEL_RESTS
    if p.stop_form > 0.0 and x[TOUCH] == 0.0:
        move = h * k[PSI]
        share = min(meeting(x[PSI] - p.stop_high, move), meeting(p.stop_low - x[PSI], -move))
        if share < cut:
            cut, event = share, STOPS
    if p.coupling >= 2.0 and x[CONTACT] == 0.0:
        twist, move = x[PSI_DRIVE] - x[PSI], h * (k[PSI_DRIVE] - k[PSI])
        share = min(meeting(twist - 0.5 * p.gap, move), meeting(-twist - 0.5 * p.gap, -move))
        if share < cut:
            cut, event = share, GAP_CLOSES
    if p.current_limit > 0.0 and p.foldback == 0.0:
        move = h * k[AMPERE]
        share = min(meeting(x[AMPERE] - p.current_limit, move), meeting(-x[AMPERE] - p.current_limit, -move))
        if share < cut:
            cut, event = share, CAPPED
    return cut, event


@njit
def happen(x, event, p):
    """State right after an event."""
    if event == AXIS_RESTS:
        x[W] = 0.0
        if not apart(x, p):
            x[W_DRIVE] = 0.0
    elif event == WHEEL_RESTS:
        x[OMEGA] = 0.0
    elif event == STOPS:
        high = 2.0 * x[PSI] > p.stop_low + p.stop_high  # the rate may have turned in the same step
        x[PSI] = p.stop_high if high else p.stop_low
        if p.stop_form == 1.0:
            x[TOUCH] = 1.0 if high else -1.0
            return
        rebound = p.restitution * abs(x[W]) if p.restitution * abs(x[W]) > BOUNCE else 0.0
        x[W] = -rebound if high else rebound
        if not apart(x, p):
            x[W_DRIVE] = x[W]
    elif event == GAP_CLOSES:
        x[CONTACT] = 1.0 if x[PSI_DRIVE] > x[PSI] else -1.0
        x[PSI_DRIVE] = x[PSI] + 0.5 * p.gap * x[CONTACT]
        if p.coupling == 3.0:
            x[W] = x[W_DRIVE] = p.drive_share * x[W_DRIVE] + (1.0 - p.drive_share) * x[W]
    elif event == CAPPED:
        x[AMPERE] = p.current_limit if x[AMPERE] > 0.0 else -p.current_limit


@njit
def let_go(x, k, drive, p):
    """Opens contacts that have come apart: soft ones that are inside the gap or off the stop, hard ones that would pull.

    True where the rates at the start of the step are therefore no longer those that were found.
    """
    if x[TOUCH] * (x[PSI] - (p.stop_high if x[TOUCH] > 0.0 else p.stop_low)) < -1e-12:
        x[TOUCH] = 0.0
    if x[CONTACT] == 0.0:
        return False
    if p.coupling == 2.0:
        if x[CONTACT] * (x[PSI_DRIVE] - x[PSI]) < 0.5 * p.gap - 1e-12:
            x[CONTACT] = 0.0
        return False
    carried = drive - p.drive_share * inertia(x[W], p) * k[W]
    if carried * x[CONTACT] >= 0.0:
        return False
    x[CONTACT] = 0.0
    return True


@njit
def leans(x, way, p):
    """Whether an axis at rest would move `way` into a hard stop that it touches."""
    return (way > 0.0 and x[PSI] >= p.stop_high) or (way < 0.0 and x[PSI] <= p.stop_low)


@njit
def age(x, h, p):
    """Moves the memories of friction by `h`."""
    if p.dwell != 0.0:
        x[REST] = x[REST] + h if x[W] == 0.0 else 0.0
    if p.memory != 0.0:
        speed = abs(x[OMEGA] if p.kind == 0.0 else x[W])
        steady = speed / (speed + p.memory_speed)
        x[MEMORY] += (steady - x[MEMORY]) * (1.0 - np.exp(-h / p.memory_time))


@njit
def advance(x, v, outer, warm, h, p, k, half):
    """Moves `x` by `h` in midpoint steps, cut where something happens; `k`, `half` are scratch."""
    elastic = p.preslide_form > 0.0
    for part in range(CUTS + 1):
        slide, spin = np.sign(x[W]), np.sign(x[OMEGA])
        drive = rates(x, slide, spin, v, outer, warm, p, k)
        if (x[CONTACT] != 0.0 or x[TOUCH] != 0.0) and let_go(x, k, drive, p):
            rates(x, slide, spin, v, outer, warm, p, k)
        slide = slide if slide != 0.0 else np.sign(k[W])
        spin = spin if spin != 0.0 else np.sign(k[OMEGA])
        held = slide == 0.0 and not elastic
        if p.stop_form == 2.0 and x[W] == 0.0 and leans(x, slide, p):
            slide, held = 0.0, True
        capped = p.foldback == 0.0 and k[AMPERE] * x[AMPERE] > 0.0 and abs(x[AMPERE]) >= p.current_limit > 0.0
        if capped:
            k[AMPERE] = 0.0
        for j in range(MOVED):
            half[j] = x[j] + 0.5 * h * k[j]
        for j in range(MOVED, STATES):
            half[j] = x[j]
        if elastic:
            deflect(x[SHARE : SHARE + ELEMENTS], x[W], 0.5 * h, p, half[SHARE : SHARE + ELEMENTS])
        rates(half, slide, spin, v, outer, warm, p, k)
        if held:
            k[PSI] = k[W] = 0.0
            if not apart(x, p):
                k[PSI_DRIVE] = k[W_DRIVE] = 0.0
        if capped:
            k[AMPERE] = 0.0
        if spin == 0.0:
            k[THETA] = k[OMEGA] = 0.0
        cut, event = next_event(x, k, h, p) if part < CUTS else (1.0, NOTHING)
        if elastic:
            deflect(x[SHARE : SHARE + ELEMENTS], k[PSI], cut * h, p, x[SHARE : SHARE + ELEMENTS])
        for j in range(MOVED):
            x[j] += cut * h * k[j]
        age(x, cut * h, p)
        happen(x, event, p)
        if event == NOTHING:
            return
        h *= 1.0 - cut


@njit
def _run(t_command, u_command, t_sample, x, p, step):
    n = len(t_command)
    v = np.empty(n)
    for k in range(n):
        v[k] = shape(u_command[k], p)
    x[SLEW] = x[LAG_1] = x[LAG_2] = v[0]
    x[LOAD], x[PLAY] = abs(v[0]), v[0]
    out = np.empty((len(t_sample), STATES + 1))
    slope, half = np.zeros(STATES), np.zeros(STATES)
    t, start = t_sample[0], t_sample[0]
    k = 0
    for j in range(len(t_sample)):
        while t < t_sample[j] - 1e-12:
            while k + 1 < n and t_command[k + 1] + p.delay <= t + 1e-12:
                k += 1
            end = t_sample[j]
            if k + 1 < n:
                end = min(end, t_command[k + 1] + p.delay)
            if p.loose > 0.0:
                end = min(end, start + SLOT * (np.floor((t - start) / SLOT + 1e-9) + 1.0))
            h = min(step, end - t)
            middle = t - start + 0.5 * h
            volts = follow(x, v[k], middle, h, p)
            warm = warmth(middle, p) if p.drift != 0.0 or p.drift_viscous != 0.0 else 0.0
            advance(x, volts, push(middle, p), warm, h, p, slope, half)
            t += h
        while k + 1 < n and t_command[k + 1] + p.delay <= t + 1e-12:
            k += 1
        out[j, :STATES] = x
        out[j, STATES] = current(x, follow(x, v[k], t - start, 0.0, p), p)
    return out


def run(t_command, u_command, t_sample, x0, p, step=STEP) -> np.ndarray:
    """Every state, and last the current, at `t_sample`; `x0` is (psi, w, theta, omega, i) at the first of them.

    Commands hold from their `t_command` on. `p` is `Truth.array()`.
    """
    x = np.zeros(STATES)
    x[: len(x0)] = x0
    x[PSI_DRIVE], x[W_DRIVE] = x[PSI], x[W]
    return _run(t_command, u_command, t_sample, x, p, step)


def simulate(t_command, u_command, t_sample, x0, p, step=STEP) -> np.ndarray:
    """(psi, w, theta, omega, i of `x0`, measured current) at `t_sample`, as `run` gives them."""
    out = run(t_command, u_command, t_sample, x0, p, step)
    return np.column_stack([out[:, :5], out[:, -1]])
