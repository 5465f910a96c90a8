"""Thresholds of the search and the verdict: how much evidence, and how much of a gap, a name needs.

Proposals, tried on some of the simulated cases of `experiments/blind/sets/calibrate.jsonl` and not calibrated yet; no case of
the test set has been run.
"""

NEEDED = 5.0
"""Log evidence that a further name must bring."""
CLOSE = 3.0
"""Log evidence within which two explanations cannot be told apart."""
CLOSE_ABOVE = 2.0
"""The same for one of which the other is a special case: chance brings a number of no use so near once in thirty."""
TIE = 0.1
"""Share of the sum of squares by which two explanations may differ and still tie where neither reaches the noise."""
FAR_FROM_NOISE = 2.0
"""Mean square in units of noise above which an explanation counts as incomplete."""
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
SIZE_OF_NOTHING = 1.0
"""Size of a gap, in floors, below which nothing is said to be missing."""
SIZE_OF_DOUBT = 1.75
r"""Size of a gap, in floors, below which a gap that nothing explains is not claimed: the first angle of a run that
starts between two counts is off by up to half a count, $\sqrt3$ times its noise, which the floor does not hold."""
EXPLAINED = 0.8
"""Share of the gap above the floor that must be closed for the effects to explain it; a closure whose 95 % interval
lies below it does not."""
BARELY = 0.6
"""Share of the gap that a named cause closes at the least, however wide its interval."""
AT_FLOOR = 1.25
"""Error after the effects are added, in floors, that counts as reaching the floor."""
