"""What a log's first 0.5 s say about its initial state, before anything is simulated."""

from functools import cache

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
SWING = 3.0
"""Scatter over the first 0.5 s, in units of what the noise has, above which a reading moves [1]."""
CURVE, SMOOTH = 5, 0.4
"""Order of the polynomial that stands for a smooth motion; the share of the scatter that a swing of one frequency leaves at most [1]."""
PERIODS = (1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0)
"""Periods of a swing within the 0.5 s that are tried [1]."""
FEW, MOST = 20, 200
"""Readings below which noise is taken to be white, since fewer do not tell; and most of them that are asked [1]."""
INDEPENDENT = 3.0
"""Independent readings that a stretch is taken to have at least: less cannot be told from a motion [1]."""
CORRELATIONS = np.array([0.0, 0.2, 0.4, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99])
"""Correlations of noise from reading to reading that are told apart [1]."""
INTEGRAL = f"{SERVO}:integral"
"""State of a servo that the run before its first sample has left behind."""
STANDS = 1.5
"""Range of an angle's readings, in counts, up to which it stands still [1]."""
WITHIN = 8.0
"""Range within which an angle that is not counted stands still, in units of its noise [1]."""
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


@cache
def _smooth(n: int) -> tuple[np.ndarray, np.ndarray]:
    r"""A basis `(n, k)` of smooth curves over `n` readings, and the first autocorrelation of what they leave of noise with `CORRELATIONS`.

    The noise is an autoregression of first order, with covariance $C_{ij} = \rho^{|i-j|}$. Curves leave $M C M$ of it, of which the expected
    autocorrelation is the first off-diagonal's sum over that of the diagonal: less than $\rho$, since a curve follows slow noise.
    """
    Q = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, n), CURVE))[0]
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    left = np.eye(n) - Q @ Q.T
    covariances = (left @ rho**apart @ left for rho in CORRELATIONS)
    return Q, np.array([np.trace(C, offset=1) / np.trace(C) for C in covariances])


def _correlation(y: np.ndarray) -> float:
    """Correlation of a stretch's noise from reading to reading, by what a smooth curve leaves of it [1]; 0 for few readings."""
    if len(y) < FEW:
        return 0.0
    every = -(-len(y) // MOST)
    y = y[::every]
    Q, expected = _smooth(len(y))
    left = y - Q @ (Q.T @ y)
    square = float(left @ left)
    found = float(left[1:] @ left[:-1]) / square if square > 0.0 else 0.0
    most = len(y) / INDEPENDENT
    rho = min(float(np.interp(found, expected, CORRELATIONS)), (most - 1.0) / (most + 1.0))
    return rho ** (1.0 / every)


def _readings_that_count_as_one(y: np.ndarray) -> float:
    """How many readings of a stretch count as one independent reading [1]."""
    rho = _correlation(y)
    return (1.0 + rho) / (1.0 - rho)


def _line(log: Log, name: str) -> tuple[float, float, float]:
    """Value at the first sample, slope, and the slope's standard error of a line through the first 0.5 s."""
    early = first_half_second(log) & np.isfinite(log.outputs[name])
    t, y = log.time[early] - log.time[0], log.outputs[name][early]
    if len(t) < 3:
        return (float(y[0]) if len(y) else 0.0), 0.0, np.inf
    A = np.stack([np.ones_like(t), t], axis=1)
    (value, slope), *_ = np.linalg.lstsq(A, y, rcond=None)
    scatter = max(np.std(y - A @ (value, slope)), noise_of.quantisation(log, name))
    scatter *= np.sqrt(_readings_that_count_as_one(y))
    return float(value), float(slope), float(scatter / np.sqrt(np.sum((t - t.mean()) ** 2)))


def starts_at_rest(log: Log) -> bool:
    """Whether input and rates cannot be distinguished from zero over the first 0.5 s.

    The command at the last of these samples acts after it, and is not considered. Nor is a current, which may have an offset, or a rate that
    the same body's angle contradicts by standing still: a gyroscope has an offset and coloured noise.

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
            moves = _turns(log, name)
        else:
            moves = _rate_moves(y, noise_of.quantisation(log, name)) and not _contradicted(log, name, y)
        if moves:
            return False
    return True


def _early(log: Log, name: str) -> np.ndarray:
    """Readings of an output over the first 0.5 s [rad, rad/s or A]."""
    return log.outputs[name][first_half_second(log) & np.isfinite(log.outputs[name])]


def _turns(log: Log, name: str) -> bool:
    """Whether an angle moves over the first 0.5 s: along a line, or to and fro."""
    y = _early(log, name)
    if float(np.ptp(y)) <= STANDS * log.resolution.get(name, 0.0):
        return False
    _, slope, error = _line(log, name)
    return abs(slope) > MOVES * error or _swings(y, noise_of.quantisation(log, name))


def _rate_moves(y: np.ndarray, quantisation: float) -> bool:
    """Whether a rate [rad/s] over the first 0.5 s differs from zero: in the mean, or to and fro."""
    error = max(float(np.std(y)), noise_level(y), quantisation) * np.sqrt(_readings_that_count_as_one(y) / len(y))
    return bool(abs(np.mean(y)) > MOVES * error + 1e-12) or _swings(y, quantisation)


def _swings(y: np.ndarray, quantisation: float) -> bool:
    """Whether a reading scatters more than its noise, which may be coloured, or with one frequency."""
    noise, scatter = max(noise_level(y), quantisation), float(np.std(y))
    if noise == 0.0 or scatter <= SWING * noise:
        return False
    return bool(scatter * np.sqrt(1.0 - _correlation(y)) > SWING * noise) or _swings_evenly(y, scatter)


def _swings_evenly(y: np.ndarray, scatter: float) -> bool:
    """Whether a line and one frequency leave little of a reading's scatter."""
    at, left = np.linspace(-1.0, 1.0, len(y)), scatter
    for periods in PERIODS if len(y) >= FEW else ():
        A = np.stack([np.ones_like(at), at, *(f(np.pi * periods * at) for f in (np.cos, np.sin))], axis=1)
        left = min(left, float(np.std(y - A @ np.linalg.lstsq(A, y, rcond=None)[0])))
    return left < SMOOTH * scatter


def _contradicted(log: Log, name: str, rate: np.ndarray) -> bool:
    """Whether a body's angle stands still over the first 0.5 s, and turns later, though it would show the rate [rad/s] that is read."""
    angle = name.removesuffix("_s")
    if angle not in log.outputs or len(_early(log, angle)) < 3:
        return False
    y = _early(log, angle)
    still = max(STANDS * log.resolution.get(angle, 0.0), WITHIN * noise_level(y))
    if float(np.ptp(y)) > still or float(np.nanmax(log.outputs[angle]) - np.nanmin(log.outputs[angle])) <= still:
        return False
    swing = float(np.std(rate)) / (2.0 * np.pi)  # of up to some 5 Hz
    return max(abs(float(np.mean(rate))), swing) > still / START_S


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
