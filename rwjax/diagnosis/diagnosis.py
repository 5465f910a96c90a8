"""The diagnosis of the sim-to-real gap: floor, where, which, how far, verdict, next experiment."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from rwjax.diagnosis.gap import Gap, Held, Split, gap, headline, held_out
from rwjax.diagnosis.hypothesis import Hypothesis, coordinate_of
from rwjax.diagnosis.localise.where import Where, locate
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.next_experiment import Proposal, Rival, propose
from rwjax.diagnosis.remarks import moves, ran_away, remarks
from rwjax.diagnosis.search.forward_backward import Choice, Search
from rwjax.diagnosis.verdict import Verdict, judge, stands_out
from rwjax.effects.library import BY_NAME, unit_of_number
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.uncertainty import Uncertainty, uncertainty
from rwjax.kinds import TWO_AXIS
from rwjax.logs.held_out import folds
from rwjax.logs.log import Log
from rwjax.planning.files import Plan
from rwjax.plant.from_rig import rig_with
from rwjax.rig.model import Rig

SCHEMA = "rwjax.diagnosis/1"
MOST_RIVALS = 4  # hypotheses shown beside each other where they cannot be told apart, the best one among them
LISTED = 3  # names whose held-out gap is worked out for the ranking, where a race brought them to their end


@dataclass(frozen=True)
class Rung:
    """One step of the waterfall: `names` so far, held-out RMS [SI] of the headline signal, the base numbers with their standard
    errors and their shift against the rig without effects, in its standard errors and in percent, and the numbers of
    what is named with theirs."""

    names: tuple[str, ...]
    rms: float
    numbers: dict[str, tuple[float, float]]
    drift: dict[str, tuple[float, float]]
    own: dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Ranked:
    """A candidate with its share of the evidence and, for the first few, the headline gap with it added."""

    effect: str
    probability: float
    gap_after: float | None


@dataclass(frozen=True)
class Diagnosis:
    """Everything that the report shows; `json` is what other programs read.

    `untold`: why the logs tell nothing, where they do not; `proposal`: the next experiment as a plan, where it is a command that can
    be played; `waterfall`: the rig as it is, then the named effects one after the other; `beside`: the same for the alternatives.
    """

    rig: Rig
    logs: tuple[Log, ...]
    verdict: Verdict
    untold: str | None
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    ranking: tuple[Ranked, ...]
    where: Where | None
    windows: tuple[tuple[str, float, float, float], ...]
    signal: str
    gaps: dict[str, Gap]
    held_out: str
    next_experiment: str
    proposal: Plan | None
    waterfall: tuple[Rung, ...]
    beside: tuple[Rung, ...]
    remarks: tuple[str, ...]
    corrected: Rig
    before: Held
    after: Held
    fitted: Fit = field(repr=False)
    spread: Uncertainty = field(repr=False)

    @property
    def subsystem(self) -> str | None:
        """Subsystem of the first effect, else that of the missing torque."""
        if self.effects:
            return self.effects[0].removeprefix("parameter.").split(".")[0]
        if self.verdict == "none" or self.where is None:
            return None
        if self.rig.kind == "two_axis":
            return "pitch" if self.where.coordinate.startswith("pitch") else "yaw"
        by_coordinate = {
            "voltage": "drive",
            "current": "motor",
            "wheel_rate": "wheel",
            "wheel_angle": "wheel",
        }
        return by_coordinate.get(self.where.coordinate, "wheel" if self.rig.kind == "wheel" else "axis")

    def json(self) -> dict:
        """`diagnosis.json` as plain objects."""

        def one(g: Gap) -> dict:
            return {
                "before": g.before,
                "after": g.after,
                "floor": g.floor,
                "closed": g.closed,
                "ci95": g.ci95,
            }

        where = None
        if self.where is not None and self.verdict != "none":
            where = {
                "subsystem": self.subsystem,
                "coordinate": self.where.coordinate,
                "interval": list(self.where.interval) if self.where.interval is not None else None,
                "share": self.where.share,
                "windows": [
                    {"log": log, "from_s": begin, "to_s": end, "share": share}
                    for log, begin, end, share in self.windows
                ],
                **self.where.json(),
            }
        return {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "untold": self.untold,
            "effects": list(self.effects),
            "alternatives": [list(names) for names in self.alternatives],
            "ranking": [
                {"effect": r.effect, "probability": r.probability, "gap_after": r.gap_after} for r in self.ranking
            ],
            "where": where,
            "gap": {
                "signal": self.signal,
                **one(self.gaps[self.signal]),
                "signals": {name: one(g) for name, g in self.gaps.items()},
            },
            "held_out": self.held_out,
            "next_experiment": self.next_experiment,
            "drift": [
                {
                    "effects": list(rung.names),
                    "gap": rung.rms,
                    "numbers": {
                        name: {
                            "value": value,
                            "standard_error": _plain(error),
                            "shift_sigmas": _plain(rung.drift[name][0]),
                            "shift_percent": _plain(rung.drift[name][1]),
                        }
                        for name, (value, error) in rung.numbers.items()
                    },
                    "effect_numbers": {
                        name: {"value": value, "standard_error": _plain(error), "unit": unit_of_number(name)}
                        for name, (value, error) in rung.own.items()
                    },
                }
                for rung in (*self.waterfall, *self.beside)
            ],
            "remarks": list(self.remarks),
        }


def _plain(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _laid_out(logs: Sequence[Log]) -> tuple[str, tuple[Log, ...], tuple[int, ...], tuple[Split, ...]]:
    """Name of the held-out rule, all logs or their parts, those to select on, and the folds by number."""
    rule, splits = folds(logs)
    every: list[Log] = []

    def number(log: Log) -> int:
        for k, other in enumerate(every):
            if other is log:
                return k
        every.append(log)
        return len(every) - 1

    numbered = tuple((tuple(number(g) for g in s.train), tuple(number(g) for g in s.test)) for s in splits)
    train = tuple(sorted({k for fitted, _ in numbered for k in fitted}))
    return rule, tuple(every), train, numbered


def _worst_windows(before: Held, logs: tuple[Log, ...], signal: str) -> tuple[tuple[str, float, float, float], ...]:
    """Seconds of the held-out logs that hold the most squared error."""
    total = float(np.sum(before.square[signal]))
    found: list[tuple[str, float, float, float]] = []
    if total == 0.0:
        return ()
    for k, by_output in before.error.items():
        if signal not in by_output:
            continue
        t = logs[k].time
        second = np.floor(t - t[0]).astype(int)
        square = np.nan_to_num(by_output[signal]) ** 2
        mass = np.bincount(second, weights=square) / total
        for s in np.argsort(-mass)[:5]:
            found.append((logs[k].name, float(t[0] + s), float(min(t[0] + s + 1.0, t[-1])), float(mass[s])))
    return tuple(sorted(found, key=lambda w: -w[3])[:5])


def _rung(fits: ModelFits, hypothesis: Hypothesis, rms: float, base: dict[str, tuple[float, float]] | None) -> Rung:
    fitted = fits(hypothesis)
    error, value = uncertainty(fitted).standard_error, fitted.numbers()
    numbers = {name: (value[name], error.get(name, np.inf)) for name in fits.rig.free}
    own = {name: (value[name], error[name]) for name in fitted.free if name not in numbers}
    base = numbers if base is None else base
    drift = {}
    for name, (old, old_error) in base.items():
        new, new_error = numbers[name]
        scale = float(np.hypot(old_error, new_error))
        drift[name] = (
            (new - old) / scale if np.isfinite(scale) and scale > 0.0 else np.nan,
            100.0 * (new - old) / abs(old) if old else np.nan,
        )
    return Rung(hypothesis.names, rms, numbers, drift, own)


def _by_importance(best: Hypothesis, rms: Callable[[Hypothesis], float]) -> Hypothesis:
    """The same set, the name whose removal widens the held-out gap most first."""
    if len(best.names) < 2:
        return best
    return Hypothesis(tuple(sorted(best.names, key=lambda name: -rms(best.without(name)))))


def _corrected(rig: Rig, fitted: Fit, hypothesis: Hypothesis, spread: Uncertainty) -> Rig:
    """The rig with what is named and with the estimates; a fit of it estimates the same numbers, but those of an effect that
    these logs do not tell."""
    kept = fitted.problem.structure._replace(
        effects=tuple(e for e in BY_NAME if e in (*rig.effects, *hypothesis.effects))
    )
    values = fitted.numbers()
    theta = np.array([values[name] for name in kept.names])
    errors = {name: error for name, error in spread.standard_error.items() if np.isfinite(error)}
    free = (*rig.free, *(name for name in errors if name in kept.names and name not in rig.free))
    return replace(rig_with(rig, kept, theta, errors), free=free)


def diagnose(rig: Rig, logs: Sequence[Log], progress: Callable[[str], None] = lambda text: None) -> Diagnosis:
    """Diagnosis of a rig from its logs. `progress` hears of every step.

    Structure and numbers are chosen on the training logs alone where logs are marked for validation or a single log is
    split; with two or more unmarked logs the set of names is chosen on all of them and every gap is measured on a run
    that its numbers were not fitted on. Raises `LogError` where no log may be fitted.
    """
    rule, every, train, numbered = _laid_out(logs)
    fits = ModelFits.of(rig, every, train, progress)
    nothing = Hypothesis()
    fits(nothing)
    before = held_out(fits, nothing, numbered, with_floor=True)
    bare = {name: gap(before, before, name) for name in before.square}
    signal = headline(bare)
    search = Search(fits)
    choice: Choice = search.nothing()
    if stands_out(bare[signal]):
        fits.start_from_first_readings()
        choice = search.run()
        if choice.best.names:
            fits.polish(choice.best)
        before = held_out(fits, nothing, numbered, with_floor=True)  # the search may have found better numbers
        bare = {name: gap(before, before, name) for name in before.square}

    @cache
    def held(hypothesis: Hypothesis) -> Held:
        return held_out(fits, hypothesis, numbered, with_floor=False) if hypothesis.names else before

    def rms(hypothesis: Hypothesis) -> float:
        return held(hypothesis).rms(signal)

    best = _by_importance(choice.best, rms)
    after = held(best)
    gaps = {name: gap(before, after, name) for name in before.square}
    verdict = judge(choice, gaps[signal])
    lost = ran_away(rig, fits(nothing)) if verdict == "none" else ()
    untold = _untold(every, lost) if verdict == "none" else None
    verdict = "unknown" if untold else verdict
    no_help = verdict == "unknown" and gaps[signal].after >= gaps[signal].before
    named = Hypothesis() if verdict == "none" or no_help or untold else best
    if not named.names:
        after, gaps = before, bare

    rivals = list(dict.fromkeys([best, *choice.alternatives]))[:MOST_RIVALS] if verdict == "ambiguous" else []
    first = _rung(fits, nothing, before.rms(signal), None)
    steps = [Hypothesis(named.names[: k + 1]) for k in range(len(named.names))]
    others = dict.fromkeys(Hypothesis(rival.names[: k + 1]) for rival in rivals for k in range(len(rival.names)))

    def rung(step: Hypothesis) -> Rung:
        return _rung(fits, step, rms(step), first.numbers)

    ranking = [
        Ranked(" + ".join(e.names) or "none", probability, rms(e) if k < LISTED and fits.ended(e) else None)
        for k, (e, probability) in enumerate(choice.ranking)
    ]
    fitted = fits(named)
    spread = uncertainty(fitted)
    coordinate = coordinate_of(named.names[0]) if named.names and verdict != "unknown" else None
    left = {name: g.after for name, g in gaps.items()}
    proposed = (
        Proposal(f"runs in which {_part(lost)} turns")
        if untold
        else _next(
            fits, verdict, [e for e in dict.fromkeys([best, *choice.alternatives]) if e not in choice.same], left
        )
    )
    return Diagnosis(
        rig=rig,
        logs=every,
        verdict=verdict,
        untold=untold,
        effects=named.names,
        alternatives=tuple(e.names for e in choice.alternatives) if verdict == "ambiguous" else (),
        ranking=tuple(ranking),
        where=locate(fits(nothing), train, _shares(search, choice), coordinate, deep=verdict != "none"),
        windows=_worst_windows(before, every, signal),
        signal=signal,
        gaps=gaps,
        held_out=rule,
        next_experiment=proposed.sentence,
        proposal=proposed.plan,
        waterfall=(first, *map(rung, steps)),
        beside=tuple(rung(other) for other in others if other not in steps),
        remarks=remarks(rig, every, train, fits(nothing), [fitted, *(fits(e) for e in rivals[1:])], spread, lost),
        corrected=_corrected(rig, fitted, named, spread),
        before=before,
        after=after,
        fitted=fitted,
        spread=spread,
    )


def _untold(logs: tuple[Log, ...], lost: tuple[str, ...]) -> str | None:
    """Why logs that a rig explains tell nothing of it; `lost`: its numbers that ran away."""
    if not any(moves(log) for log in logs):
        return "nothing moves in these logs"
    return f"{_part(lost)} hardly moves in these logs" if lost else None


def _part(lost: tuple[str, ...]) -> str:
    """The part of a rig that some of its numbers belong to, the rig where there are none."""
    return f"what {', '.join(lost)} belongs to" if lost else "the rig"


def _shares(search: Search, choice: Choice) -> dict[str, float]:
    """Share of the excess that the best single law in each coordinate removes; the chosen set counts for its first."""
    whole = search.excess(Hypothesis())
    found: dict[str, float] = {}
    for hypothesis in choice.evidence:
        if len(hypothesis.names) == 1 or hypothesis == choice.best:
            for name in hypothesis.names[:1]:
                share = 1.0 - search.excess(hypothesis) / whole if whole > 0.0 else 0.0
                coordinate = coordinate_of(name)
                found[coordinate] = max(found.get(coordinate, 0.0), share)
    return found


def _next(fits: ModelFits, verdict: Verdict, rivals: list[Hypothesis], left: dict[str, float]) -> Proposal:
    if verdict == "ambiguous" and len(rivals) < 2:
        return Proposal("none can tell them apart: for this kind of rig they are the same thing")
    if verdict == "ambiguous" and fits.rig.kind in TWO_AXIS:
        return Proposal("one motor at a time, then both at once, with slow triangles, steps and coast-downs of each")
    if verdict == "ambiguous":
        two = [Rival(e.names, fits.problem_of(e), fits(e).theta) for e in rivals[:2]]
        return propose(fits.rig.name, two, fits.train, left)
    if verdict == "unknown":
        return Proposal(
            "repeat one of these runs three times, so that what never repeats can be told from what is missing"
        )
    if verdict == "effect":
        return Proposal("none needed: no other explanation comes close on these logs")
    return Proposal("none needed: the rig explains these logs down to their floor")
