"""The recommended campaign: few runs that together tell most effects apart, as large as a rig's limits allow.

Which runs: each is there for effects that look alike without it (coast-downs, slow triangles through standstill, a
staircase to the limit, multisines of two sizes, repeats for the noise); squares of another kind than any fitted run
validate. How large: by simulation of the rig itself, whose file may be wrong, hence below its limits.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from rwjax.build import structure_of, theta_of
from rwjax.errors import InputError
from rwjax.plan.envelope import Envelope
from rwjax.plan.experiment import REST_S, Experiment
from rwjax.plan.files import Run
from rwjax.plan.motion import TAIL_S, motion, peaks
from rwjax.rig import Rig
from rwjax.rig_names import SUBSYSTEMS
from rwjax.simulate import one_axis_plant_of

KEPT = 0.9
"""Share of a limit that the simulated rig may reach: the true one differs."""
MARGIN = 1.5
"""Amplitude over the least one that moves the simulated rig both ways: the true one may stick harder."""
RESOLVED = 20.0
"""Counts of the encoder below which nothing counts as moving."""
BOTH_WAYS = 0.05
"""Share of its largest rate that a rig has to reach the other way to count as reversing."""
LEVELS = 8
"""Amplitudes tried side by side, from the largest down to `SMALLEST` of it; then once more between the best two."""
SMALLEST = 0.02
NEAR = np.append(0.0, np.linspace(0.7, 1.06, LEVELS - 1))
"""Where the largest amplitude is looked for, between an allowed one (0) and that at which a line meets the limits (1)."""
PACES = (1.0, 0.4, 0.15)
"""Shares of a design's period and length: a rig with little travel or a wheel in between moves more under faster commands."""
LARGE = 0.5
"""Share of the amplitude which another pace allows that a slower one has to allow to be preferred, where travel is limited."""


@dataclass(frozen=True)
class Design:
    """A run before its size is known. `share`: of the largest amplitude that the limits allow; `offset`: over the amplitude."""

    kind: str
    share: float
    period: float  # s
    length: float  # s
    why: str
    tells: tuple[str, ...] = ()  # effects
    offset: float = 0.0
    way: float = 1.0
    repeats: int = 1
    role: str = "train"

    def at(self, amplitude: float, pace: float = 1.0) -> Experiment:
        """The experiment of this amplitude [V], as fast as wanted."""
        offset = round(amplitude * self.offset, 4)
        return Experiment(
            self.kind, self.way * amplitude, offset, round(pace * self.period, 2), round(pace * self.length, 2)
        )

    @property
    def reverses(self) -> bool:
        """Whether the rig is to move both ways."""
        return self.kind != "coast-down" and self.offset == 0.0


COASTS = (
    "axis.viscous",
    "axis.coulomb",
    "axis.quadratic_drag",
    "axis.asymmetric_friction",
    "wheel.coulomb",
    "wheel.drag",
)
QUICK = ("drive.delay", "drive.lag", "drive.rate_limit", "axis.flexible_coupling", "sensor.delay", "sensor.clock")
SLOW = ("axis.coulomb", "axis.stribeck", "axis.presliding", "axis.angle_friction", "axis.imbalance", "wheel.cogging")
LEVEL = ("drive.deadzone", "drive.saturation", "drive.curvature", "drive.asymmetric_gain", "drive.supply_sag")
DWELL = ("axis.stribeck", "axis.presliding", "axis.backlash", "drive.deadzone")

