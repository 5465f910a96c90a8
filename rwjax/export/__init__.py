"""A rig in the words of other tools: a MuJoCo model, a C header, a python-control plant, JSON."""

from typing import NamedTuple

from rwjax.rig.model import Rig


class Exported(NamedTuple):
    """A rig in another tool's words.

    Attributes:
        text: The file.
        left_out: What the other tool cannot express, by the effect's name or the number's, each with why.
        held: The rig without what is left out, where the file is a model that can be played.
        own: What to copy into a model of one's own, a line for each element.
        uncounted: Names of `left_out` that `held` has all the same, as no rig file is without them.
    """

    text: str
    left_out: dict[str, str]
    held: Rig | None = None
    own: tuple[str, ...] = ()
    uncounted: tuple[str, ...] = ()
