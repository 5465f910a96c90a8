"""Which candidates a diagnosis compares, where only some are asked for or some are to be left out."""

from collections.abc import Sequence
from dataclasses import dataclass

from rwjax.diagnosis.hypothesis import candidates
from rwjax.effects.library import listed
from rwjax.errors import InputError, nearest
from rwjax.rig.model import Rig


@dataclass(frozen=True)
class Asked:
    """The candidates that a diagnosis compares.

    Attributes:
        names: the candidates, in the order of the library.
        only: those that alone were asked for; none where all were.
        without: those that were left out.
    """

    names: tuple[str, ...]
    only: tuple[str, ...] = ()
    without: tuple[str, ...] = ()

    @property
    def restricted(self) -> bool:
        """Whether the rig has candidates that are not compared on purpose."""
        return bool(self.only or self.without)

    def said(self) -> list[str]:
        """A remark for the reader, where not all candidates are compared.

        Returns:
            One sentence, or none.
        """
        if self.only:
            return [f"compared were, as asked, only {', '.join(self.names)}: the cause may be another one"]
        if self.without:
            return [f"left out, as asked: {', '.join(self.without)}; the cause may be among them"]
        return []


def asked(rig: Rig, only: Sequence[str] = (), without: Sequence[str] = ()) -> Asked:
    """The candidates of a rig that are compared.

    Args:
        rig: the rig as it is.
        only: names of the only candidates to compare, all of them where none are given.
        without: names of candidates, or of any effects, that are left out.

    Returns:
        The candidates.

    Raises:
        InputError: a name is none, or nothing is left; one sentence says what would be right.
    """
    for option, names in (("only", only), ("without", without)):
        if isinstance(names, str):
            raise InputError(f"`{option}` is one name; give names in a list, as {option}=[{names!r}]")
    every = candidates(rig)
    known = {*every, *listed()}
    for name in (*only, *without):
        if name not in known:
            raise InputError(f"`{name}` is no effect and no fixed number of this rig; nearest `{nearest(name, every)}`")
    for name in only:
        if name not in every:
            raise InputError(
                f"`{name}` cannot be missing in this rig: it is no part of a `{rig.kind}` rig, or the rig file holds it; "
                f"nearest `{nearest(name, every)}`"
            )
    left_out = tuple(name for name in every if name in without)
    names = tuple(name for name in every if (not only or name in only) and name not in without)
    if not names:
        raise InputError("no candidate is left to compare; ask for more, or leave out fewer")
    return Asked(names, tuple(only), left_out)
