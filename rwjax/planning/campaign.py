"""The recommended campaign: few runs that together tell most effects apart, as large as a rig's limits allow.

Which runs: each is there for effects that look alike without it (coast-downs, slow triangles through standstill, a
staircase to the limit, multisines of two sizes, repeats for the noise); squares of another kind than any fitted run
validate. How large: by simulation of the rig itself, whose file may be wrong, hence below its limits. Which way: where travel
is limited, so that the runs stay within it one after the other, each beginning where the one before has ended.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from rwjax.effects import shown
from rwjax.effects.library import shown_in
from rwjax.errors import InputError
from rwjax.planning.envelope import Envelope, in_both, reaches
from rwjax.planning.experiment import REST_S, Experiment
from rwjax.planning.files import Run
from rwjax.planning.motion import TAIL_S, WAIT_S, left, motion, peaks
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import one_axis_plant_of

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
COASTING = 0.05
"""Share of the travel that a rig may still have to go a minute after a run; the rest of it is what its file may be wrong by."""


@dataclass(frozen=True)
class Design:
    """A run before its size is known. `share`: of the largest amplitude that the limits allow; `offset`: over the amplitude."""

    kind: str
    share: float
    period: float  # s
    length: float  # s
    why: str
    shows: str = ""  # key of `rwjax.effects.shown.RUNS`, "" where it is there for no effect
    offset: float = 0.0
    way: float = 1.0
    repeats: int = 1
    role: str = "train"

    def at(self, amplitude: float, pace: float = 1.0, turned: float = 1.0) -> Experiment:
        """The experiment of this amplitude [V], as fast as wanted; `turned`: -1 for the other way."""
        offset, way = round(amplitude * self.offset, 4), turned * self.way
        period, length = round(pace * self.period, 2), round(pace * self.length, 2)
        return Experiment(self.kind, way * amplitude, turned * offset + 0.0, period, length)  # 0.0, never -0.0

    @property
    def reverses(self) -> bool:
        """Whether the rig is to move both ways."""
        return not self.one_way and self.offset == 0.0

    @property
    def one_way(self) -> bool:
        """Whether the command has one sign."""
        return self.kind == "coast-down"


DESIGNS = {
    "multisine": Design("multisine", 0.6, 10.0, 20.0, "three times: what is noise", repeats=3),
    "multisine_fast": Design("multisine", 1.0, 4.0, 12.0, "fast: what lags or swings", shown.FAST),
    "multisine_fast_small": Design("multisine", 0.4, 4.0, 12.0, "fast and small: does it scale?", shown.FAST),
    "triangle_slow": Design("triangle", 0.5, 16.0, 16.0, "slow: friction, play, ripple", shown.SLOW),
    "triangle": Design("triangle", 0.5, 8.0, 16.0, "medium: friction over rate", shown.SLOW),
    "triangle_fast": Design("triangle", 0.5, 4.0, 12.0, "fast: friction over rate", shown.SLOW),
    "staircase": Design("staircase", 1.0, 16.0, 16.0, "levels to the limit: drive", shown.LEVELS),
    "staircase_small": Design("staircase", 0.25, 16.0, 16.0, "dwell and breakaway", shown.DWELLING),
    "coast_fast": Design("coast-down", 1.0, 4.0, 12.0, "coasting: drag, friction", shown.COASTING),
    "coast_fast_back": Design("coast-down", 1.0, 4.0, 12.0, "coasting backward", shown.COASTING, way=-1.0),
    "coast_slow": Design("coast-down", 0.4, 4.0, 12.0, "coasting from less", shown.COASTING),
    "coast_slow_back": Design("coast-down", 0.4, 4.0, 12.0, "coasting backward from less", shown.COASTING, way=-1.0),
    "square": Design("square", 0.8, 5.0, 15.0, "validates: a kind of its own", role="validate"),
    "square_offset": Design("square", 0.6, 6.0, 12.0, "validates: about an offset", offset=0.15, role="validate"),
}
BACK = "_back"
"""Ends the name of a run that goes the other way than the one before."""
SECONDS = REST_S + max(design.length for design in DESIGNS.values()) + TAIL_S


def recommend(rig: Rig, within: Envelope) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """The runs for a rig, and remarks on what its limits or its file leave out.

    Where travel is limited, the runs keep to it together, played in this order from where the first one begins. Raises
    `InputError` where nothing that the limits allow moves the simulated rig.
    """
    designs = _possible(within)
    amplitude, paces = _sized(rig, within, designs)
    every = zip(designs.items(), amplitude.tolist(), paces, strict=True)
    sized = {name: _Sized(design, volts, pace) for (name, design), volts, pace in every if volts > 0.0}
    found = (_in_a_row if _short(within) else _each_alone)(rig, within, sized)
    runs: list[Run] = []
    for name, played in found.items():
        design = designs[name]
        tells = shown_in(design.shows, rig.kind)
        names = [name] if design.repeats == 1 else [f"{name}_{number + 1}" for number in range(design.repeats)]
        runs += [
            Run(each, one.experiment, design.role, design.why, tells, one.reaches, one.way)
            for each, one in zip(names, played, strict=True)
        ]
    if not runs:
        rest = f", or lets it come to rest within {WAIT_S:g} s" if _short(within) else ""
        raise InputError(
            f"within these limits ({within.volts:g} V at most) no run moves the simulated rig{rest}; raise them, or check its "
            "numbers"
        )
    remarks = []
    if missing := [name for name in designs if name not in found]:
        rest = "do not come to rest, " if _short(within) else ""
        remarks.append(
            f"left out, since within these limits they {rest}hardly move the simulated rig, or one way only: "
            f"{', '.join(missing)}"
        )
    if len(within.ways) == 1:
        remarks.append(
            "the ESC turns one way (`neutral_us` is at an end of its pulses, or near it): runs that reverse are left out"
        )
    elif rig.pwm is not None and (least := min(reaches(rig.pwm).values())) < max(reaches(rig.pwm).values()):
        if within.volts == least:
            remarks.append(
                f"`neutral_us` is {rig.pwm.neutral_us:g}, off the middle of the pulses: the runs keep to the {least:g} V that they "
                "reach both ways"
            )
    if _short(within):
        remarks.append(
            f"the runs keep to {in_both(within.most['yaw_rad'])} either way of where the axis stands when the first one begins: "
            "bring it to the middle of its travel before, and play them in this order"
        )
    if (
        rig.kind != "wheel"
        and not one_axis_plant_of(structure_of(rig), jnp.asarray(theta_of(rig, structure_of(rig)))).bodies()
    ):
        remarks.append(
            "the rig file holds no dry friction: if the rig sticks, small runs may not move it; plan again from a corrected file"
        )
    return tuple(runs), tuple(remarks)


def _short(within: Envelope) -> bool:
    """Whether travel is limited."""
    return "yaw_rad" in within.known


def _possible(within: Envelope) -> dict[str, Design]:
    """The designs for a drive that turns both ways; of one that turns one way, those that do not reverse it."""
    if len(within.ways) == 2:
        return DESIGNS
    way = within.ways[0]
    forward = {name: design for name, design in DESIGNS.items() if design.one_way and design.way > 0.0}
    return {name: replace(design, way=way) for name, design in forward.items()}


class _Sized(NamedTuple):
    """A design with the amplitude [V] and the pace that the limits allow."""

    design: Design
    amplitude: float
    pace: float


class _Played(NamedTuple):
    """A run as simulated: the experiment, peaks by output, and the lowest and highest angle [rad] from where it began."""

    experiment: Experiment
    reaches: dict[str, float]
    way: tuple[float, float] | None


def _each_alone(rig: Rig, within: Envelope, sized: dict[str, _Sized]) -> dict[str, list[_Played]]:
    """Every design at the largest amplitude up to its own that keeps to the limits, each from angle 0."""
    if not sized:
        return {}
    designs = {name: each.design for name, each in sized.items()}
    levels = _levels(np.array([each.amplitude for each in sized.values()]), LARGE)
    paces = [each.pace for each in sized.values()]
    tried = _tried(rig, within, designs, levels, paces)  # once more as it will be played
    found = {}
    for d, (name, each) in enumerate(sized.items()):
        if (size := tried.allowed[d] - 1) >= 0:
            reaches = {output: float(values[d, size]) for output, values in tried.peaks.items()}
            one = _Played(each.design.at(levels[d, size], each.pace), reaches, None)
            found[name] = [one] * each.design.repeats
    return found


def _in_a_row(rig: Rig, within: Envelope, sized: dict[str, _Sized]) -> dict[str, list[_Played]]:
    """The designs played one after the other: each the way, and as large, as the travel that is left allows, the way that ends
    nearer the middle where both allow the same. A design and its way back are one: the same size, opposite ways."""
    found: dict[str, list[_Played]] = {}
    begin = 0.0
    for _, group in groupby(sized, key=lambda name: name.removesuffix(BACK)):
        names = list(group)
        parts = [sized[name] for name in names]
        levels = _levels(np.array([part.amplitude for part in parts]), 1.0 / LEVELS)
        lanes = [(turned, k) for turned in (1.0, -1.0) for k in range(levels.shape[1])]
        at, good = np.full(len(lanes), begin), np.ones(len(lanes), bool)
        rows: list[list[_Played]] = []
        for d, part in enumerate(parts):
            experiments = [part.design.at(levels[d, k], part.pace, turned) for turned, k in lanes]
            for _ in range(part.design.repeats):
                moved = motion(rig, experiments, SECONDS + WAIT_S, at)
                peak, rest = peaks(moved), left(moved["yaw_rad_s"])
                good &= rest <= COASTING * within.most["yaw_rad"]
                good &= moves(rig, moved, np.full(len(lanes), part.design.reverses))
                low, high = moved["yaw_rad"].min(axis=1) - rest, moved["yaw_rad"].max(axis=1) + rest
                for origin in (
                    np.zeros(len(lanes)),
                    at,
                ):  # within the travel in its place, and where it is played alone
                    peak["yaw_rad"] = np.maximum(high - origin, origin - low)
                    good &= within.used(peak) <= KEPT
                ways = zip((low - at).tolist(), (high - at).tolist(), strict=True)
                rows.append([
                    _Played(experiment, {name: float(values[k]) for name, values in peak.items()}, way)
                    for k, (experiment, way) in enumerate(zip(experiments, ways, strict=True))
                ])  # fmt: skip
                onward = np.sign(moved["yaw_rad_s"][:, -1]) * np.where(np.isfinite(rest), rest, 0.0)
                at = moved["yaw_rad"][:, -1] + onward
        if not good.any():
            continue
        size = np.array([k for _, k in lanes])
        best = min(np.flatnonzero(good), key=lambda lane: (-size[lane], abs(at[lane])))
        begin, played = at[best], iter(rows)
        for name, part in zip(names, parts, strict=True):
            found[name] = [next(played)[best] for _ in range(part.design.repeats)]
    return found


def _levels(amplitude: Float[np.ndarray, " d"], least: float) -> Float[np.ndarray, "d a"]:
    """Amplitudes from a share of the given ones up to them."""
    return np.vectorize(_rounded_down)(amplitude[:, None] * np.linspace(least, 1.0, LEVELS))


def _sized(rig: Rig, within: Envelope, among: dict[str, Design]) -> tuple[Float[np.ndarray, " d"], list[float]]:
    """Amplitude [V] and pace of every design; an amplitude of 0 where the limits leave nothing that moves the rig."""
    designs = list(among.values())
    top = np.array([within.volts / (1.0 + design.offset) for design in designs])
    levels = top[:, None] * np.geomspace(SMALLEST, 1.0, LEVELS)
    largest, next_larger, least = np.zeros((3, len(PACES), len(designs)))
    short = _short(within)
    for k, pace in enumerate(PACES):
        tried = _tried(rig, within, among, levels, [pace] * len(designs))
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
    allowed = _tried(rig, within, among, finer, paces).allowed
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


def _tried(
    rig: Rig, within: Envelope, designs: dict[str, Design], levels: Float[np.ndarray, "d a"], paces: Sequence[float]
) -> Tried:
    """All designs at these amplitudes and paces, side by side, each from angle 0."""
    lanes = [d.at(a, pace) for d, row, pace in zip(designs.values(), levels, paces, strict=True) for a in row]
    moved = motion(rig, lanes, SECONDS + (WAIT_S if _short(within) else 0.0))
    found = peaks(moved)
    used = within.used(found)
    if _short(within):
        used[left(moved["yaw_rad_s"]) > COASTING * within.most["yaw_rad"]] = np.inf
    both = np.repeat([design.reverses for design in designs.values()], levels.shape[1])
    used = used.reshape(levels.shape)
    allowed = np.cumprod(used <= KEPT, axis=1).sum(axis=1)
    peak = {name: values.reshape(levels.shape) for name, values in found.items()}
    return Tried(used, allowed, moves(rig, moved, both).reshape(levels.shape), peak)


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
