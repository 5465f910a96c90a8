"""The diagnosis in words, for the terminal and the head of the report."""

from collections.abc import Mapping, Sequence
from math import inf, isfinite

from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.hypothesis import spoken
from rwjax.diagnosis.localise.where import Where
from rwjax.diagnosis.settings import ReportSettings
from rwjax.diagnosis.verdict import Verdict
from rwjax.diagnosis.waterfall import Rung
from rwjax.diagnosis.worst_windows import Window
from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.errors import counted, in_two_digits
from rwjax.kinds import half_column
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Rig
from rwjax.rig.number_unit import unit_in_rig

_HALVED = ("wheel_rad", "wheel_rad_s", "current_A")
_SIGNALS = (
    "yaw_rad",
    "yaw_rad_s",
    *_HALVED,
    "pitch_rad",
    "pitch_rad_s",
    *(half_column(y, k) for y in _HALVED for k in range(2)),
)
UNIT = {name: unit_of(name) for name in _SIGNALS}
"""Unit of every output that a log may hold."""


def _listed(names: tuple[str, ...]) -> str:
    """Effects in words with their names."""
    return " and ".join(f"{spoken(name)} ({name})" for name in names)


def _missing(names: tuple[str, ...], file: str = "its file") -> str:
    """What a rig lacks, and in which numbers its file is wrong; `file` is how the file is called where nothing is lacking."""
    numbers = tuple(name for name in names if name.startswith("parameter."))
    lacks = _listed(tuple(name for name in names if name not in numbers))
    wrong = " and ".join(name.removeprefix("parameter.") for name in numbers)
    if not numbers:
        return f"the rig lacks {lacks}"
    return f"the rig lacks {lacks}, and its file is wrong in {wrong}" if lacks else f"{file} is wrong in {wrong}"


def explanations(effects: tuple[str, ...], alternatives: tuple[tuple[str, ...], ...]) -> tuple[str, ...]:
    """What a rig lacks, in words, by each of the sets of names that cannot be told apart.

    Args:
        effects: the named effects.
        alternatives: the sets of names that cannot be told apart from them.

    Returns:
        A clause for each set, the named one first.
    """
    return tuple(_missing(names, "the rig's file") for names in (effects, *alternatives))


def several_sentence(verdict: Verdict, count: int, gap: Gap, stays: str) -> str:
    """What a diagnosis says that claims one of several explanations, without saying which they are.

    Args:
        verdict: the outcome, `ambiguous` or `partial`.
        count: how many explanations there are [1].
        gap: the gap of the headline signal [SI].
        stays: what is left of which output, in words.

    Returns:
        The sentence.
    """
    closes = f"; the first closes {100 * gap.closed:.0f} % of the gap" if gap.closed is not None else ""
    said = f"these logs do not tell which of {count} explanations is true{closes}"
    return f"Only in part, and {said}; {stays} stay." if verdict == "partial" else f"{said[0].upper()}{said[1:]}."


def sure_of(number: str) -> str:
    """What to do about a number of the rig file that is said to be wrong, where its owner knows better, as one sentence.

    Args:
        number: name of the number, as `parameter.motor.resistance`.

    Returns:
        The sentence.
    """
    return f"{number} says that the rig file's number is wrong; if you are sure of that number, ask again with `--without {number}`"


def verdict_sentence(
    verdict: Verdict,
    effects: tuple[str, ...],
    alternatives: tuple[tuple[str, ...], ...],
    gap: Gap,
    unit: str,
    uninformative: str | None,
    known: str = "effect of the library",
    elsewhere: tuple[str, Gap] | None = None,
) -> str:
    """What a diagnosis says, as one sentence.

    Args:
        verdict: the outcome.
        effects: the named effects.
        alternatives: the sets of names that cannot be told apart from them.
        gap: the gap of the headline signal [SI].
        unit: the signal's unit.
        uninformative: why the logs say nothing, None where they do.
        known: what each of the candidates is.
        elsewhere: another output that the names leave far from its floor, and its gap; None where there is none.

    Returns:
        The sentence.
    """
    either = "; or ".join([_missing(effects, "the rig's file"), *map(_missing, alternatives)])
    closed = f" and closes {100 * gap.closed:.0f} % of the gap" if gap.closed is not None else ""
    if uninformative:
        return f"Unknown: {uninformative}, so that they do not say whether anything is missing."
    if verdict == "none":
        return f"Nothing is missing: the rig explains the logs down to the floor ({gap.before:.3g} of {gap.floor:.3g} {unit})."
    if verdict == "effect":
        return (
            f"{either[0].upper()}{either[1:]}: on held-out runs the error falls from {gap.before:.3g} to {gap.after:.3g} "
            f"{unit}{closed}."
        )
    if verdict == "ambiguous":
        return f"{either[0].upper()}{either[1:]}: these logs cannot tell them apart."
    part = f"{100 * gap.closed:.0f} % of the gap" if gap.closed is not None else "part of the gap"
    name, other = elsewhere or ("", gap)
    stays = f"{other.after:.3g} {UNIT[name]} of {name}" if name else f"{other.after:.3g} {unit}"
    floors = f"{in_two_digits(other.after / other.floor)} times the floor"
    if verdict == "partial":
        return (
            f"Only in part: {either}; this closes {part} on held-out runs, and for the {stays} that stay "
            f"({floors}) no {known} was found that holds."
        )
    if effects:
        close = "closes" if len(effects) == 1 else "together close"
        return (
            f"Unknown: {_listed(effects)} {close} {part}, but this is no claim: {stays} stay, {floors}, and no {known} was found that "
            "explains these."
        )
    return f"Unknown: {_remaining(gap, unit)}, and no {known} was found that explains it."


