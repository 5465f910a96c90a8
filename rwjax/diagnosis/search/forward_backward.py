"""Which: the smallest set of effects that explains the training logs, and every other set that does so as well.

Forward: the candidate with the most evidence is added while it is needed. Backward: a name that is not needed is
dropped again. Then every member is exchanged for every other candidate: a set whose evidence comes close, or that ties
where nothing reaches the noise, cannot be told apart from the best one on these logs; nor can what is declared to be the
same thing for the kind of rig.
"""

from dataclasses import dataclass

import numpy as np

from rwjax.diagnosis.hypothesis import (
    Explanation,
    beside,
    brings_level,
    candidates,
    free_names,
    levels_beside,
    models_dry,
    on_one_axis,
)
from rwjax.diagnosis.information_criterion import effective_samples, log_evidence, residuals, sums
from rwjax.diagnosis.model_fits import BEHIND, Refits
from rwjax.diagnosis.settings import (
    CLOSE,
    CLOSE_ABOVE,
    FAR_FROM_NOISE,
    HOPEFUL,
    HOPELESS,
    MOST_NAMES,
    NEEDED,
    NOTHING_LEFT,
    NOTHING_NAMED,
    TIE,
    TRIFLE,
    WORTH,
    WORTH_BESIDES,
)
from rwjax.effects import plain
from rwjax.fitting.multiple_shooting import Fit
from rwjax.kinds import HALVES, on_half

LEADING, CLOSE_COST = 3, 1.5
"""Explanations at most from which their special cases are fitted, and their cost against the least."""
SEARCHED = (3, 1, 1)
"""Explanations that a race left ahead, beside so many names, and that are searched from all of their places where none of
them suffices."""
MANY = 5
"""Places from which an explanation may begin that count as many."""
EXACT = (6, 3, 3)
"""The same that are fitted on by exact derivatives where none of them suffices then."""
AT_A_TIME = 2
"""Of these, before it is seen whether one suffices: the same on every machine, on which the answer must not depend."""
EXCHANGES = 3
"""Times at most that a choice gives way to a rival with more evidence."""
AGAIN = 6
"""Rivals of a choice, those that leave least, that begin once more from its estimates unless they are far behind; not what contains
it, which has begun there if it left more."""
RIVALS = 3
"""Rivals of a choice, those that leave least, that are fitted on by exact derivatives before they are judged, unless they are far behind."""


@dataclass(frozen=True)
class Choice:
    """`best` explanation; `alternatives` that cannot be told apart from it, `same` of them on no logs of this kind of
    rig; `evidence` of everything that was tried, relative to the rig as it is; `ranking` single names with their share
    of the evidence."""

    best: Explanation
    alternatives: tuple[Explanation, ...]
    same: tuple[Explanation, ...]
    evidence: dict[Explanation, float]
    ranking: tuple[tuple[Explanation, float], ...]


