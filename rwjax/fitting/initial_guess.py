"""What a log's first 0.5 s say about its initial state, before anything is simulated."""

import numpy as np

from rwjax.kinds import SERVO, is_angle
from rwjax.logs import noise as noise_of
from rwjax.logs.log import Log
from rwjax.logs.noise_level import noise_level
from rwjax.plant.structure import Structure

START_S = 0.5
"""Length of the stretch from which a run's initial state is estimated [s]."""
NO_COMMAND, NO_SHARE = 1e-3, 1e-3
"""Voltage below which there is no command [V]; of a duty, a current, a torque and a servo, the share of its largest one [1]."""
SWING, FAR = 3.0, 6.0
"""Scatter of a rate over the first 0.5 s, in units of its noise, above which it moves: along a smooth curve, and any other [1]."""
CURVE, SMOOTH = 5, 0.4
"""A smooth curve: order of a polynomial, and the share of the scatter that it leaves at most [1]."""
INTEGRAL = f"{SERVO}:integral"
"""State of a servo that the run before its first sample has left behind."""
STANDS = 1.5
"""Range of an angle's readings, in counts, up to which it stands still [1]."""
MOVES = 3.5
"""Standard errors of a mean or a slope above which it differs from zero [1]."""


def first_half_second(log: Log) -> np.ndarray:
    """Which samples `(time,)` lie in the first `START_S` of a log.

    Args:
        log: The log.

    Returns:
        True for these samples `(time,)` [true or false].
    """
    return log.time - log.time[0] <= START_S


def _correlation_time(left: np.ndarray) -> float:
    r"""Samples that count as one, at least 1, of what a line through a short stretch leaves [1].

    It is $(1 + \rho)/(1 - \rho)$ of noise that is an autoregression of first order. The first autocorrelation $r$ of $n$ samples is too small by
    $(2 + 4\rho)/n$ in the mean (Marriott and Pope, Biometrika 41 (1954)).
    """
    n, square = len(left), float(left @ left)
    r = float(left[1:] @ left[:-1]) / square if square > 0.0 else 0.0
    rho = min(max((r + 2.0 / n) / (1.0 - 4.0 / n), 0.0), 1.0 - 2.0 / n) if n > 4 else 0.0
    return (1.0 + rho) / (1.0 - rho)


def _line(log: Log, name: str) -> tuple[float, float, float]:
    """Value at the first sample, slope, and the slope's standard error of a line through the first 0.5 s."""
    early = first_half_second(log) & np.isfinite(log.outputs[name])
    t, y = log.time[early] - log.time[0], log.outputs[name][early]
    if len(t) < 3:
        return (float(y[0]) if len(y) else 0.0), 0.0, np.inf
    A = np.stack([np.ones_like(t), t], axis=1)
    (value, slope), *_ = np.linalg.lstsq(A, y, rcond=None)
    left = y - A @ (value, slope)
    scatter = max(np.std(left), noise_of.quantisation(log, name)) * np.sqrt(_correlation_time(left))
    return float(value), float(slope), float(scatter / np.sqrt(np.sum((t - t.mean()) ** 2)))


def starts_at_rest(log: Log) -> bool:
    """Whether input and rates cannot be distinguished from zero over the first 0.5 s.

    The command at the last of these samples acts after it, and is not considered. Nor is a current, which may have an offset, or a rate that
    the same body's angle contradicts by standing still: a gyroscope has an offset and noise that wanders.

    Args:
        log: The log.

    Returns:
        True where the run starts at rest.
    """
    early = first_half_second(log)
    given = np.abs(log.at_drive)
    acting = given[early][:-1] if early.sum() > 2 else given[early]
    if np.max(acting) > (NO_COMMAND if log.input == "voltage_V" else NO_SHARE * np.max(given)):
        return False
    for name, value in log.outputs.items():
        if name.startswith("current"):
            continue
        y = value[early & np.isfinite(value)]
        if len(y) < 3:
            continue
        if is_angle(name):
            _, slope, error = _line(log, name)
            moved = float(np.ptp(y)) > STANDS * log.resolution.get(name, 0.0)
            if moved and abs(slope) > MOVES * error:
                return False
        elif _moves(y, noise_of.quantisation(log, name)) and not _contradicted(log, name, y):
            return False
    return True


