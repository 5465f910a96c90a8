"""How large and how fast each run of a campaign may be, by simulation of the rig.

The rig file may be wrong, hence the runs stay below the rig's limits.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from rwjax.planning.designs import LONGEST_S, Design
from rwjax.planning.envelope import Envelope
from rwjax.planning.motion import WAIT_S, coasting_angle, peaks, simulated_motion
from rwjax.rig.model import Rig

KEPT = 0.9
"""Share of a limit that the simulated rig may reach: the true one differs."""
MARGIN = 1.5
"""Amplitude over the least one that moves the simulated rig both ways: the true one may stick harder."""
RESOLVED = 20.0
"""Counts of the encoder below which nothing counts as moving."""
BOTH_WAYS = 0.05
"""Share of its largest rate that a rig has to reach in the other direction to count as reversing."""
LEVELS = 8
"""Amplitudes tried side by side, from the largest down to `SMALLEST` of it; then once more between the best two."""
SMALLEST = 0.02
"""Smallest amplitude that is tried, over the largest."""
NEAR = np.append(0.0, np.linspace(0.7, 1.06, LEVELS - 1))
"""Where the largest amplitude is looked for, between an allowed one (0) and that at which a line meets the limits (1)."""
PACES = (1.0, 0.4, 0.15)
"""Factors on a design's period and length: a rig with little travel or a wheel in between moves more under faster commands."""
LARGE = 0.5
"""Share of the amplitude which another pace allows that a slower one has to allow to be preferred, where travel is limited."""
COASTING = 0.05
"""Share of the travel that a rig may still have to go a minute after a run; the rest of it is what its file may be wrong by."""


class SizedDesign(NamedTuple):
    """A design as large and as fast as the limits allow.

    Attributes:
        design: The design.
        amplitude: Amplitude [V].
        pace: Factor on its period and length [1].
    """

    design: Design
    amplitude: float
    pace: float


class Trial(NamedTuple):
    """Simulated runs of d designs at a amplitudes each.

    Attributes:
        used: Largest share of a limit that each uses [1], `(d, a)`; infinite where the rig does not come to rest.
        allowed: How many amplitudes of each design, counted from the least, stay within the limits, `(d,)`.
        moving: Which of them move the rig, `(d, a)`.
        peaks: Peaks of every output [SI] by name, `(d, a)` each.
    """

    used: Float[np.ndarray, "d a"]
    allowed: Int[np.ndarray, " d"]
    moving: Bool[np.ndarray, "d a"]
    peaks: dict[str, Float[np.ndarray, "d a"]]


def size_designs(rig: Rig, within: Envelope, designs: dict[str, Design]) -> dict[str, SizedDesign]:
    """Amplitude and pace of every design that moves the rig within its limits.

    Args:
        rig: The rig.
        within: Its limits.
        designs: Designs by name.

    Returns:
        Sized designs by name, in the same order; those that do not move the rig are left out.
    """
    amplitude, paces = _amplitudes(rig, within, designs)
    every = zip(designs.items(), amplitude.tolist(), paces, strict=True)
    return {name: SizedDesign(design, volts, pace) for (name, design), volts, pace in every if volts > 0.0}


class _AtPaces(NamedTuple):
    """Amplitudes [V] of d designs at p paces `(p, d)`, 0 where nothing moves the rig within the limits.

    The `largest` that is allowed, that at which the limits are `used_up` by a line, and the `least` that moves the rig.
    """

    largest: Float[np.ndarray, "p d"]
    used_up: Float[np.ndarray, "p d"]
    least: Float[np.ndarray, "p d"]


def _amplitudes(rig: Rig, within: Envelope, among: dict[str, Design]) -> tuple[Float[np.ndarray, " d"], list[float]]:
    """Amplitude [V] and pace of every design; an amplitude of 0 where the limits leave nothing that moves the rig."""
    designs = list(among.values())
    found = _at_paces(rig, within, among)
    large = found.largest >= LARGE * found.largest.max(axis=0) if within.limits_travel else found.largest > 0.0
    pace = np.argmax((found.largest > 0.0) & large, axis=0)  # the slowest of them
    paces = [PACES[k] for k in pace]
    largest, used_up, least = (x[pace, np.arange(len(designs))] for x in found)
    finer = largest[:, None] + (used_up - largest)[:, None] * NEAR
    allowed = try_designs(rig, within, among, finer, paces).allowed
    largest = finer[np.arange(len(designs)), np.maximum(allowed - 1, 0)]
    share = np.array([design.share for design in designs])
    return np.minimum(np.maximum(share * largest, MARGIN * least), largest), paces


