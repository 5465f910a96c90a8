"""The diagnosis of the sim-to-real gap, step by step: floor, which, how far, verdict, where, next experiment."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from rwjax.diagnosis.asked import Asked, asked
from rwjax.diagnosis.budget import Budget, Stopped
from rwjax.diagnosis.corrected_rig import corrected_rig
from rwjax.diagnosis.estimates import estimates
from rwjax.diagnosis.exact_fits import polish
from rwjax.diagnosis.further import Further, may_be_claimed
from rwjax.diagnosis.gap import Gap, HeldOut, gap, headline
from rwjax.diagnosis.headway import Headway
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis, coordinate_of, shown_by, spoken
from rwjax.diagnosis.judged import Judged, errors_of_the_rig
from rwjax.diagnosis.layout import Layout, brief, laid_out
from rwjax.diagnosis.localise.left_torque import LeftTorque, left_torque
from rwjax.diagnosis.localise.where import Missing, Where, locate, missing_torques, tells_torque
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.next_experiment import Proposal, Rival, propose
from rwjax.diagnosis.partial import further_laws
from rwjax.diagnosis.remarks import remarks
from rwjax.diagnosis.result import Diagnosis, Left, Ranked
from rwjax.diagnosis.search.choice import Choice
from rwjax.diagnosis.search.forward_backward import ForwardBackward
from rwjax.diagnosis.search.so_far import so_far
from rwjax.diagnosis.search.strategy import Strategy
from rwjax.diagnosis.search.successive_halving import fitted
from rwjax.diagnosis.settings import Settings
from rwjax.diagnosis.uninformative import DROWNED, diverged_numbers, drowned, part_of, why_uninformative
from rwjax.diagnosis.verdict import (
    CLAIMS,
    Verdict,
    closes_in_part,
    judge,
    left_elsewhere,
    stands_out,
)
from rwjax.diagnosis.waterfall import Rung
from rwjax.diagnosis.words import UNIT, evidence_elsewhere, not_compared, sure_of, went_no_further, why_not
from rwjax.diagnosis.worst_windows import worst_windows
from rwjax.errors import refuses_other_types
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.processes import Team
from rwjax.fitting.ran_away import runaway_words, without_runaways
from rwjax.fitting.segments import with_segments
from rwjax.fitting.threads import SINGLE_THREADED_BLAS
from rwjax.fitting.uncertainty import Uncertainty, uncertainty
from rwjax.kinds import TWO_AXIS
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.rig.model import Rig


@dataclass(frozen=True)
class _Outcome:
    """How far the gap closes, and the verdict."""

    verdict: Verdict
    named: Hypothesis  # what is reported, its most important name first
    after: HeldOut
    gaps: dict[str, Gap]
    alternatives: tuple[Hypothesis, ...]  # what may stand in the place of what is claimed
    equivalents: tuple[Hypothesis, ...]  # those of them that no logs can tell apart from it
    uninformative: str | None  # why the logs tell nothing, where they do not
    diverged: tuple[str, ...]  # numbers that ran away from the rig file


@refuses_other_types
@SINGLE_THREADED_BLAS
def diagnose(  # noqa: PLR0913 (one for each choice of the user)
    rig: Rig,
    logs: Sequence[Log],
    *,
    strategy: Strategy | None = None,
    settings: Settings | None = None,
    segments: float | None = None,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
    budget: float | Budget | None = None,
    team: Team | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Where the gap between a rig and its logs lies, which effect causes it, and how far it closes.

    Structure and numbers are chosen on the training logs alone where logs are marked for validation or a single log is split. With two
    or more unmarked logs, the set of names is chosen on all of them, and every gap is measured on a run that its numbers were not
    fitted to.

    Args:
        rig: the rig as it is.
        logs: its logs, at least one.
        strategy: how hypotheses are searched, `ForwardBackward()` where none is given.
        settings: limits of the diagnosis, `Settings()` where none are given.
        segments: length of the segments [s] in which free runs follow the logs, infinite for whole runs; chosen by the rig
            and the logs where none is given.
        only: names of the only candidates to compare, all of them where none are given.
        without: names of candidates to leave out.
        budget: time [s] after which the search ends and the answer so far is given, or a `Budget`, which can also be stopped; no
            limit where none is given. The rig as it is is fitted and judged in any case.
        team: processes that share the search, this one alone where none are given.
        progress: hears of every step, on any thread.

    Returns:
        The diagnosis.

    Raises:
        LogError: no log may be fitted.
        InputError: a name of `only` or `without` is none, the budget is not positive, or an argument is of another type.
    """
    rig, logs = driven(rig, logs)
    among = asked(rig, only, without)
    headway = Headway(
        budget if isinstance(budget, Budget) else Budget(math.inf if budget is None else budget), progress
    )
    logs, told = brief(rig, logs, (settings or Settings()).length)
    layout = laid_out(rig, with_segments(rig, logs, segments))
    fits = ModelFits.of(rig, layout.logs, layout.train, settings, headway, team)
    before, signal, choice = _which(fits, layout, strategy or ForwardBackward(), among)
    found = _answer(Judged(fits, layout, before, signal), choice, among)
    return replace(found, remarks=(*told, *found.remarks))


