"""The unit of a number in a rig: of its drive and its servo it depends on what the drive is given."""

from rwjax.effects.library import unit_of_number
from rwjax.kinds import GIVEN, NUMBERS, UNIT_GIVEN, unit_in_servo
from rwjax.rig.model import Rig

DRIVE = "drive."
"""How the names of the drive's effects begin, whose volts stand for what the drive is given. A duty is a voltage by then: the supply's share of it."""
_WITH_VOLTS = {"V": "{}", "V/s": "{}/s", "1/V": "1/({})"}
_PLAIN = {"1": "", "1/(A)": "1/A"}


def unit_in_rig(rig: Rig, number: str) -> str:
    """SI unit of a number of a rig or of one of its effects.

    Args:
        rig: The rig, as its logs drive it.
        number: Name of the number.

    Returns:
        The unit as text, "" where the number has none.
    """
    given = rig.servo.acts_on if rig.servo is not None else GIVEN.get(rig.driven.by, "voltage")
    unit = unit_in_servo(number, given) if number in NUMBERS else unit_of_number(number)
    if number not in NUMBERS and number.startswith(DRIVE) and given not in ("voltage", "duty"):
        unit = _WITH_VOLTS.get(unit, unit).format(UNIT_GIVEN[given])
    return _PLAIN.get(unit, unit)
