"""What the authors of each set of published logs say of its rig (`published.toml`)."""

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from rwjax.diagnosis.verdict import CLAIMS


class Published(NamedTuple):
    """What is published of a rig.

    Attributes:
        present: Names of effects that it has.
        contradict: Names that what is published rules out.
        source: Who says so, and what.
        setup: Set-up that is diagnosed.
        runs: Runs of it, those of `SETS` where none are named.
        reason: Why nothing of it can be simulated, "" where something can.
    """

    present: list[str]
    contradict: list[str]
    source: str
    setup: str = ""
    runs: tuple[str, ...] = ()
    reason: str = ""

    def says(self, verdict: str, sets: Sequence[Sequence[str]]) -> str:
        """What an answer is beside what is published.

        Args:
            verdict: the verdict.
            sets: the named set and its alternatives.

        Returns:
            `no claim`; `agrees` where one of the sets is of published names alone; `contradicts` where every set holds a name that is
            ruled out; and else `more` where a published name is among others, or `other`.
        """
        if verdict not in CLAIMS:
            return "no claim"
        if any({*one} <= {*self.present} for one in sets):
            return "agrees"
        if all({*one} & {*self.contradict} for one in sets):
            return "contradicts"
        return "more" if any({*one} & {*self.present} for one in sets) else "other"


PUBLISHED = {
    data: Published(**line | {"runs": tuple(line.get("runs", ()))})
    for data, line in tomllib.loads(Path(__file__).with_name("published.toml").read_text()).items()
}
"""All sets, by their folder."""
