"""The command `cache`: where compiled programs are kept, and how many."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from rwjax.cli.terminal import say

if TYPE_CHECKING:
    from rwjax.cache_folder import Program

Action = Annotated[Literal["clear"] | None, typer.Argument(metavar="[clear]", help="removes them", show_default=False)]


def cache(action: Action = None) -> None:
    """Where compiled programs are kept, how many there are and how large they may grow; `cache clear` removes them.

    Example: `rwjax cache clear`
    """
    from rwjax.cache_folder import MOST_BYTES, VARIABLE, clear, place, programs, weak_point

    folder = place()
    if folder is None:
        say(f"no programs are kept: there is no home folder, or {VARIABLE} is empty; it may name a folder")
        return
    if action:
        removed = clear(folder)
        say(f"{folder}: removed {_amount(removed)}")
        return
    say(f"{folder}: {_amount(programs(folder))}, of at most {MOST_BYTES / 1e6:.0f} MB")
    weak = weak_point(folder) if folder.is_dir() else None
    if weak:
        say(f"not used, since {weak}")


def _amount(found: "Iterable[Program]") -> str:
    sizes = [program.size for program in found]
    return f"{len(sizes)} program{'s' * (len(sizes) != 1)}, {sum(sizes) / 1e6:.1f} MB"
