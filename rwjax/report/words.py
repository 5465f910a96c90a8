"""The diagnosis in words, for the terminal and the head of the report."""

from rwjax.diagnose.diagnosis import Diagnosis
from rwjax.report.plots import UNIT, spoken


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
            f"  where: {d.subsystem}; a law in {d.where.coordinate.replace('_', ' ')} removes {100 * d.where.share:.0f} % "
            "of the excess squared error"
        )
    if len(d.waterfall) > 1:
        base = d.waterfall[-1]
        for name, (sigmas, percent) in base.drift.items():
            if abs(sigmas) > 3.0:
                lines.append(f"  {name} moves by {percent:+.1f} % ({sigmas:+.1f} sigma) when the effects are added")
    lines += [f"  note: {remark}" for remark in d.remarks]
    lines.append(f"  held out: {d.held_out}; next experiment: {d.next_experiment}")
    return lines
