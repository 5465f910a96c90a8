"""What of a rig file's servo is still a guess: no log contradicts it, and no fit moves it."""

from rwjax.kinds import SERVO
from rwjax.rig.model import Rig
from rwjax.rig.parse import PERIOD


def about_guesses(rig: Rig) -> list[str]:
    """A note on what a rig file's comments call a guess of its servo, and on what counts where the file is silent.

    Args:
        rig: The rig as its file has it.

    Returns:
        One sentence; none where nothing of the servo is a guess, or a fit estimates all that is.
    """
    names = [name.removeprefix(f"{SERVO}.") for name in rig.guessed if name.startswith(SERVO) and name not in rig.free]
    if not names:
        return []
    silent = ["no limit"] if f"{SERVO}.limit" not in rig.numbers else []
    silent += [f"a period of {PERIOD:g} s"] if rig.numbers.get(f"{SERVO}.period") == PERIOD else []
    besides = f"; {' and '.join(silent)} {'count' if len(silent) > 1 else 'counts'} besides" if silent else ""
    return [
        f"of [{SERVO}] {_listed(names)} {'are guesses' if len(names) > 1 else 'is a guess'} by the file's own comments{besides}: write the "
        "servo's own, and take the comment away"
    ]


def _listed(names: list[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