def _remaining(gap: Gap, unit: str) -> str:
    """That a gap is left, as a clause."""
    return f"a gap above the floor remains ({gap.before:.3g} of {gap.floor:.3g} {unit})"


def doubted_sentence(effects: tuple[str, ...], gap: Gap, why: str, stays: str = "") -> str:
    """What a diagnosis says that does not claim names though they would close a gap, as one sentence.

    Args:
        effects: the names.
        gap: the gap of the headline signal [SI].
        why: why they are not claimed.
        stays: what they leave of which output, in words; empty where that is the floor.

    Returns:
        The sentence.
    """
    closed = f"{100 * gap.closed:.0f} % of the gap" if gap.closed is not None else "part of the gap"
    left = f"; {stays} stay" if stays else ""
    return f"Unknown: {_listed(effects)} would close {closed}, but this is no claim: {why}{left}."


def beside_runaways(times: Mapping[str, float]) -> str:
    """Why names are not claimed beside which numbers of the rig ran away, as a clause.

    Args:
        times: each number's estimate over its value in the rig file [1], by its name.

    Returns:
        The clause.
    """
    told = " and ".join(f"{name} ({in_two_digits(x)} times the file's)" for name, x in times.items())
    runs = "runs" if len(times) == 1 else "run"
    return f"beside it {told} {runs} away, as where something holds a part, and what that is is not named"


def went_no_further(names: Sequence[str], why: str, led: str) -> str:
    """What a diagnosis says that claims a part of what is missing, and whose search for the rest was ended, as one sentence.

    Args:
        names: the names that are claimed.
        why: what ended the search.
        led: what left least until then, as a clause, or nothing.

    Returns:
        The sentence.
    """
    said = " and ".join(map(spoken, names))
    return (
        f"{why} ended the search for what is missing beside {said}, which holds by what was compared until then; a search that ends may name "
        f"more, or something else in its place{led}"
    )


def unfinished_sentence(effects: tuple[str, ...], untried: int, gap: Gap, unit: str) -> str:
    """What a diagnosis says whose search did not come to its end, as one sentence.

    Args:
        effects: what leads so far.
        untried: how many candidates were not compared.
        gap: the gap of the headline signal [SI].
        unit: the signal's unit.

    Returns:
        The sentence.
    """
    many = counted(untried, "candidate")
    ended = f"with {many} not compared" if untried else "before it was through"
    if not effects:
        return f"Unfinished: {_remaining(gap, unit)}, and the search was ended {ended}."
    close = "close" if len(effects) > 1 else "closes"
    part = f"{100 * gap.closed:.0f} % of the gap" if gap.closed is not None else "part of the gap"
    return f"Unfinished: so far {_listed(effects)} {close} {part}, which is no claim: the search was ended {ended}."


def gap_line(name: str, gap: Gap, *, marked: bool, told: bool) -> str:
    """The gap of one output as a line.

    Args:
        name: the output.
        gap: its gap [SI].
        marked: whether the line is marked as the headline.
        told: whether the share that is closed is told: of a gap that hardly exists it means nothing.

    Returns:
        The line.
    """
    closed = f", closed {100 * gap.closed:.1f} %" if told and gap.closed is not None else ""
    if closed and gap.ci95 is not None:
        closed += f" (95 %: {100 * gap.ci95[0]:.1f} to {100 * gap.ci95[1]:.1f})"
    mark = "*" if marked else " "
    return f"{mark} {name}: before {gap.before:.4g}, after {gap.after:.4g}, floor {gap.floor:.4g} {UNIT[name]}{closed}"


def where_words(where: Where, limits: ReportSettings) -> str:
    """The coordinate of a law, and those in which another removes as much.

    Args:
        where: where the gap lies.
        limits: what counts as much.

    Returns:
        The coordinates in words.
    """
    alike = [
        name
        for name, share in where.shares.items()
        if name != where.coordinate and abs(share - where.share) < limits.as_much < where.share
    ]
    name, *others = (one.replace("_", " ") for one in (where.coordinate, *alike))
    return name + (f" (as one in {', '.join(others)})" if others else "")