DESIGNS = {
    "multisine": Design("multisine", 0.6, 10.0, 20.0, "three times: what is noise", repeats=3),
    "multisine_fast": Design("multisine", 1.0, 4.0, 12.0, "fast: what lags or swings", QUICK),
    "multisine_fast_small": Design("multisine", 0.4, 4.0, 12.0, "fast and small: does it scale?", QUICK),
    "triangle_slow": Design("triangle", 0.5, 16.0, 16.0, "slow: friction, play, ripple", SLOW),
    "triangle": Design("triangle", 0.5, 8.0, 16.0, "medium: friction over rate", SLOW),
    "triangle_fast": Design("triangle", 0.5, 4.0, 12.0, "fast: friction over rate", SLOW),
    "staircase": Design("staircase", 1.0, 16.0, 16.0, "levels to the limit: drive", (*LEVEL, "motor.saturation")),
    "staircase_small": Design("staircase", 0.25, 16.0, 16.0, "dwell and breakaway", DWELL),
    "coast_fast": Design("coast-down", 1.0, 4.0, 12.0, "coasting: drag, friction", COASTS),
    "coast_fast_back": Design("coast-down", 1.0, 4.0, 12.0, "coasting backward", COASTS, way=-1.0),
    "coast_slow": Design("coast-down", 0.4, 4.0, 12.0, "coasting from less", COASTS),
    "coast_slow_back": Design("coast-down", 0.4, 4.0, 12.0, "coasting backward from less", COASTS, way=-1.0),
    "square": Design("square", 0.8, 5.0, 15.0, "validates: a kind of its own", role="validate"),
    "square_offset": Design("square", 0.6, 6.0, 12.0, "validates: about an offset", offset=0.15, role="validate"),
}
SECONDS = REST_S + max(design.length for design in DESIGNS.values()) + TAIL_S


def recommend(rig: Rig, within: Envelope) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """The runs for a rig, and remarks on what its limits or its file leave out.

    Raises `InputError` where nothing that the limits allow moves the simulated rig.
    """
    amplitude, paces = _sized(rig, within)
    levels = np.vectorize(_rounded_down)(amplitude[:, None] * np.linspace(LARGE, 1.0, LEVELS))
    tried = _tried(rig, within, levels, paces)  # once more as it will be played
    runs: list[Run] = []
    missing = []
    for d, (name, design) in enumerate(DESIGNS.items()):
        size = tried.allowed[d] - 1
        if size < 0 or amplitude[d] == 0.0:
            missing.append(name)
            continue
        tells = tuple(effect for effect in design.tells if rig.kind in SUBSYSTEMS[effect.partition(".")[0]])
        reaches = {output: float(values[d, size]) for output, values in tried.peaks.items()}
        run = Run(name, design.at(levels[d, size], paces[d]), design.role, design.why, tells, reaches)
        names = [name] if design.repeats == 1 else [f"{name}_{number + 1}" for number in range(design.repeats)]
        runs += [replace(run, name=each) for each in names]
    if not runs:
        raise InputError(
            f"within these limits ({within.volts:g} V at most) no run moves the simulated rig; raise them, or check its numbers"
        )
    remarks = [
        f"left out, since within these limits they hardly move the simulated rig, or one way only: {', '.join(missing)}"
    ] * bool(missing)
    if (
        rig.kind != "wheel"
        and not one_axis_plant_of(structure_of(rig), jnp.asarray(theta_of(rig, structure_of(rig)))).bodies()
    ):
        remarks.append(
            "the rig file holds no dry friction: if the rig sticks, small runs may not move it; plan again from a corrected file"
        )
    return tuple(runs), tuple(remarks)


