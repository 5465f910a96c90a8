"""Truth of joints: geared motor, link, gravity and a servo's loop, with exact stick and slip; shares no code with `rwjax`.

Between two moments at which something is given (a sample of the log, a tick of the loop, an output that arrives late) the
inputs are constant. There the motion is integrated by the pairs of Dormand and Prince with steps chosen for an error of
1e-10. Where a speed reaches 0, a held link lets go or a gap opens or closes, the step is cut at that moment, found by
bisection of the step itself. `drive_share` of the link's inertia, and the rotor's, move before an elastic coupling or a gap.
"""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numba import njit

PSI, W, PSI_DRIVE, W_DRIVE, AMPERE, WORK, LOSS = range(7)
MOVED, STATES = 5, 7  # the last two only count: energy that came in, and what became heat [J]
VOLTAGE, DUTY, CURRENT, TORQUE = range(4)  # what the drive is given
RIGID, ELASTIC, GAP = range(3)
NOT_LOGGED = 1e30  # s, later than any run ends


@dataclass(frozen=True)
class Joint:
    """Numbers of a joint in SI."""

    given: int = VOLTAGE
    ratio: float = 1.0
    K: float = 0.02
    R: float = 2.0
    L: float = 0.0
    rotor: float = 0.0
    I: float = 0.02
    viscous: float = 0.0
    coulomb: float = 0.0
    excess: float = 0.0  # breakaway above sliding friction
    v_s: float = 0.1
    gravity: float = 0.0
    gravity_angle: float = 0.0
    coupling: int = RIGID
    drive_share: float = 0.3
    stiffness: float = 100.0
    damping: float = 0.0
    gap: float = 0.0  # rad, whole play
    scale: float = 0.0  # logarithm of what the encoder's readings are too large by
    delay: float = 0.0  # s, of what the drive is given
    goal_delay: float = 0.0
    sensor_delay: float = (
        0.0  # s, by which the loop reads late; a log's readings are late where they are asked for late
    )

    def array(self) -> np.void:
        """The numbers as a record, whose fields compiled code reads by name."""
        return _record(self)


@dataclass(frozen=True)
class Servo:
    """A position loop, which acts once a period; `limit` and `error_limit` are far away where there is none."""

    kp: float = 0.0
    ki: float = 0.0
    kd: float = 0.0
    on_speed: float = 0.0  # 1: the damping acts on the speed alone, 0: on the slope of the error
    filter: float = 0.0  # s, of the slope
    error_limit: float = 1e9
    limit: float = 1e9
    period: float = 0.01
    phase: float = 0.0
    motor_side: float = 0.0  # 1: the loop's encoder is before the coupling or the gap

    def array(self) -> np.void:
        """The numbers as a record, whose fields compiled code reads by name."""
        return _record(self)


def _record(numbers: Joint | Servo) -> np.void:
    names = [f.name for f in fields(numbers)]
    values = tuple(float(getattr(numbers, name)) for name in names)
    return np.array([values], np.dtype([(name, np.float64) for name in names]))[0]


class Inputs(NamedTuple):
    """What a run is given, held from each time on: command or goal, supply [V] (1 where the command is no duty), torque on."""

    time: np.ndarray
    command: np.ndarray
    supply: np.ndarray
    enabled: np.ndarray


@njit
def level(w, p):
    """Dry friction of the link."""
    return p.coulomb + (p.excess * np.exp(-((w / p.v_s) ** 2)) if p.excess != 0.0 else 0.0)


@njit
def motor_current(x, on, u, p):
    """Current: none where the circuit is open, a state, or what the command drives at once."""
    if not on or p.given == TORQUE:
        return 0.0
    if p.given == CURRENT:
        return u
    return x[AMPERE] if p.L > 0.0 else (u - p.K * p.ratio * x[W_DRIVE]) / p.R


@njit
def pressing(x, p):
    """Side on which a gap's contact presses: 1, -1, or 0 where the parts do not push each other."""
    twist, slip = x[PSI_DRIVE] - x[PSI], x[W_DRIVE] - x[W]
    over = abs(twist) - 0.5 * p.gap
    side = 1.0 if twist > 0.0 else -1.0
    return side if over > 0.0 and p.stiffness * over + p.damping * side * slip > 0.0 else 0.0


