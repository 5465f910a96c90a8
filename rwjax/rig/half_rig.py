"""One half of a two-axis rig, an axis with its wheel, as a `reaction` rig.

What only needs typical sizes, or draws one axis, then needs no case of its own.
"""

from rwjax.kinds import of_half
from rwjax.rig.model import Rig


def half_rig(rig: Rig, half: int) -> Rig:
    """One half of a two-axis rig under the names of a `reaction` rig.

    Args:
        rig: A `two_axis` rig.
        half: 0 for yaw with wheel 1, 1 for pitch with wheel 2.

    Returns:
        A `reaction` rig with the half's numbers and effects; nothing is free.
    """
    numbers = {found[1]: value for name, value in rig.numbers.items() if (found := of_half(name)) and found[0] == half}
    effects = {found[1]: given for name, given in rig.effects.items() if (found := of_half(name)) and found[0] == half}
    return Rig(kind="reaction", name=rig.name, numbers=numbers, effects=effects)