class Search:
    """Compares explanations by their fits to the training logs."""

    def __init__(self, refits: Refits) -> None:
        self.refits = refits
        self.rig = refits.rig
        self.names = candidates(refits.rig)
        self.squares: dict[Explanation, tuple[Fit, dict[str, float]]] = {}
        self.count: dict[str, float] = {}

    def _seen(self, explanation: Explanation) -> dict[str, float]:
        fitted = self.refits.known(explanation)
        if explanation not in self.squares or self.squares[explanation][0] is not fitted:
            self.squares[explanation] = fitted, sums(residuals(fitted, self.refits.train))
            batch = fitted.problem.batch
            share = np.where(batch.weight > 0.0, batch.share, 0.0).sum(axis=(0, 1, 2))
            self.count = dict(zip(fitted.problem.structure.outputs, share, strict=True))
        return self.squares[explanation][1]

    def _numbers(self, explanation: Explanation) -> tuple[int, int]:
        """How many numbers of its own an explanation has, and how many of its effects' forms."""
        own = free_names(self.rig, explanation)[len(self.rig.free) :]
        form = sum(plain(name) is not None for name in own)
        return len(own) - form, form

    def evidence(self, explanation: Explanation, effective: dict[str, float]) -> float:
        """Log evidence of an explanation for given effective samples, and of what the rig file says besides."""
        fitted = self.refits.known(explanation)
        against, _ = fitted.problem.against_prior(fitted.theta)
        return log_evidence(self._seen(explanation), *self._numbers(explanation), effective) - against

    def effective(self, explanation: Explanation) -> dict[str, float]:
        """Effective samples of an explanation's residual."""
        return effective_samples(residuals(self.refits.known(explanation), self.refits.train))

    def excess(self, explanation: Explanation) -> float:
        """Mean square of the residual above the noise, in units of the noise, summed over outputs."""
        squares = self._seen(explanation)
        return sum(max(squares[name] / self.count[name] - 1.0, 0.0) for name in squares)

    def closed(self, explanation: Explanation) -> float:
        """Share of the rig's own error above the noise, on the training logs, that an explanation removes, of the output where
        it removes most."""
        whole, left = self._seen(Explanation()), self._seen(explanation)
        error = [[np.sqrt(max(s[y] / self.count[y], 1.0)) for s in (whole, left)] for y in whole]
        shares = [(a - b) / (a - 1.0) if np.isfinite(a) else float(np.isfinite(b)) for a, b in error if a > 1.0]
        return max(shares, default=1.0)

    def gain(self, larger: Explanation, smaller: Explanation) -> float:
        """Evidence of the larger explanation over the smaller, counted on the better one's residual."""
        effective = self.effective(larger)
        return self.evidence(larger, effective) - self.evidence(smaller, effective)

    def worthwhile(self, larger: Explanation, smaller: Explanation) -> bool:
        """Whether the larger explanation is needed beside the smaller one."""
        removed = self.excess(smaller) - self.excess(larger)
        worth = WORTH_BESIDES if smaller.names else WORTH
        return bool(self.gain(larger, smaller) > NEEDED and removed > worth * self.excess(smaller))

    def _extensions(self, explanation: Explanation) -> list[Explanation]:
        found = []
        for name in self.names:
            if name not in explanation.names and not (
                on_one_axis(name) == "axis.coulomb" and {*explanation.names} & levels_beside(name)
            ):
                rest = explanation.without(beside(name, "axis.coulomb")) if brings_level(name) else explanation
                found.append(rest.plus(name))
        return found

    def _fit(self, explanations: list[Explanation], parent: Explanation) -> None:
        """Fits all from a parent; then the parent and special cases of what leads from there, and what leaves more than a
        special case of it from that one, unless that is far behind."""
        tried = self.refits.race(explanations, parent)
        least = min((f.cost for f in tried.values()), default=0.0)
        leading = sorted((e for e in tried if tried[e].cost <= CLOSE_COST * least), key=lambda e: tried[e].cost)
        for e in leading[:LEADING]:
            self.refits.race([o for o in (parent, *explanations) if e.contains(o)], e)
        best = min((parent, *tried), key=lambda e: self.refits.known(e).cost)
        for e in tried:
            special = [o for o in tried if e.contains(o) and self.refits.known(o).cost < self.refits.known(e).cost]
            special = [o for o in special if not self._far_behind(o, best)]
            if special:
                self.refits.race([e], min(special, key=lambda o: self.refits.known(o).cost))

    def _leader(self, explanations: list[Explanation]) -> Explanation:
        """The explanation with the most evidence, or a special case of it beside which it is not needed."""
        effective = self.effective(min(explanations, key=lambda e: self.refits.known(e).cost))
        best = max(explanations, key=lambda e: self.evidence(e, effective))
        simpler = [e for e in explanations if best.contains(e) and self.gain(best, e) <= NEEDED]
        return max(simpler, key=lambda e: self.evidence(e, effective), default=best)

    def _far_behind(self, explanation: Explanation, best: Explanation) -> bool:
        """Whether an explanation leaves so much more than one that reaches the noise that no further start is tried."""
        known = self.refits.known
        return bool(self.excess(best) <= NOTHING_LEFT and known(explanation).cost > BEHIND * known(best).cost)

    def _ahead(self, explanations: list[Explanation]) -> list[Explanation]:
        """Explanations, those that leave least first."""
        return sorted(explanations, key=lambda e: self.refits.known(e).cost)

    def _forward(self, explanation: Explanation) -> Explanation:
        enough = max(NOTHING_LEFT, TRIFLE * self.excess(explanation))
        while len(explanation.names) < MOST_NAMES and self.excess(explanation) > enough:
            if self.closed(explanation) < HOPEFUL[len(explanation.names)]:
                break
            tried = self._extensions(explanation)
            if not tried:
                break
            self._fit(tried, explanation)
            searched = self._ahead(tried)[: SEARCHED[len(explanation.names)]]
            for e in searched:
                if self.excess(self._leader(tried)) > enough:
                    self.refits.search(e, explanation)
            ahead = self._ahead(tried)[: EXACT[len(explanation.names)]]
            for k in range(0, len(ahead), AT_A_TIME):
                if self.excess(self._leader(tried)) > enough:
                    self.refits.exactly(ahead[k : k + AT_A_TIME])
            if not explanation.names:
                self._last_resort(tried, searched, enough)
            best = self._leader(tried)
            if not self.worthwhile(best, explanation):
                break
            explanation = best
        return explanation

    def _last_resort(self, explanations: list[Explanation], searched: list[Explanation], enough: float) -> None:
        """Single names that may begin at many places and were not searched so far, each searched while nothing suffices: between
        the places lie hills, over which no few steps show the way."""
        many = [e for e in self._ahead(explanations) if e not in searched and self.refits.places(e) >= MANY]
        for e in many:
            if self.excess(self._leader(explanations)) > enough:
                self.refits.search(e, Explanation())
        if many and self.excess(self._leader(explanations)) > enough:
            self.refits.exactly(self._ahead(explanations)[:AT_A_TIME])

    def _backward(self, explanation: Explanation) -> Explanation:
        while len(explanation.names) > 1:
            smaller = [explanation.without(name) for name in explanation.names]
            self._fit(smaller, explanation)
            effective = self.effective(explanation)
            best = max(smaller, key=lambda e: self.evidence(e, effective))
            if self.worthwhile(explanation, best):
                break
            explanation = best
        return explanation

    def _exchanged(self, explanation: Explanation) -> list[Explanation]:
        """Sets with one member exchanged; a member that brings a Coulomb level, also for that level and another."""
        found = []
        for member in explanation.names:
            level = beside(member, "axis.coulomb")
            rest = explanation.without(member)
            bare = [rest.plus(name) for name in self.names if name not in explanation.names]
            found += bare
            if brings_level(member) and not models_dry(self.rig, member) and level in self.names:
                found += [e.plus(level) for e in bare if not {*e.names} & levels_beside(member)]
        return [e for e in dict.fromkeys(found) if e != explanation]

    def _rivals(self, best: Explanation) -> list[Explanation]:
        """Sets with one member exchanged, fitted, those that leave least and are not far behind by exact derivatives like `best`
        itself; none where no name will stand."""
        if not best.names or (self.closed(best) < HOPELESS and self.excess(best) > NOTHING_NAMED):
            return []
        rivals = self._exchanged(best)
        self.refits.exactly([best])  # which may free the first states
        self._fit([e for e in rivals if e not in self.refits], best)
        near = [e for e in self._ahead(rivals) if not e.contains(best) and not self._far_behind(e, best)]
        self.refits.again(near[:AGAIN], best)
        self.refits.exactly([e for e in self._ahead(rivals)[:RIVALS] if not self._far_behind(e, best)])
        return rivals

    def _surpassing(self, best: Explanation, rivals: list[Explanation]) -> Explanation | None:
        """The rival with more evidence than `best`, of no more names."""
        effective = self.effective(best)
        able = [e for e in rivals if len(e.names) <= len(best.names)]
        first = max(able, key=lambda e: self.evidence(e, effective), default=best)
        return first if self.evidence(first, effective) > self.evidence(best, effective) + NEEDED else None

    def as_good(self, one: Explanation, other: Explanation) -> bool:
        """Whether `other` leaves hardly more than `one` where even `one` does not reach the noise."""
        a, b = self._seen(one), self._seen(other)
        incomplete = any(a[name] > FAR_FROM_NOISE * self.count[name] for name in a)
        return incomplete and all(b[name] < (1.0 + TIE) * a[name] for name in a)

    def _declared(self, best: Explanation) -> list[Explanation]:
        """Sets that are the same thing as `best` for this kind of rig, whatever the logs."""
        platform, names = self.rig.kind == "platform", {*best.names, *self.rig.effects}
        groups = [["axis.asymmetric_friction", "axis.bias_torque"]]
        if self.rig.kind == "two_axis":
            groups = [[on_half(name, k) for name in group] for group in groups for k in range(len(HALVES))]
        if platform and "drive.deadzone" not in names:
            groups[0].append("drive.bias")
        if platform:
            groups.append(["drive.delay", "sensor.delay"])
            if self._falls(best):
                groups.append(["drive.curvature", "drive.supply_sag"])
        for number in (n for n in best.numbers if on_one_axis(n) == "motor.resistance"):
            if self.refits.known(best).numbers()[number] > self.rig.numbers[number]:  # a source's lies in series
                groups.append([f"parameter.{number}", beside(number, "drive.supply_sag")])
        found = []
        for group in groups:
            same = [name for name in group if name in self.names]
            members = [name for name in best.names if name in same]
            if len(members) == 1:
                found += [e for name in same if (e := self._instead(best, members[0], name)) not in (best, None)]
        return found

    def _falls(self, best: Explanation) -> bool:
        """Whether a curved drive's gain falls with the command's size, most of all where that is large, as that of a sagging
        supply does: where no current is known, the command alone says how much it is loaded."""
        if "drive.curvature" not in best.names:
            return True
        c, p, u_1 = (self.refits.known(best).numbers()[f"drive.curvature.{name}"] for name in ("c", "p", "u_1"))
        bend = np.log1p(abs(c) * u_1) - np.log1p(0.5 * abs(c) * u_1)  # from half the largest command to all of it
        return bool(c < 0.0 and bend > abs(p) * np.log(2.0))

    def _instead(self, best: Explanation, member: str, name: str) -> Explanation | None:
        """`best` with a name in the place of a member; None where without dry friction the one is not the other."""
        other, level = best.without(member).plus(name), beside(member, "axis.coulomb")
        if models_dry(self.rig, member):
            return other
        if brings_level(member):
            return other if brings_level(name) else other.plus(level)
        if brings_level(name):
            return other.without(level) if level in best.names else None
        return other

    def nothing(self) -> Choice:
        """The rig as it is, without a search."""
        nothing = Explanation()
        return Choice(nothing, (), (), {nothing: 0.0}, ((nothing, 1.0),))

    def run(self) -> Choice:
        """The search from the rig as it is."""
        nothing = Explanation()
        self.refits(nothing)
        best = self._backward(self._forward(nothing))
        rivals = self._rivals(best)
        for _ in range(EXCHANGES):
            if (better := self._surpassing(best, rivals)) is None:
                break
            best = self._backward(better)
            rivals = self._rivals(best)
        effective = self.effective(best)
        reference = self.evidence(best, effective)
        close = [
            e
            for e in rivals
            if self.evidence(e, effective) > reference - (CLOSE_ABOVE if e.contains(best) else CLOSE)
            or (self.as_good(best, e) and not e.contains(best))
        ]
        alternatives = [e for e in close if not any(e.contains(other) for other in close)]
        alternatives.sort(key=lambda e: -self.evidence(e, effective))
        same = self._declared(best)
        alternatives += [e for e in same if e not in alternatives]
        everything = [e for e in self.squares]
        base = self.evidence(nothing, effective)
        evidence = {e: self.evidence(e, effective) - base for e in everything}
        return Choice(best, tuple(alternatives), tuple(same), evidence, self._ranking(nothing, best, effective))

    def _ranking(
        self, nothing: Explanation, best: Explanation, effective: dict[str, float]
    ) -> tuple[tuple[Explanation, float], ...]:
        """Shares of the evidence among the rig as it is, the single names and the best set."""
        field = list(dict.fromkeys([*self._extensions(nothing), best, nothing]))
        field = [e for e in field if e in self.refits or not e.names]
        values = np.array([self.evidence(e, effective) for e in field])
        share = np.exp(values - values.max())
        share /= share.sum()
        order = np.argsort(-values, kind="stable")
        return tuple((field[k], float(share[k])) for k in order)