def left_words(share: float, where: Where | None, windows: Sequence[Window], limits: ReportSettings) -> str:
    """What the named effects leave, in words.

    Args:
        share: share of the squared excess on the held-out runs that stays [1].
        where: where it lies, None where that is not known.
        windows: seconds in which what is left arises, the one with most first.
        limits: what counts as much.

    Returns:
        The words, without an end.
    """
    said = f"{in_two_digits(100 * share)} % of the excess squared error"
    if where is not None:
        said += f"; nearest to it comes a law in {where_words(where, limits)}, which removes {100 * where.share:.0f} % of that"
    if windows:
        log, begin, end, most = windows[0]
        said += f"; it is largest from {begin:.1f} to {end:.1f} s of {log}, where {100 * most:.0f} % of it lies"
    return said


def why_not(
    leaves: float | None, named: tuple[str, ...], after: float, unit: str, *, more_evidence: bool = False
) -> str:
    """Why a candidate is not what is named, as one sentence.

    Args:
        leaves: RMS error of the headline signal with the candidate added [SI], None where it was not worked out.
        named: what is named, or what comes nearest.
        after: RMS error with that [SI].
        unit: the signal's unit.
        more_evidence: whether the fitted runs alone have more evidence for the candidate.

    Returns:
        The sentence.
    """
    best = " + ".join(named) or "the rig as it is"
    if leaves is None:
        return "It was not judged on held-out runs." if more_evidence else f"The training runs speak more for {best}."
    if leaves <= after and more_evidence:
        return (
            f"It leaves {leaves:.3g} {unit} of the held-out runs, where {best} leaves {after:.3g}, and the fitted runs alone speak more for it; "
            "what is named has to stand other tests, too."
        )
    if leaves <= after:
        return f"It leaves {leaves:.3g} {unit} of the held-out runs, where {best} leaves {after:.3g}, but the training runs speak more for that."
    if after == 0.0:
        return f"It leaves {leaves:.3g} {unit} on held-out runs, and {best} leaves nothing."
    times = in_two_digits(leaves / after)
    beside = f"about as much as {best}" if times == "1" else f"{times} times what {best} leaves"
    return f"It leaves {leaves:.3g} {unit} on held-out runs, {beside}."


def evidence_elsewhere(first: tuple[str, ...]) -> str:
    """That another candidate than what is claimed has the most evidence, as one sentence.

    Args:
        first: the names of the candidate with the most evidence.

    Returns:
        The sentence.
    """
    leader = " + ".join(first) or "the rig as it is"
    return f"by the evidence of the fitted runs alone {leader} would lead; what is named has to stand other tests, too"


def not_compared(untried: Sequence[str], limits: ReportSettings) -> str:
    """Which candidates an unfinished search has not compared.

    Args:
        untried: their names.
        limits: how many are named; of the rest only the number is told.

    Returns:
        The words.
    """
    if not untried:
        return "every candidate was compared by then"
    rest = len(untried) - limits.untried
    if rest <= 1:  # one more name is no longer than its number
        return f"not compared were {', '.join(untried)}"
    return f"not compared were {', '.join(untried[: limits.untried])} and {rest} more (`untried` in diagnosis.json)"


def numbers_of(rig: Rig, rung: Rung) -> list[str]:
    """The numbers of what a step of the waterfall names.

    Args:
        rig: the rig, as its logs drive it.
        rung: the step.

    Returns:
        One line for each effect or wrong number.
    """
    lines: dict[str, list[str]] = {}
    for number, (value, error) in rung.own.items():
        effect, _, name = number.rpartition(".")
        head, symbol = (f"{effect}: ", name) if effect in BY_NAME else ("", number)
        unit = f" {unit_in_rig(rig, number)}".rstrip()
        told = f" ± {error:.2g}{unit}" if isfinite(error) else f"{unit} ({without_error(number, value)})"
        lines.setdefault(head or number, []).append(f"{symbol} = {value:.4g}{told}")
    return [(head if head.endswith(": ") else "") + ", ".join(numbers) for head, numbers in lines.items()]


def without_error(number: str, value: float) -> str:
    """Why an estimate of what was added has no standard error.

    Args:
        number: its name, that of its effect before the last dot.
        value: the estimate [SI].

    Returns:
        The words: it sits at an end of the range in which it may lie, or the logs do not tell it.
    """
    effect, _, name = number.rpartition(".")
    low, high = parameters(BY_NAME[effect])[name].bounds if effect in BY_NAME else (-inf, inf)
    if value in (low, high):
        return f"the {'least' if value == low else 'most'} that it may be"
    return "not told by these logs"


def moved(first: Rung, last: Rung, limits: ReportSettings) -> list[str]:
    """The rig's numbers that move as the effects are added, beyond chance or far.

    Args:
        first: the rig as it is.
        last: the last step of the waterfall.
        limits: what counts as far and as sure.

    Returns:
        One line for each number.
    """
    lines = []
    for name, (sigmas, percent) in last.drift.items():
        (before, _), (after, error) = first.numbers[name], last.numbers[name]
        far = not abs(percent) <= limits.far_percent and abs(after - before) > limits.sure * error
        if abs(sigmas) > limits.sure or far:
            way = f"{percent:+.1f} %" if isfinite(percent) else f"{after - before:+.3g}"
            chance = f" ({sigmas:+.1f} sigma)" if isfinite(sigmas) else ""
            lines.append(f"{name} moves by {way}{chance} when the effects are added")
    return lines
