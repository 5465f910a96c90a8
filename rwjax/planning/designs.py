"""The runs of a campaign before their size is known, and which effects each of them tells apart."""

from dataclasses import dataclass

from rwjax.effects import shown
from rwjax.planning.experiment import REST_S, Experiment
from rwjax.planning.motion import TAIL_S


@dataclass(frozen=True)
class Design:
    """A run before its size is known.

    Attributes:
        kind: Kind of the experiment (`experiment.SHAPES`).
        share: Amplitude over the largest one that the limits allow [1].
        period: Period of the command [s].
        length: Length of the command [s].
        why: What it is for, in words.
        shows: Key of `rwjax.effects.shown.RUNS` for the effects that it tells apart; "" where it is there for none.
        offset: Offset of the command over its amplitude [1].
        direction: Sign of the command [1].
        repeats: How often it is played [1].
        role: What its log is for (`logs.sheet.ROLES`).
    """

    kind: str
    share: float
    period: float
    length: float
    why: str
    shows: str = ""
    offset: float = 0.0
    direction: float = 1.0
    repeats: int = 1
    role: str = "train"

    def at(self, amplitude: float, pace: float = 1.0, sign: float = 1.0, column: str = "voltage_V") -> Experiment:
        """The experiment of one amplitude.

        Args:
            amplitude: Amplitude of the command [V, of a goal rad].
            pace: Factor on period and length [1]; less than 1 is faster.
            sign: 1, or -1 for the other direction [1].
            column: Column of the command.

        Returns:
            The experiment.
        """
        offset, direction = round(amplitude * self.offset, 4), sign * self.direction
        period, length = round(pace * self.period, 2), round(pace * self.length, 2)
        return Experiment(
            self.kind, direction * amplitude, sign * offset + 0.0, period, length, column
        )  # 0.0, never -0.0

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
    "coast_fast_back": Design("coast-down", 1.0, 4.0, 12.0, "coasting backward", shown.COASTING, direction=-1.0),
    "coast_slow": Design("coast-down", 0.4, 4.0, 12.0, "coasting from less", shown.COASTING),
    "coast_slow_back": Design(
        "coast-down", 0.4, 4.0, 12.0, "coasting backward from less", shown.COASTING, direction=-1.0
    ),
    "square": Design("square", 0.8, 5.0, 15.0, "validates: a kind of its own", role="validate"),
    "square_offset": Design("square", 0.6, 6.0, 12.0, "validates: about an offset", offset=0.15, role="validate"),
}
BACK = "_back"
"""Ends the name of a run that is commanded backward, beside one forward."""
LONGEST_S = REST_S + max(design.length for design in DESIGNS.values()) + TAIL_S
"""Length [s] of the longest run, with rest before it and time to coast after it."""
