"""Thresholds of the search and the verdict: how much evidence, and how much of a gap, a name needs.

Proposals, tried on simulated cases of `experiments/blind/sets/calibrate.jsonl` and `explore.jsonl`, frozen while the set `second` was run,
whose results are in `experiments/blind/results/second.jsonl` and docs/verdict.md.
"""

from typing import NamedTuple

NEEDED = 5.0
"""Log evidence that a further name must bring."""
CLOSE = 3.0
"""Log evidence within which two hypotheses cannot be told apart."""
CLOSE_ABOVE = 2.0
"""The same for one of which the other is a special case: chance brings a number of no use so near once in thirty."""
TIE = 0.1
"""Share of the sum of squares by which two hypotheses may differ and still tie where neither reaches the noise."""
FAR_FROM_NOISE = 4.0
"""Mean square in units of noise above which an hypothesis counts as incomplete."""
NOTHING_LEFT = 0.1
"""Excess (mean square above the noise, summed over outputs) below which nothing is left to explain."""
TRIFLE = 0.1
"""Share of the rig's own excess (a third of its error) below which what is left is no gap but the effect's exact form."""
WORTH = 0.05
"""Share of the excess (mean square above the noise) that the first name must remove."""
WORTH_BESIDES = 0.5
"""Share of the remaining excess that a further name must remove: less than half of it is no second cause but the exact form
of the first."""
MOST_NAMES = 3
HOPEFUL = (0.0, 0.15, 0.4)
"""Share of the error above the noise that so many names must remove for a further one to be looked for beside them: of three
equal causes the first removes 0.18, two 0.42."""
HOPELESS, NOTHING_NAMED = 0.5, 1.0
"""The same below which rivals are not looked for, where the excess that is left is above the second: no name will stand."""


class Limits(NamedTuple):
    """Limits of the verdict.

    nothing: size of a gap, in floors, below which nothing is said to be missing;
    doubt: the same below which a gap that nothing explains is not claimed: the first angle of a run that starts between two
    counts is off by up to half a count, 1.7 times its noise, which the floor does not hold;
    explained: share of the gap above the floor that must be closed for the effects to explain it; a closure whose 95 %
    interval lies below it does not;
    barely: share of the gap that a named cause closes at the least, however wide its interval;
    several: the same for several names together: of those tried, right ones closed 0.99 and wrong ones up to 0.90;
    at_floor: error after the effects are added, in floors, that counts as reaching the floor.
    """

    nothing: float = 1.0
    doubt: float = 1.75
    explained: float = 0.8
    barely: float = 0.75
    several: float = 0.95
    at_floor: float = 1.25


VERDICT = Limits()