def _answer(judged: Judged, choice: Choice, among: Asked) -> Diagnosis:
    """What is told of a choice."""
    further = may_be_claimed(judged, choice, shown_by(among.names, judged.fits.outputs))
    judged, choice = further.judged, further.choice
    fits, layout = judged.fits, judged.layout
    rig, before, signal = fits.rig, judged.before, judged.signal
    outcome = _how_far(further)
    rivals = _rivals(outcome, fits.settings.report.most_rivals)
    first, ranking = judged.rung(NOTHING), _ranking(further, outcome)
    found = fits(outcome.named)
    spread = uncertainty(found)
    proposed, where = _next(fits, outcome, further, among), _where(fits, choice, outcome)
    steps = _growing(outcome.named) if further.answers else [outcome.named][: len(outcome.named.names)]
    waterfall, alternatives_waterfall = _waterfalls(judged, first, steps, rivals)
    shown, limits = [found, *(fits(e) for e in rivals[1:])], fits.settings.remarks
    corrected, away = _corrected(rig, outcome.named, found, spread)
    told = remarks(rig, layout.runs, layout.train_runs, fits(NOTHING), shown, spread, outcome.diverged, limits)
    return Diagnosis(
        rig=rig,
        logs=layout.logs,
        verdict=outcome.verdict,
        complete=further.complete,
        untried=choice.untried,
        restricted=among.restricted,
        uninformative=outcome.uninformative,
        effects=outcome.named.names,
        alternatives=tuple(e.names for e in outcome.alternatives),
        ranking=ranking,
        where=where,
        windows=worst_windows(_told(where, fits(NOTHING)), before, layout.logs, signal, fits.settings.report.windows),
        left=_left(judged, outcome) if outcome.verdict == "partial" else None,
        left_torque=_left_torque(fits, outcome, where),
        signal=signal,
        gaps=outcome.gaps,
        held_out=layout.rule,
        next_experiment=proposed.sentence,
        proposal=proposed.plan,
        waterfall=waterfall,
        alternatives_waterfall=alternatives_waterfall,
        refused=further.refused if outcome.verdict in ("partial", "unknown") else {},
        remarks=(*told, *layout.split.said(), *away, *among.said(), *_of_the_answer(further, outcome)),
        split=layout.split,
        corrected=corrected,
        before=before,
        after=outcome.after,
        settings=fits.settings,
        estimates=estimates(found, spread, corrected),
    )


def _corrected(rig: Rig, named: Hypothesis, found: Fit, spread: Uncertainty) -> tuple[Rig, list[str]]:
    """The corrected rig, in which numbers that ran away are those of the rig as it is, and a sentence on each of them."""
    corrected = corrected_rig(rig, named, found, spread)
    return without_runaways(rig, corrected), runaway_words(rig, corrected)


def _of_the_answer(further: Further, outcome: _Outcome) -> list[str]:
    """Remarks on how the search ended, and on what is claimed."""
    return [*_ended(further, outcome), *_evidence(further.choice, outcome), *_wrong(outcome)]


