"""One half of the log of a two-axis rig, an axis with its wheel, as the log of a `reaction` rig."""

from dataclasses import replace

from rwjax.kinds import half_column
from rwjax.logs.log import Log, with_earlier


def half_log(log: Log, half: int) -> Log:
    """The command and the readings of one half under the names of a `reaction` rig's log.

    Args:
        log: A log of a `two_axis` rig, command `(n, 2)`.
        half: 0 for yaw with wheel 1, 1 for pitch with wheel 2.

    Returns:
        The half's log, command `(n,)`.
    """
    names = {half_column(y, half): y for y in ("yaw_rad", "yaw_rad_s", "wheel_rad", "wheel_rad_s", "current_A")}
    return replace(
        log,
        command=log.command[:, half],
        outputs={names[y]: value for y, value in log.outputs.items() if y in names},
        resolution={names[y]: step for y, step in log.resolution.items() if y in names},
        left_out={names[y]: times for y, times in log.left_out.items() if y in names},
        earlier=(log.earlier[0], with_earlier(log.earlier[1], log.command[:0])[:, half]),
    )
