"""The columns that a log may hold, by kind of rig, and the unit of what they become."""

from typing import NamedTuple

from rwjax.kinds import MOTORED, ONE_AXIS, TURNING, TWO_AXIS, WHEELED, half_column


class Column(NamedTuple):
    """A column that a log may hold besides time and input.

    Attributes:
        output: Name of the output in `Log.outputs`, in SI.
        kinds: Kinds of rig that have the column.
        encoder: What the encoder sits on whose counts the column holds (`kinds.ENCODERS`); None for a column in SI.
    """

    output: str
    kinds: tuple[str, ...]
    encoder: str | None = None


COLUMNS = {
    "yaw_counts": Column("yaw_rad", TURNING + TWO_AXIS, encoder="axis"),
    "yaw_rad": Column("yaw_rad", TURNING + TWO_AXIS),
    "position_m": Column("yaw_rad", ("platform",)),
    "position_rad": Column("yaw_rad", ("joint",)),
    "yaw_rad_s": Column("yaw_rad_s", TURNING + TWO_AXIS),
    "wheel_counts": Column("wheel_rad", WHEELED, encoder="wheel"),
    "wheel_rad": Column("wheel_rad", WHEELED),
    "wheel_rad_s": Column("wheel_rad_s", WHEELED),
    "current_A": Column("current_A", MOTORED),
}
COLUMNS |= {
    "pitch_counts": Column("pitch_rad", TWO_AXIS, encoder="pitch"),
    "pitch_rad": Column("pitch_rad", TWO_AXIS),
    "pitch_rad_s": Column("pitch_rad_s", TWO_AXIS),
    **{
        half_column(name, k): Column(
            half_column(COLUMNS[name].output, k), TWO_AXIS, f"wheel_{k + 1}" if name == "wheel_counts" else None
        )
        for k in range(2)
        for name in ("wheel_counts", "wheel_rad", "wheel_rad_s", "current_A")
    },
}
"""Columns of measured outputs by name."""
COMMANDS = {
    "voltage_V": ONE_AXIS,
    "duty": ONE_AXIS,
    "command_A": MOTORED,
    "command_Nm": ("joint",),
    "goal_rad": TURNING,
    **{half_column("voltage_V", k): TWO_AXIS for k in range(2)},
}
"""Columns of the command by name, each with the kinds of rig that take it."""
ENABLED = "enabled"
"""Column that says whether torque is on, 1, or off, 0."""
INPUTS = ("time_s", *COMMANDS, "supply_V", ENABLED)
"""Columns that are no measured output."""
_UNITS = {"_rad": "rad", "_rad_s": "rad/s", "_A": "A", "_V": "V", "_Nm": "N m", "_m": "m", "_s": "s"}


def commands_of(kind: str) -> tuple[str, ...]:
    """The columns of the command that a kind of rig takes.

    Args:
        kind: Kind of the rig.

    Returns:
        Names: of a rig with two axes both are needed, of any other exactly one.
    """
    return tuple(name for name, kinds in COMMANDS.items() if kind in kinds)


def columns_of(kind: str) -> tuple[str, ...]:
    """All columns that a log of a kind of rig may hold.

    Args:
        kind: Kind of the rig.

    Returns:
        Names, time and commands first.
    """
    enabled = (ENABLED,) if kind in MOTORED else ()
    readings = (name for name, column in COLUMNS.items() if kind in column.kinds)
    return ("time_s", *commands_of(kind), "supply_V", *enabled, *readings)


def unit_of(output: str) -> str:
    """The unit of an output or a command, as people write it.

    Args:
        output: A name in `Log.outputs`, such as `yaw_rad_s`, or of a column in SI, such as `voltage_V`.

    Returns:
        The unit ("rad/s"), empty for a name without a known one.
    """
    return next((unit for end, unit in sorted(_UNITS.items(), key=lambda u: -len(u[0])) if output.endswith(end)), "")
