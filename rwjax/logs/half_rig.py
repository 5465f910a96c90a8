"""One half of a two-axis rig and of its logs, an axis with its wheel, as a `reaction` rig: what only asks for typical sizes,
or draws one axis, then needs no case of its own."""

from dataclasses import replace

from rwjax.kinds import half_column, of_half
from rwjax.logs.log import Log, after
from rwjax.rig.model import Rig


def half_rig(rig: Rig, half: int) -> Rig:
    """The numbers and effects of this half under the names of a `reaction` rig; nothing is free."""
    numbers = {found[1]: value for name, value in rig.numbers.items() if (found := of_half(name)) and found[0] == half}
    effects = {found[1]: given for name, given in rig.effects.items() if (found := of_half(name)) and found[0] == half}
    return Rig(kind="reaction", name=rig.name, numbers=numbers, effects=effects)


def half_log(log: Log, half: int) -> Log:
    """The command and the readings of this half under the names of a `reaction` rig's log."""
    names = {half_column(y, half): y for y in ("yaw_rad", "yaw_rad_s", "wheel_rad", "wheel_rad_s", "current_A")}
    return replace(
        log,
        command=log.command[:, half],
        outputs={names[y]: value for y, value in log.outputs.items() if y in names},
        resolution={names[y]: step for y, step in log.resolution.items() if y in names},
        left_out={names[y]: times for y, times in log.left_out.items() if y in names},
        earlier=(log.earlier[0], after(log.earlier[1], log.command[:0])[:, half]),
    )
