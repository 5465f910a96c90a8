"""The diagnosis in words, for the terminal and the head of the report."""

from math import isfinite

from rwjax.diagnosis.diagnosis import Diagnosis, Rung
from rwjax.diagnosis.localise.where import Where
from rwjax.effects.library import BY_NAME, unit_of_number
from rwjax.kinds import half_column

_ENDS = {"_rad": "rad", "_rad_s": "rad/s", "_A": "A"}
_HALVED = ("wheel_rad", "wheel_rad_s", "current_A")
_SIGNALS = (
    "yaw_rad",
    "yaw_rad_s",
    *_HALVED,
    "pitch_rad",
    "pitch_rad_s",
    *(half_column(y, k) for y in _HALVED for k in range(2)),
)
UNIT = {name: unit for name in _SIGNALS for end, unit in _ENDS.items() if name.endswith(end)}
"""Unit of every output that a log may hold."""

SURE, FAR_PERCENT = 3.0, 10.0
"""Standard errors, of both fits, by which a number's shift is worth a line; and the shift that is where its error with the effects
alone is that much smaller: the gap inflates the error without them."""

AS_MUCH = 0.005
"""Difference in the share of the excess below which laws in two coordinates remove as much."""


def spoken(name: str) -> str:
    """An effect in words: its label, or the wrong number's name."""
    if name.startswith("parameter."):
        return f"wrong {name.removeprefix('parameter.')}"
    return BY_NAME[name].label if name in BY_NAME else name


def listed(names: tuple[str, ...]) -> str:
    """Effects in words with their names."""
    return " and ".join(f"{spoken(name)} ({name})" for name in names)


def verdict_sentence(d: Diagnosis) -> str:
    """What the diagnosis says, as one sentence."""
    g = d.gaps[d.signal]
    closed = (
        f" and {'close' if len(d.effects) > 1 else 'closes'} {100 * g.closed:.0f} % of the gap"
        if g.closed is not None
        else ""
    )
    if d.untold:
        return f"Unknown: {d.untold}, so that they do not say whether anything is missing."
    if d.verdict == "none":
        return f"Nothing is missing: the rig explains the logs down to the floor ({g.before:.3g} of {g.floor:.3g} {UNIT[d.signal]})."
    if d.verdict == "effect":
        return f"The rig lacks {listed(d.effects)}: on held-out runs the error falls from {g.before:.3g} to {g.after:.3g} {UNIT[d.signal]}{closed}."
    if d.verdict == "ambiguous":
        others = "; or ".join(listed(names) for names in d.alternatives)
        return f"The rig lacks {listed(d.effects)}; or {others}: these logs cannot tell them apart."
    if d.effects:
        part = f"{100 * g.closed:.0f} % of the gap" if g.closed is not None else "part of the gap"
        explain = "explains" if len(d.effects) == 1 else "together explain"
        return f"Unknown: {listed(d.effects)} {explain} {part}, but what is left stands above the floor and fits no effect of the library."
    return "Unknown: a gap above the floor remains that no effect of the library explains."


def where_words(where: Where) -> str:
    """The coordinate of a law, and those in which another removes as much."""
    alike = [
        name
        for name, share in where.shares.items()
        if name != where.coordinate and abs(share - where.share) < AS_MUCH < where.share
    ]
    name, *others = (one.replace("_", " ") for one in (where.coordinate, *alike))
    return name + (f" (as one in {', '.join(others)})" if others else "")


def numbers_of(rung: Rung) -> list[str]:
    """The numbers of what a rung names, those of an effect in one line."""
    lines: dict[str, list[str]] = {}
    for number, (value, error) in rung.own.items():
        effect, _, name = number.rpartition(".")
        head, symbol = (f"{effect}: ", name) if effect in BY_NAME else ("", number)
        spread = f"± {error:.2g}" if isfinite(error) else "(not told by these logs)"
        unit = f" {unit_of_number(number)}".rstrip()
        lines.setdefault(head or number, []).append(f"{symbol} = {value:.4g} {spread}{unit}")
    return [(head if head.endswith(": ") else "") + ", ".join(numbers) for head, numbers in lines.items()]


def moved(first: Rung, last: Rung) -> list[str]:
    """The base numbers that move as the effects are added, beyond chance or far."""
    lines = []
    for name, (sigmas, percent) in last.drift.items():
        (before, _), (after, error) = first.numbers[name], last.numbers[name]
        far = not abs(percent) <= FAR_PERCENT and abs(after - before) > SURE * error
        if abs(sigmas) > SURE or far:
            way = f"{percent:+.1f} %" if isfinite(percent) else f"{after - before:+.3g}"
            chance = f" ({sigmas:+.1f} sigma)" if isfinite(sigmas) else ""
            lines.append(f"{name} moves by {way}{chance} when the effects are added")
    return lines


def text(d: Diagnosis) -> list[str]:
    """The result in lines, readable without colour."""
    lines = [verdict_sentence(d), ""]
    for name, one in d.gaps.items():
        closed = "" if one.closed is None else f", closed {100 * one.closed:.1f} %"
        if one.ci95 is not None:
            closed += f" (95 %: {100 * one.ci95[0]:.0f} to {100 * one.ci95[1]:.0f})"
        mark = "*" if name == d.signal and len(d.gaps) > 1 else " "
        lines.append(
            f"{mark} {name}: before {one.before:.4g}, after {one.after:.4g}, floor {one.floor:.4g} {UNIT[name]}{closed}"
        )
    if d.where is not None and d.verdict != "none":
        lines.append(
            f"  where: {d.subsystem}; a law in {where_words(d.where)} removes {100 * d.where.share:.0f} % of the excess squared error"
        )
    if len(d.waterfall) > 1:
        first, last = d.waterfall[0], d.waterfall[-1]
        lines += [f"  {line}" for line in (*numbers_of(last), *moved(first, last))]
    lines += [f"  note: {remark}" for remark in d.remarks]
    lines.append(f"  held out: {d.held_out}; next experiment: {d.next_experiment}")
    return lines
