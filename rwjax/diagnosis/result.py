"""Diagnosis: what `diagnose` returns, what the report shows, and what `diagnosis.json` holds."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from rwjax.diagnosis.estimates import Estimates
from rwjax.diagnosis.gap import Gap, HeldOut
from rwjax.diagnosis.hypothesis import spoken
from rwjax.diagnosis.localise.left_torque import LeftTorque
from rwjax.diagnosis.localise.where import Where
from rwjax.diagnosis.settings import Settings
from rwjax.diagnosis.verdict import CLAIMS, Verdict, leaves_a_visible_part, left_elsewhere, stands_out
from rwjax.diagnosis.waterfall import Rung
from rwjax.diagnosis.words import (
    UNIT,
    doubted_sentence,
    explanations,
    gap_line,
    left_words,
    moved,
    numbers_of,
    several_sentence,
    unfinished_sentence,
    verdict_sentence,
    where_words,
)
from rwjax.diagnosis.worst_windows import Window
from rwjax.fitting.segments import segment_s
from rwjax.logs.coverage import Split
from rwjax.logs.log import Log
from rwjax.planning.files import Plan
from rwjax.rig.model import Rig
from rwjax.rig.number_unit import unit_in_rig

if TYPE_CHECKING:
    import polars as pl

SCHEMA = "rwjax.diagnosis/2"
"""The layout of `diagnosis.json`."""


@dataclass(frozen=True)
class Ranked:
    """A candidate of the ranking.

    Attributes:
        effect: its name, `none` for the rig as it is.
        probability: its probability among all that are ranked [1].
        gap_after: RMS error of the headline signal with it added [SI], for the first few.
        why_not: why it is not what is named, as a sentence; None for what is named.
    """

    effect: str
    probability: float
    gap_after: float | None
    why_not: str | None = None


@dataclass(frozen=True)
class Left:
    """What the named effects leave, and no known effect explains.

    Attributes:
        share: share of the squared excess on the held-out runs that stays [1], of the headline, or of the output that stays where the headline does not.
        where: where it lies, by the training runs; None where nothing was tried beside what is named.
        windows: seconds in which what is left arises.
    """

    share: float
    where: Where | None
    windows: tuple[Window, ...]


@dataclass(frozen=True)
class Diagnosis:
    """Everything that the report shows.

    Attributes:
        rig: the rig as it is.
        logs: all logs, or the parts into which a single one was split; segments where free runs follow those.
        verdict: one of the five outcomes.
        complete: whether the search came to its end; one that the budget or an interruption has ended claims nothing but `partial`.
        untried: candidates that were then not compared.
        restricted: whether some candidates were left out on purpose.
        uninformative: why the logs say nothing, None where they do.
        effects: the named effects, the most important one first.
        alternatives: sets of names that cannot be told apart from the named effects.
        ranking: candidates with their probabilities, the most probable one first.
        where: where the gap lies, None where nothing was tried.
        windows: seconds in which the gap arises.
        left: what the named effects leave, where the verdict is `partial`.
        left_torque: torque that the named effects leave on the training logs, as coloured noise; None where nothing is missing or no
            log tells it.
        signal: the headline signal.
        gaps: the gap by output.
        held_out: the rule by which logs were held out.
        next_experiment: what to measure next, as a sentence.
        proposal: the next experiment as a plan, where it is a command that can be played.
        waterfall: the rig as it is, then the named effects one after the other.
        alternatives_waterfall: the same for the alternatives.
        refused: names that explain a part and are not claimed, each with the reason.
        remarks: what the logs cannot tell about the fitted numbers.
        split: whether held-out runs leave what the fitted ones cover.
        corrected: the rig with what is named.
        before: errors of the rig as it is on the held-out logs.
        after: errors with the named effects.
        settings: limits that were used.
        estimates: what the logs tell of the corrected rig's numbers.
    """

    rig: Rig
    logs: tuple[Log, ...]
    verdict: Verdict
    complete: bool
    untried: tuple[str, ...]
    restricted: bool
    uninformative: str | None
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    ranking: tuple[Ranked, ...]
    where: Where | None
    windows: tuple[Window, ...]
    left: Left | None
    left_torque: LeftTorque | None
    signal: str
    gaps: dict[str, Gap]
    held_out: str
    next_experiment: str
    proposal: Plan | None
    waterfall: tuple[Rung, ...]
    alternatives_waterfall: tuple[Rung, ...]
    refused: dict[str, str]
    remarks: tuple[str, ...]
    split: Split
    corrected: Rig
    before: HeldOut
    after: HeldOut
    settings: Settings
    estimates: Estimates

    @property
    def sentence(self) -> str:
        """What the diagnosis says, as one sentence."""
        gap, unit = self.gaps[self.signal], UNIT[self.signal]
        if not self.complete and self.verdict == "unknown":
            return unfinished_sentence(self.effects, len(self.untried), gap, unit)
        known = "candidate asked for" if self.restricted else "effect of the library"
        other = left_elsewhere(self.gaps, self.signal, self.settings.verdict)
        elsewhere = (other, self.gaps[other]) if other else None
        visible = other or leaves_a_visible_part(gap, self.settings.verdict)
        doubted = next((name for name in self.effects if name in self.refused), None)
        if self.verdict == "unknown" and doubted:
            why = (f"{spoken(doubted)}: " if len(self.effects) > 1 else "") + self.refused[doubted]
            return doubted_sentence(self.effects, gap, why, self._stays if visible else "")
        said = verdict_sentence(
            self.verdict, self.effects, self.alternatives, gap, unit, self.uninformative, known, elsewhere
        )
        return self._among(said)

    def _among(self, said: str) -> str:
        """A sentence that claims something, with the candidates among which it does, and whether the search went on to its end."""
        if self.verdict in CLAIMS:
            said = said if self.complete else f"{said[:-1]}; the search for the rest was ended."
            return f"{said[:-1]}; only the candidates asked for were compared." if self.restricted else said
        return said

    @property
    def headline(self) -> str:
        """The sentence, without the explanations where these logs cannot tell several apart (`explanations`)."""
        if not self.alternatives:
            return self.sentence
        said = several_sentence(self.verdict, 1 + len(self.alternatives), self.gaps[self.signal], self._stays)
        return self._among(said)

    @property
    def _stays(self) -> str:
        """What is left of which output, in words."""
        name = left_elsewhere(self.gaps, self.signal, self.settings.verdict) or self.signal
        return f"{self.gaps[name].after:.3g} {UNIT[name]} of {name}"

    @property
    def explanations(self) -> tuple[str, ...]:
        """What the rig lacks by each of several explanations that cannot be told apart, a clause each; none where there are not several."""
        return explanations(self.effects, self.alternatives) if self.alternatives else ()

    def has_gap(self, name: str) -> bool:
        """Whether the rig as it is leaves a gap in an output; of one that hardly exists a closed share means nothing.

        Args:
            name: the output.

        Returns:
            True where it stands out as much as a gap that is looked into.
        """
        return stands_out(self.gaps[name], self.settings.verdict)

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know besides, one sentence each: first why names are not claimed."""
        return *(f"{spoken(name)} is not claimed: {why}" for name, why in self.refused.items()), *self.remarks

    def __str__(self) -> str:
        """The result in lines, readable without colour."""
        limits = self.settings.report
        lines = [self.sentence, ""]
        for name, gap in self.gaps.items():
            marked = name == self.signal and len(self.gaps) > 1
            lines.append(gap_line(name, gap, marked=marked, told=self.has_gap(name)))
        if self.where is not None and self.verdict != "none" and self.where.share > limits.as_much:
            law = where_words(self.where, limits)
            share = f"{100 * self.where.share:.0f} % of the excess squared error"
            lines.append(f"  where: {self.subsystem}; a law in {law} removes {share}")
        if self.left is not None:
            lines.append(f"  left: {left_words(self.left.share, self.left.where, self.left.windows, limits)}")
        if len(self.waterfall) > 1:
            first, last = self.waterfall[0], self.waterfall[-1]
            lines += [f"  {line}" for line in (*numbers_of(self.rig, last), *moved(first, last, limits))]
        lines += [f"  note: {note}" for note in self.notes]
        lines.append(f"  held out: {self.held_out}; next experiment: {self.next_experiment}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """What a notebook shows: the sentence, and the lines below it."""
        rest = str(self).removeprefix(self.sentence).strip("\n")
        return f"<p><b>{escape(self.sentence)}</b></p><pre>{escape(rest)}</pre>"

    def to_frame(self) -> "pl.DataFrame":
        """The ranking as a table, one candidate a row, the most probable one first.

        Returns:
            Columns `effect`, `probability` [1], `gap_after` (RMS error of the headline signal with it added, in the signal's SI unit;
            null beyond the first few) and `why_not`.
        """
        import polars as pl  # a tenth of a second, which a diagnosis does not need

        kinds = {"effect": pl.String, "probability": pl.Float64, "gap_after": pl.Float64, "why_not": pl.String}
        rows = [(r.effect, r.probability, r.gap_after, r.why_not) for r in self.ranking]
        return pl.DataFrame(rows, schema=kinds, orient="row")

    @property
    def subsystem(self) -> str | None:
        """Subsystem of the first effect, else that of the missing torque."""
        if self.effects:
            part = self.effects[0].removeprefix("parameter.").split(".")[0]
            return "motor" if part == "gear" else part
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
        """`diagnosis.json` as plain objects.

        Returns:
            A dictionary of strings, numbers, lists, dictionaries and None.
        """
        return {
            "schema": SCHEMA,
            "rig": self.rig.name,
            "verdict": self.verdict,
            "complete": self.complete,
            "untried": list(self.untried),
            "untold": self.uninformative,
            "effects": list(self.effects),
            "alternatives": [list(names) for names in self.alternatives],
            "ranking": [
                {
                    "effect": r.effect,
                    "probability": r.probability,
                    "gap_after": r.gap_after,
                    "why_not": r.why_not,
                }
                for r in self.ranking
            ],
            "where": self._where_json(),
            "left": self._left_json(),
            "left_torque": self.left_torque.json() if self.left_torque is not None else None,
            "gap": {
                "signal": self.signal,
                **_gap_json(self.gaps[self.signal]),
                "segment_s": segment_s(self.logs),
                "signals": {name: _gap_json(gap) for name, gap in self.gaps.items()},
            },
            "held_out": self.held_out,
            "split": self.split.json(),
            "next_experiment": self.next_experiment,
            "drift": [_rung_json(self.rig, rung) for rung in (*self.waterfall, *self.alternatives_waterfall)],
            **self.estimates.json(),
            "refused": self.refused,
            "remarks": list(self.remarks),
        }

    def _where_json(self) -> dict | None:
        if self.where is None or self.verdict == "none":
            return None
        return {
            "subsystem": self.subsystem,
            "coordinate": self.where.coordinate,
            "interval": _interval_json(self.where),
            "share": self.where.share,
            "windows": _windows_json(self.windows),
            **self.where.json(),
        }

    def _left_json(self) -> dict | None:
        if self.left is None:
            return None
        where = self.left.where
        return {
            "share": self.left.share,
            "coordinate": where.coordinate if where is not None else None,
            "interval": _interval_json(where) if where is not None else None,
            "windows": _windows_json(self.left.windows),
        }


def _interval_json(where: Where) -> list[float] | None:
    return list(where.interval) if where.interval is not None else None


def _windows_json(windows: Sequence[Window]) -> list[dict]:
    return [{"log": log, "from_s": begin, "to_s": end, "share": share} for log, begin, end, share in windows]


def _gap_json(gap: Gap) -> dict:
    return {
        "before": gap.before,
        "after": gap.after,
        "floor": gap.floor,
        "closed": gap.closed,
        "ci95": gap.ci95,
    }


def _rung_json(rig: Rig, rung: Rung) -> dict:
    return {
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
            name: {"value": value, "standard_error": _plain(error), "unit": unit_in_rig(rig, name)}
            for name, (value, error) in rung.own.items()
        },
    }


def _plain(value: float) -> float | None:
    """A number, None where it is not finite."""
    return value if np.isfinite(value) else None