@njit
def carried_torque(x, side, p):
    """Torque that the coupling, or the gap's contact on a `side`, carries to the link."""
    twist, slip = x[PSI_DRIVE] - x[PSI], x[W_DRIVE] - x[W]
    if p.coupling == GAP:
        return p.stiffness * (twist - 0.5 * side * p.gap) + p.damping * slip if side != 0.0 else 0.0
    return p.stiffness * twist + p.damping * slip


@njit
def load(x, on, u, side, p):
    """Torque that moves the link, without friction: of motor or coupling, and gravity."""
    if p.coupling == RIGID:
        drive = u * on if p.given == TORQUE else p.ratio * p.K * motor_current(x, on, u, p)
    else:
        drive = carried_torque(x, side, p)
    return drive - p.gravity * np.sin(x[PSI] + p.gravity_angle)


@njit
def rates(x, slide, side, on, u, p, out):
    """Rates of every state; the link slides towards `slide`, or is held where that is 0."""
    w, i = x[W], motor_current(x, on, u, p)
    drive = u * on if p.given == TORQUE else p.ratio * p.K * i
    rotor = p.ratio**2 * p.rotor
    if slide == 0.0:
        out[PSI] = out[W] = 0.0
    else:
        dry = slide * level(w, p)
        inertia = p.I + rotor if p.coupling == RIGID else p.I * (1.0 - p.drive_share)
        out[PSI], out[W] = w, (load(x, on, u, side, p) - p.viscous * w - dry) / inertia
    slip = 0.0
    if p.coupling == RIGID:
        out[PSI_DRIVE], out[W_DRIVE] = out[PSI], out[W]
    else:
        slip = x[W_DRIVE] - w
        if p.coupling == GAP and side == 0.0:
            slip = 0.0
        out[PSI_DRIVE] = x[W_DRIVE]
        out[W_DRIVE] = (drive - carried_torque(x, side, p)) / (p.drive_share * p.I + rotor)
    state = p.L > 0.0 and p.given <= DUTY and on
    out[AMPERE] = (u - p.R * i - p.K * p.ratio * x[W_DRIVE]) / p.L if state else 0.0
    out[WORK] = u * i if p.given <= DUTY else drive * x[W_DRIVE]
    out[LOSS] = p.viscous * w * w + abs(w) * level(w, p) + p.damping * slip * slip
    if p.given <= DUTY:
        out[LOSS] += p.R * i * i