def _ended(further: Further, outcome: _Outcome) -> list[str]:
    """The remark on a search that did not come to its end."""
    choice, headway = further.choice, further.judged.fits.headway
    if further.complete:
        return []
    budget, led = headway.budget, f"; best until then was {headway.best}" if headway.best else ""
    why = "an interruption" if budget.stopped else f"the budget of {budget.seconds:g} s"
    if outcome.verdict in CLAIMS:
        return [went_no_further(outcome.named.names, why, led)]
    if choice.complete:
        names = " and ".join(map(spoken, choice.best.names)) or "the rig as it is"
        return [
            f"{why} ended the search before it was told whether {names} may be claimed, and nothing is; every candidate was compared by then{led}"
        ]
    untried = not_compared(choice.untried, further.judged.fits.settings.report)
    return [f"{why} ended the search, and nothing is claimed; {untried}{led}"]


def _evidence(choice: Choice, outcome: _Outcome) -> list[str]:
    """The remark on a claim beside which another candidate has more evidence of the fitted runs."""
    if outcome.verdict not in CLAIMS or not choice.ranking:
        return []
    if (first := choice.ranking[0][0]) in (outcome.named, *outcome.alternatives):
        return []
    return [evidence_elsewhere(first.names)]


def _wrong(outcome: _Outcome) -> list[str]:
    """The remark on each number of the rig file that a claim, or what stands beside it, says is wrong."""
    claimed = [outcome.named, *outcome.alternatives] if outcome.verdict in CLAIMS else []
    return [sure_of(f"parameter.{number}") for number in dict.fromkeys(n for e in claimed for n in e.numbers)]


def _which(fits: ModelFits, layout: Layout, strategy: Strategy, among: Asked) -> tuple[HeldOut, str, Choice]:
    """Floor and which: errors of the rig as it is, the headline signal, and the choice where its gap stands out."""
    settings = fits.settings
    fits(NOTHING)
    before = errors_of_the_rig(fits, layout)
    bare = {name: gap(before, before, name, settings.gap) for name in before.square}
    signal = headline(bare)
    if not stands_out(bare[signal], settings.verdict):
        return before, signal, Choice.nothing()
    fits.start_from_first_readings()
    fits.headway.signal = signal
    choice = _searched(fits, strategy, shown_by(among.names, fits.outputs))
    before = errors_of_the_rig(fits, layout)  # the search may have found better numbers
    return before, signal, choice


def _searched(fits: ModelFits, strategy: Strategy, names: Sequence[str]) -> Choice:
    """The choice with its fit to the last digit, or what leads where the budget ends first."""
    choice = None
    try:
        with fits.headway.budget.searching():
            choice = strategy.choose(fits, names)
            if choice.best.names:
                fitted(fits, choice.best)
                polish(fits, choice.best)
    except Stopped:
        choice = so_far(fits, names) if choice is None else replace(choice, complete=False)
        if choice.best in fits:
            fits.as_it_stands(choice.best)
    return choice


def _by_importance(best: Hypothesis, judged: Judged) -> Hypothesis:
    """The same set, the name whose removal widens the held-out gap most first."""
    if len(best.names) < 2:
        return best
    return Hypothesis(tuple(sorted(best.names, key=lambda name: -judged.rms(best.without(name)))))