def _moves(rate: np.ndarray, quantisation: float) -> bool:
    """Whether a rate [rad/s] over the first 0.5 s differs from zero, beside noise that may wander.

    It does where its mean does, or where it swings through zero and back: far beyond its noise, or along a smooth curve.
    """
    noise, at = max(noise_level(rate), quantisation), np.linspace(-1.0, 1.0, len(rate))

    def left(order: int) -> np.ndarray:
        order = min(order, len(rate) - 1)
        return rate - np.polynomial.legendre.legval(at, np.polynomial.legendre.legfit(at, rate, order))

    error = max(float(np.std(left(1))), noise) * np.sqrt(_correlation_time(left(1)) / len(rate))
    if abs(float(np.mean(rate))) > MOVES * error + 1e-12:
        return True
    swing = float(np.std(rate))
    smooth = float(np.std(left(CURVE))) < SMOOTH * swing
    return noise > 0.0 and swing > (SWING if smooth else FAR) * noise


def _contradicted(log: Log, name: str, rate: np.ndarray) -> bool:
    """Whether the angle of a body stands still over the first 0.5 s, though it would turn visibly at the rate that is read.

    Args:
        log: The log.
        name: Name of the rate.
        rate: Its readings over the first 0.5 s [rad/s].

    Returns:
        True where the angle is logged and says so.
    """
    angle = name.removesuffix("_s")
    if angle not in log.outputs:
        return False
    early = first_half_second(log) & np.isfinite(log.outputs[angle])
    t, y = log.time[early], log.outputs[angle][early]
    if len(t) < 3:
        return False
    count, span = STANDS * log.resolution.get(angle, 0.0), float(t[-1] - t[0])
    _, slope, error = _line(log, angle)
    seen = max(MOVES * error, count / span)  # the slowest rate that the angle shows
    if float(np.ptp(y)) > count and abs(slope) > seen:
        return False
    swing = float(np.std(rate)) / (2.0 * np.pi)  # one period fits into the 0.5 s
    return max(abs(float(np.mean(rate))), swing) > seen


def _signed(structure: Structure, log: Log, name: str) -> float:
    """A reading at the first sample, one without its sign with that of the first 0.5 s of the command."""
    value = _line(log, name)[0]
    if name not in structure.unsigned:
        return value
    driven = float(np.mean(log.at_drive[first_half_second(log)]))
    return -abs(value) if driven < 0.0 else abs(value)


def guess_initial_state(structure: Structure, log: Log, rest: bool) -> tuple[np.ndarray, np.ndarray]:
    """Initial state as the first readings suggest it, and which of its entries are unknown.

    Args:
        structure: The plant's structure, with its states `n`.
        log: The log.
        rest: Whether the run starts at rest: rates and currents are then known to be 0.

    Returns:
        The guess `(n,)` [rad, rad/s, A], and True where an entry has to be estimated `(n,)`.
    """
    guess, free = dict.fromkeys(structure.states, 0.0), dict.fromkeys(structure.states, False)
    for angle, rate, angle_name, rate_name in structure.turning:
        early = first_half_second(log)
        if angle_name in log.outputs:
            value, slope, _ = _line(log, angle_name)
            seen = log.outputs[angle_name][early & np.isfinite(log.outputs[angle_name])]
            guess[angle], guess[rate] = (float(np.mean(seen)) if rest and len(seen) else value), slope
            free[angle] = True
        elif log.outputs and angle in structure.angles:
            free[angle] = True  # unseen, but something depends on it
        if rate_name in log.outputs and not (rate_name in structure.unsigned and angle_name in log.outputs):
            guess[rate] = _signed(structure, log, rate_name)
        free[rate] = not rest
        guess[rate] = 0.0 if rest else guess[rate]
    for i, name in structure.currents:
        if not rest:
            guess[i] = _signed(structure, log, name) if name in log.outputs else 0.0
            free[i] = True
    if INTEGRAL in free:
        free[INTEGRAL] = True  # a servo that has integrated its error away holds a load all the same
    if log.goes_on and not rest:  # the effects' own states were 0 when the run began
        free |= {name: True for name in structure.states if ":" in name and not name.startswith(f"{SERVO}:")}
    return np.array(list(guess.values())), np.array(list(free.values()))