NODES = np.array(
    [
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
WRONG = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
TOLERANCE = 1e-10
SMALL = np.array([1e-3, 1e-2, 1e-3, 1e-2, 1e-2])  # of each state, below which the error is measured by these
LONGEST = 2e-3  # s, a step: a speed does not cross 0 twice within it


@njit
def step(x, slide, side, on, u, h, p, k, new):
    """Moves `x` by `h` into `new` and returns the error in tolerances; `k` is scratch."""
    rates(x, slide, side, on, u, p, k[0])
    for s in range(6):
        for j in range(STATES):
            total = 0.0
            for r in range(s + 1):
                total += NODES[s, r] * k[r, j]
            new[j] = x[j] + h * total
        rates(new, slide, side, on, u, p, k[s + 1])
    worst = 0.0
    for j in range(MOVED):
        wrong = 0.0
        for s in range(7):
            wrong += WRONG[s] * k[s, j]
        worst = max(worst, abs(h * wrong) / (TOLERANCE * max(abs(x[j]), SMALL[j])))
    return worst


@njit
def broken(x, slide, side, on, u, p):
    """Whether what a step took for granted holds no longer: direction, rest, contact."""
    if slide != 0.0:
        if slide * x[W] < 0.0:
            return True
    elif abs(load(x, on, u, side, p)) > level(0.0, p):
        return True
    return p.coupling == GAP and pressing(x, p) != side


@njit
def direction(x, on, u, side, p):
    """Where the link goes: on, or from rest where the load takes it."""
    if x[W] != 0.0:
        return np.sign(x[W])
    push = load(x, on, u, side, p)
    return np.sign(push) if abs(push) > level(0.0, p) else 0.0


@njit
def advance(x, on, u, length, h, p, k, new):
    """Moves `x` by `length` under constant inputs and returns the step that would come next."""
    at, stalled = 0.0, 0
    side = pressing(x, p) if p.coupling == GAP else 0.0
    slide = direction(x, on, u, side, p)
    while at < length:
        h = min(h, LONGEST)
        last = h >= length - at
        part = length - at if last else h
        error = step(x, slide, side, on, u, part, p, k, new)
        factor = min(max(0.9 * max(error, 1e-10) ** -0.2, 0.2), 5.0)
        if error > 1.0:
            h = part * factor
            continue
        if not broken(new, slide, side, on, u, p) or stalled > 20:
            x[:] = new
            at, stalled = (length if last else at + part), 0
            h = max(h, part * factor) if last else part * factor
            continue
        low, high = 0.0, part
        while high - low > 1e-14:
            middle = 0.5 * (low + high)
            step(x, slide, side, on, u, middle, p, k, new)
            if broken(new, slide, side, on, u, p):
                high = middle
            else:
                low = middle
        step(x, slide, side, on, u, high, p, k, new)
        if slide != 0.0 and slide * new[W] < 0.0:
            new[W] = 0.0
            if p.coupling == RIGID:
                new[W_DRIVE] = 0.0
        x[:] = new
        at, stalled = at + high, (stalled + 1 if high < 1e-12 else 0)
        side = pressing(x, p) if p.coupling == GAP else 0.0
        push = load(x, on, u, side, p)
        loose = slide == 0.0 and abs(push) > level(0.0, p)
        slide = np.sign(push) if loose else direction(x, on, u, side, p)
    return h


@njit
def held(time, values, t):
    """Value that is held at `t`; before the first time, the first."""
    k = np.searchsorted(time, t + 1e-12, side="right") - 1
    return values[max(k, 0)]


@njit
def area(time, values, integral, t):
    """Integral of held values up to `t`; `integral` holds it at every one of `time`."""
    k = max(np.searchsorted(time, t, side="right") - 1, 0)
    return integral[k] + values[k] * (t - time[k])


@njit
def read(x, s, p, seen):
    """Angle and rate that the loop's encoder shows."""
    seen[0] = np.exp(p.scale) * (x[PSI_DRIVE] if s.motor_side != 0.0 else x[PSI])
    seen[1] = np.exp(p.scale) * (x[W_DRIVE] if s.motor_side != 0.0 else x[W])


@njit
def tick(seen, goal, memory, on, first, s, p):
    """One tick of the loop: the output that it asks for. `memory`: integral, slope, and what the slope was taken of."""
    measured, speed = seen
    e = min(max(goal - measured, -s.error_limit), s.error_limit)
    d = -measured if s.on_speed != 0.0 else e
    memory[1] = -speed if first else (s.filter * memory[1] + d - memory[2]) / (s.filter + s.period)
    memory[2] = d
    if not on:
        memory[0] = 0.0
        return 0.0
    limit = min(s.limit, 1.0) if p.given == DUTY else s.limit
    asked = s.kp * e + s.ki * memory[0] + s.kd * memory[1]
    out = min(max(asked, -limit), limit)
    if out == asked or asked * e <= 0.0:
        memory[0] += s.period * e
    return out


@njit
def _run(time, command, supply, enabled, at, begin, start, looped, s, p):
    n = len(time)
    integral = np.zeros(n)
    for j in range(1, n):
        integral[j] = integral[j - 1] + command[j - 1] * (time[j] - time[j - 1])
    out = np.empty((len(at), STATES + 1))
    outputs = np.empty((len(at), 2))
    k, new, x = np.zeros((7, STATES)), np.zeros(STATES), start.copy()
    memory = np.zeros(3)
    waiting, given = np.zeros((2, 4096)), 0.0  # outputs on their way: when, how much
    sent, come, ticks = 0, 0, np.ceil((begin + p.sensor_delay - s.phase) / s.period - 1e-9)
    seen, reads = np.zeros((4096, 2)), ticks  # by number of the tick
    t, h, j, sample, first = begin, 1e-4, 0, 0, True
    on, raw = enabled[0] != 0.0, command[0]
    while True:
        while sample < n and time[sample] <= t + 1e-12:
            on, sample = enabled[sample] != 0.0, sample + 1
            if not on:
                x[AMPERE], memory[0], given, come = 0.0, 0.0, 0.0, sent
        if looped and s.phase + reads * s.period - p.sensor_delay <= t + 1e-12:
            read(x, s, p, seen[int(reads) % 4096])
            reads += 1.0
        if looped and s.phase + ticks * s.period <= t + 1e-12:
            due = s.phase + ticks * s.period
            goal = area(time, command, integral, due + s.period - p.goal_delay)
            goal = (goal - area(time, command, integral, due - p.goal_delay)) / s.period
            raw = tick(seen[int(ticks) % 4096], goal, memory, on, first, s, p)
            given = raw if first else given
            waiting[0, sent % 4096], waiting[1, sent % 4096] = due + p.delay, raw
            sent, ticks, first = sent + 1, ticks + 1.0, False
        while looped and come < sent and waiting[0, come % 4096] <= t + 1e-12:
            given, come = waiting[1, come % 4096], come + 1
        if not looped:
            given = held(time, command, t - p.delay)
        u = given * held(time, supply, t) if p.given == DUTY else given
        while j < len(at) and at[j] <= t + 1e-12:
            out[j, :STATES], out[j, STATES] = x, motor_current(x, on, u, p)
            outputs[j, 0], outputs[j, 1] = given if on else 0.0, memory[0]
            j += 1
        if j == len(at):
            return out, outputs
        end = at[j]
        if sample < n:
            end = min(end, time[sample])
        if looped:
            end = min(end, s.phase + ticks * s.period, s.phase + reads * s.period - p.sensor_delay)
            if come < sent:
                end = min(end, waiting[0, come % 4096])
        elif p.delay > 0.0:
            late = np.searchsorted(time, t - p.delay + 1e-12, side="right")
            end = min(end, time[late] + p.delay) if late < n else end
        h = advance(x, on, u, end - t, h, p, k, new)
        t = end


def move(joint: Joint, servo: Servo | None, inputs: Inputs, at, start=(0.0, 0.0), begin: float | None = None):
    """States at times `at`, the current as the last column, and beside them the loop's (output, integral of the error).

    `start`: angle and rate at `begin`, which is the first of the inputs' times where it is not given; before that one the
    first inputs hold.
    """
    x = np.zeros(STATES)
    x[[PSI, PSI_DRIVE]], x[[W, W_DRIVE]] = start
    begin = float(inputs.time[0]) if begin is None else begin
    arrays = (np.ascontiguousarray(a, float) for a in inputs)
    loop = servo or Servo(phase=NOT_LOGGED)
    return _run(*arrays, np.asarray(at, float), begin, x, servo is not None, loop.array(), joint.array())


def energy(joint: Joint, states: np.ndarray) -> np.ndarray:
    """Energy that a joint holds: of motion, of height, of the winding's field, of a twisted coupling [J]."""
    rotor = joint.ratio**2 * joint.rotor
    share = 0.0 if joint.coupling == RIGID else joint.drive_share
    twist = states[:, PSI_DRIVE] - states[:, PSI]
    twist = twist if joint.coupling != GAP else twist - np.clip(twist, -0.5 * joint.gap, 0.5 * joint.gap)
    return (
        0.5 * joint.I * (1.0 - share) * states[:, W] ** 2
        + 0.5 * (joint.I * share + rotor) * states[:, W_DRIVE] ** 2
        + 0.5 * joint.L * states[:, AMPERE] ** 2
        - joint.gravity * np.cos(states[:, PSI] + joint.gravity_angle)
        + (0.5 * joint.stiffness * twist**2 if joint.coupling != RIGID else 0.0)
    )