def _how_far(further: Further) -> _Outcome:
    """How far the choice closes the gap on held-out logs, and the verdict."""
    judged, choice = further.judged, further.choice
    fits, settings = judged.fits, judged.fits.settings
    best = _by_importance(choice.best, judged) if further.answers else choice.best
    gaps = judged.gaps(judged(best))
    headline_gap = gaps[judged.signal]
    closes = closes_in_part(headline_gap, settings, followed=further.followed)
    verdict, named = judge(choice, gaps, judged.signal, settings.verdict), best
    if not further.answers or (further.refused and not further.claim):
        verdict = "unknown"
    elif further.claim and (verdict == "unknown" or further.ended):  # of a search that was ended no more than a part
        verdict = "partial" if closes else "unknown"
    elif verdict == "effect" and further.claim and further.claim.alternatives:
        verdict = "ambiguous"
        choice = replace(choice, alternatives=further.claim.alternatives, equivalents=further.claim.equivalents)
    diverged: tuple[str, ...] = ()
    uninformative = None
    if verdict == "none":
        diverged = diverged_numbers(fits.rig, fits(NOTHING), settings.remarks)
        uninformative = why_uninformative(judged.layout.runs, diverged, settings.remarks) or _drowned(judged, best)
        verdict, named = "unknown" if uninformative else "none", NOTHING
    elif verdict == "unknown" and headline_gap.after >= headline_gap.before:
        named = NOTHING
    after = judged(named)
    beside = {"ambiguous": choice, "partial": further.claim}.get(verdict)
    alternatives, same = (beside.alternatives, beside.equivalents) if beside else ((), ())
    return _Outcome(verdict, named, after, judged.gaps(after), alternatives, same, uninformative, diverged)


def _drowned(judged: Judged, best: Hypothesis) -> str | None:
    """Why the held-out runs say nothing where their floors are larger than their motion."""
    held = judged(best)
    floors = {name: one.floor for name, one in judged.gaps(held).items()}
    logs = judged.layout.logs
    readings = {name: [logs[k].outputs[name] for k, e in held.error.items() if name in e] for name in floors}
    return DROWNED if drowned(floors, readings) else None


def _rivals(outcome: _Outcome, most: int) -> list[Hypothesis]:
    """Hypotheses shown beside one another, where they cannot be told apart."""
    if not outcome.alternatives:
        return []
    return list(dict.fromkeys([outcome.named, *outcome.alternatives]))[:most]


def _left(judged: Judged, outcome: _Outcome) -> Left:
    """What the claimed names leave of the output that stays, and where: in the coordinate of the further name that removes most of it."""
    fits, named = judged.fits, outcome.named
    signal = left_elsewhere(outcome.gaps, judged.signal, fits.settings.verdict) or judged.signal
    gap = outcome.gaps[signal]
    share = max(gap.after**2 - gap.floor**2, 0.0) / (gap.before**2 - gap.floor**2)
    shares = further_laws(fits, named)
    where = locate(fits(named), fits.train, shares, None, fits.settings.localisation, deep=False)
    most = fits.settings.report.windows
    windows = worst_windows(_told(where, fits(named)), outcome.after, judged.layout.logs, signal, most)
    return Left(share, where, windows)


def _told(where: Where | None, found: Fit) -> tuple[Missing, ...]:
    """The missing torque of every log, where the motion of a fitted rig tells it."""
    return where.missing if where is not None and tells_torque(found.problem.structure) else ()


def _left_torque(fits: ModelFits, outcome: _Outcome, where: Where | None) -> LeftTorque | None:
    """What the claimed names leave as coloured noise, or the rig as it is where none is claimed but something is missing."""
    limits = fits.settings.localisation
    if outcome.verdict == "none":
        return None
    if outcome.verdict not in CLAIMS:
        return left_torque(fits(NOTHING), where.missing if where is not None else (), limits)
    named = fits(outcome.named)
    return left_torque(named, missing_torques(named, fits.train, limits), limits)


def _growing(hypothesis: Hypothesis) -> list[Hypothesis]:
    """A hypothesis's first name, its first two, and so on."""
    return [Hypothesis(hypothesis.names[: k + 1]) for k in range(len(hypothesis.names))]


def _waterfalls(
    judged: Judged, first: Rung, steps: Sequence[Hypothesis], rivals: Sequence[Hypothesis]
) -> tuple[tuple[Rung, ...], tuple[Rung, ...]]:
    """The rig as it is and the named effects one after the other, and the steps of the rivals that are not among them."""
    others = [e for e in dict.fromkeys(e for rival in rivals for e in _growing(rival)) if e not in steps]
    named_steps = (first, *(judged.rung(step, first.numbers) for step in steps))
    return named_steps, tuple(judged.rung(other, first.numbers) for other in others)