def _at_paces(rig: Rig, within: Envelope, among: dict[str, Design]) -> _AtPaces:
    """Amplitudes of all designs at every pace that is wanted, to the grid of `LEVELS`."""
    top = np.array([within.volts / (1.0 + design.offset) for design in among.values()])
    levels = top[:, None] * np.geomspace(SMALLEST, 1.0, LEVELS)
    largest, used_up, least = np.zeros((3, len(PACES), len(among)))
    for k, pace in enumerate(PACES):
        tried = try_designs(rig, within, among, levels, [pace] * len(among))
        for d, last in enumerate(tried.allowed.tolist()):
            still = np.flatnonzero(~tried.moving[d, :last])
            first = still[-1] + 1 if len(still) else 0  # the least level from which on it moves
            if first < last:
                largest[k, d], least[k, d] = levels[d, last - 1], levels[d, first]
                used_up[k, d] = _where_used_up(levels[d], tried.used[d], last)
        if not within.limits_travel and largest[k].all():
            break  # nothing asks for faster commands
    return _AtPaces(largest, used_up, least)


def _where_used_up(levels: Float[np.ndarray, " a"], used: Float[np.ndarray, " a"], allowed: int) -> float:
    """Amplitude at which the limits are used up to `KEPT`, by a line between the last allowed level and the next."""
    if allowed == len(levels):
        return float(levels[-1])
    (low, high), (before, after) = levels[allowed - 1 : allowed + 1], used[allowed - 1 : allowed + 1]
    return float(low + (high - low) * (KEPT - before) / (after - before)) if np.isfinite(after) else float(low)


def try_designs(
    rig: Rig, within: Envelope, designs: dict[str, Design], levels: Float[np.ndarray, "d a"], paces: Sequence[float]
) -> Trial:
    """Simulates all designs at several amplitudes each, every run from angle 0.

    Args:
        rig: The rig.
        within: Its limits.
        designs: d designs by name.
        levels: Amplitudes of each design [V], rising, `(d, a)`.
        paces: Factor on period and length of each design [1].

    Returns:
        How far the limits are used, and which runs move the rig.
    """
    runs = [
        d.at(a, pace, column=within.input)
        for d, row, pace in zip(designs.values(), levels, paces, strict=True)
        for a in row
    ]
    moved = simulated_motion(rig, runs, LONGEST_S + (WAIT_S if within.limits_travel else 0.0))
    found = peaks(moved)
    used = within.largest_share(found)
    if within.limits_travel:
        used[coasting_angle(moved["yaw_rad_s"]) > COASTING * within.limits["yaw_rad"]] = np.inf
    both = np.repeat([design.reverses for design in designs.values()], levels.shape[1])
    used = used.reshape(levels.shape)
    allowed = np.cumprod(used <= KEPT, axis=1).sum(axis=1)
    peak = {name: values.reshape(levels.shape) for name, values in found.items()}
    return Trial(used, allowed, moves(rig, moved, both).reshape(levels.shape), peak)


def moves(rig: Rig, moved: dict[str, np.ndarray], both_ways: Bool[np.ndarray, " e"]) -> Bool[np.ndarray, " e"]:
    """Whether simulated runs move the axis, or the wheel where there is none, so that its encoder shows it.

    Args:
        rig: The rig.
        moved: Outputs [SI] by name, `(e, t)` each.
        both_ways: Whether each run has to move it in both directions, `(e,)`.

    Returns:
        Whether each run does, `(e,)`.
    """
    body, angle, rate = (
        ("wheel", "wheel_rad", "wheel_rad_s") if rig.kind == "wheel" else ("axis", "yaw_rad", "yaw_rad_s")
    )
    counts = rig.counts_per_rev.get(body)
    resolved = RESOLVED * 2.0 * np.pi / counts if counts else 0.0
    forth, back = moved[rate].max(axis=1), -moved[rate].min(axis=1)
    turned = np.minimum(forth, back) > BOTH_WAYS * np.maximum(forth, back)
    return (np.ptp(moved[angle], axis=1) > resolved) & (turned | ~both_ways)


def rounded_levels(amplitude: Float[np.ndarray, " d"], least: float) -> Float[np.ndarray, "d a"]:
    """Amplitudes of three digits from a share of the given ones up to them.

    Args:
        amplitude: Amplitudes [V], `(d,)`.
        least: The share from which on [1].

    Returns:
        `LEVELS` amplitudes for each [V], rounded down, `(d, a)`.
    """
    return np.vectorize(_rounded_down)(amplitude[:, None] * np.linspace(least, 1.0, LEVELS))


def _rounded_down(value: float) -> float:
    """A number to three digits, never rounded up."""
    if value == 0.0:
        return 0.0
    digits = 2 - int(np.floor(np.log10(value)))
    return float(np.round(np.floor(value * 10.0**digits * (1.0 + 1e-12)) / 10.0**digits, max(digits, 0)))