def _sized(rig: Rig, within: Envelope) -> tuple[Float[np.ndarray, " d"], list[float]]:
    """Amplitude [V] and pace of every design; an amplitude of 0 where the limits leave nothing that moves the rig."""
    designs = list(DESIGNS.values())
    top = np.array([within.volts / (1.0 + design.offset) for design in designs])
    levels = top[:, None] * np.geomspace(SMALLEST, 1.0, LEVELS)
    largest, next_larger, least = np.zeros((3, len(PACES), len(designs)))
    short = "yaw_rad" in within.known  # of travel
    for k, pace in enumerate(PACES):
        tried = _tried(rig, within, levels, [pace] * len(designs))
        for d, last in enumerate(tried.allowed.tolist()):
            still = np.flatnonzero(~tried.moving[d, :last])
            first = still[-1] + 1 if len(still) else 0  # the least level from which on it moves
            if first < last:
                largest[k, d], least[k, d] = levels[d, last - 1], levels[d, first]
                next_larger[k, d] = _where_used_up(levels[d], tried.used[d], last)
        if not short and largest[k].all():
            break  # nothing asks for faster commands
    large = largest >= LARGE * largest.max(axis=0) if short else largest > 0.0
    pace = np.argmax((largest > 0.0) & large, axis=0)  # the slowest of them
    paces = [PACES[k] for k in pace]
    largest, next_larger, least = (x[pace, np.arange(len(designs))] for x in (largest, next_larger, least))
    finer = largest[:, None] + (next_larger - largest)[:, None] * NEAR
    allowed = _tried(rig, within, finer, paces).allowed
    largest = finer[np.arange(len(designs)), np.maximum(allowed - 1, 0)]
    share = np.array([design.share for design in designs])
    return np.minimum(np.maximum(share * largest, MARGIN * least), largest), paces


def _where_used_up(levels: Float[np.ndarray, " a"], used: Float[np.ndarray, " a"], allowed: int) -> float:
    """Amplitude at which the limits are used up to `KEPT`, by a line between the last allowed level and the next."""
    if allowed == len(levels):
        return float(levels[-1])
    (low, high), (before, after) = levels[allowed - 1 : allowed + 1], used[allowed - 1 : allowed + 1]
    return float(low + (high - low) * (KEPT - before) / (after - before)) if np.isfinite(after) else float(low)


class Tried(NamedTuple):
    """Designs at several amplitudes each: the largest share of a limit that is used; how many of the amplitudes, counted from
    the least, stay within the limits; which of them move the rig; and the peaks of every output."""

    used: Float[np.ndarray, "d a"]
    allowed: Int[np.ndarray, " d"]
    moving: Bool[np.ndarray, "d a"]
    peaks: dict[str, Float[np.ndarray, "d a"]]


def _tried(rig: Rig, within: Envelope, levels: Float[np.ndarray, "d a"], paces: Sequence[float]) -> Tried:
    """All designs at these amplitudes and paces, side by side."""
    designs = list(DESIGNS.values())
    lanes = [design.at(a, pace) for design, row, pace in zip(designs, levels, paces, strict=True) for a in row]
    moved = motion(rig, lanes, SECONDS)
    found = {name: values.reshape(levels.shape) for name, values in peaks(moved).items()}
    both = np.repeat([design.reverses for design in designs], levels.shape[1])
    used = within.used(found)
    allowed = np.cumprod(used <= KEPT, axis=1).sum(axis=1)
    return Tried(used, allowed, moves(rig, moved, both).reshape(levels.shape), found)


def moves(rig: Rig, moved: dict[str, np.ndarray], both_ways: Bool[np.ndarray, " e"]) -> Bool[np.ndarray, " e"]:
    """Whether each of some simulated runs moves the axis, or the wheel where there is none, so that its encoder shows it."""
    body, angle, rate = (
        ("wheel", "wheel_rad", "wheel_rad_s") if rig.kind == "wheel" else ("axis", "yaw_rad", "yaw_rad_s")
    )
    counts = rig.counts_per_rev.get(body)
    resolved = RESOLVED * 2.0 * np.pi / counts if counts else 0.0
    forth, back = moved[rate].max(axis=1), -moved[rate].min(axis=1)
    turned = np.minimum(forth, back) > BOTH_WAYS * np.maximum(forth, back)
    return (np.ptp(moved[angle], axis=1) > resolved) & (turned | ~both_ways)


def _rounded_down(value: float) -> float:
    """To three digits, never up."""
    if value == 0.0:
        return 0.0
    digits = 2 - int(np.floor(np.log10(value)))
    return float(np.round(np.floor(value * 10.0**digits * (1.0 + 1e-12)) / 10.0**digits, max(digits, 0)))