def _ranking(further: Further, outcome: _Outcome) -> tuple[Ranked, ...]:
    """The ranking, of the first ones with their held-out gap and with why they are not what is named."""
    judged, choice = further.judged, further.choice
    ranked, unit, most = [], UNIT[judged.signal], judged.fits.settings.report.ranked
    beside, after = {outcome.named, *outcome.alternatives}, judged.rms(outcome.named)
    if further.answers:
        judged.prepare([e for e, _ in choice.ranking[:most]])
    for k, (e, probability) in enumerate(choice.ranking):
        first = k < most
        leaves = judged.rms(e) if first and (further.answers or e == choice.best) else None
        told = first and e not in beside and outcome.verdict != "none"
        likelier = any(other == outcome.named for other, _ in choice.ranking[k + 1 :])
        why = why_not(leaves, outcome.named.names, after, unit, more_evidence=likelier) if told else None
        ranked.append(Ranked(" + ".join(e.names) or "none", probability, leaves, why))
    return tuple(ranked)


def _where(fits: ModelFits, choice: Choice, outcome: _Outcome) -> Where | None:
    """Where the gap lies: of the first named effect's coordinate, else of the coordinate whose laws remove most."""
    named = outcome.named.names and outcome.verdict != "unknown"
    coordinate = coordinate_of(outcome.named.names[0]) if named else None
    shares, limits = _shares(fits, choice), fits.settings.localisation
    return locate(fits(NOTHING), fits.train, shares, coordinate, limits, deep=outcome.verdict != "none")


def _shares(fits: ModelFits, choice: Choice) -> dict[str, float]:
    """Share of the excess that the best single law in each coordinate removes; the chosen set counts for its first."""
    comparison = ModelComparison(fits)
    whole = comparison.excess(NOTHING)
    found: dict[str, float] = {}
    for hypothesis in dict.fromkeys([*choice.criterion, choice.best]):
        if len(hypothesis.names) == 1 or hypothesis == choice.best:
            for name in hypothesis.names[:1]:
                share = 1.0 - comparison.excess(hypothesis) / whole if whole > 0.0 else 0.0
                coordinate = coordinate_of(name)
                found[coordinate] = max(found.get(coordinate, 0.0), share)
    return found


def _next(fits: ModelFits, outcome: _Outcome, further: Further, among: Asked) -> Proposal:
    """The next experiment that the outcome asks for."""
    if not further.complete:
        longer = "" if fits.headway.budget.stopped else "; a longer `--budget` lets it come there"
        return Proposal(f"none before the search has come to its end{longer}")
    if outcome.uninformative == DROWNED:
        return Proposal("runs that begin at rest, half a second before the command")
    if outcome.uninformative or further.held:
        return Proposal(f"runs in which {part_of(outcome.diverged or further.held)} turns")
    rivals = [e for e in dict.fromkeys([outcome.named, *outcome.alternatives]) if e not in outcome.equivalents]
    rivals, verdict = list(further.outside) or rivals, outcome.verdict
    if outcome.alternatives and len(rivals) < 2:
        return Proposal("none can tell them apart: for this kind of rig they are the same thing")
    if len(rivals) > 1 and fits.rig.kind in TWO_AXIS:
        rests = ", after rests of several lengths" if further.outside else ""
        return Proposal(
            f"one motor at a time, then both at once, with slow triangles, steps and coast-downs of each{rests}"
        )
    if len(rivals) > 1:
        two = [Rival(e.names, fits.problem_of(e), fits(e).theta) for e in rivals[:2]]
        remains = {name: g.after for name, g in outcome.gaps.items()}
        return propose(fits.rig.name, two, fits.train, remains, fits.settings.next_experiment)
    if verdict in ("unknown", "partial"):
        return Proposal(
            "repeat one of these runs three times, so that what never repeats can be told from what is missing"
        )
    if verdict == "effect":
        other = "explanation that was asked for" if among.restricted else "explanation"
        return Proposal(f"none needed: no other {other} comes close on these logs")
    return Proposal("none needed: the rig explains these logs down to their floor")
