"""A number of a first rig file, and where it comes from."""

from typing import NamedTuple

from rwjax.kinds import NUMBERS, unit_in_servo


class Known(NamedTuple):
    """A number of the first rig file.

    Attributes:
        value: Its value [SI].
        why: Where it comes from, in words.
        free: Whether a fit is to estimate it.
        by_mass: Whether it is worked out from a mass and a length.
    """

    value: float
    why: str
    free: bool = False
    by_mass: bool = False

    def line(self, name: str, acts_on: str) -> str:
        """The number as it stands in the rig file, with symbol, unit and where it comes from.

        Args:
            name: Its name, one of `rwjax.kinds.NUMBERS`.
            acts_on: What a servo acts on, one of `rwjax.kinds.SERVO_CHOICES`.

        Returns:
            A line of TOML, for the section of the name.
        """
        key, unit = name.rpartition(".")[2], unit_in_servo(name, acts_on)
        return f"{key} = {self.value!r}   # {NUMBERS[name].symbol}, {unit}: {self.why}"
