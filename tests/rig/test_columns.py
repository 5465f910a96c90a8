"""The columns of a log by kind of rig."""

import pytest

from rwjax.kinds import ENCODERS, KINDS, MOTORED
from rwjax.rig.columns import COLUMNS, ENABLED, INPUTS, columns_of, commands_of, unit_of

COMMANDED = {
    "wheel": "voltage_V duty command_A",
    "platform": "voltage_V duty goal_rad",
    "reaction": "voltage_V duty command_A goal_rad",
    "joint": "voltage_V duty command_A command_Nm goal_rad",
    "two_axis": "voltage_1_V voltage_2_V",
}
"""The commands of each kind, as the interface says."""


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_commands_and_readings(kind: str) -> None:
    assert " ".join(commands_of(kind)) == COMMANDED[kind] and {*commands_of(kind)} <= {*INPUTS}
    assert (ENABLED in columns_of(kind)) == (kind in MOTORED) and len({*columns_of(kind)}) == len(columns_of(kind))
    assert any(kind in column.kinds for column in COLUMNS.values())


def test_counts_name_an_encoder_of_their_kind() -> None:
    for name, column in COLUMNS.items():
        assert (column.encoder is not None) == name.endswith("_counts")
        for kind in column.kinds if column.encoder else ():
            assert any(on == column.encoder and kind in kinds for on, kinds in ENCODERS.values()), (name, kind)


MEASURED = {
    "wheel": "wheel_counts wheel_rad wheel_rad_s current_A",
    "platform": "yaw_counts yaw_rad position_m yaw_rad_s",
    "reaction": "yaw_counts yaw_rad yaw_rad_s wheel_counts wheel_rad wheel_rad_s current_A",
    "joint": "yaw_counts yaw_rad position_rad yaw_rad_s current_A",
    "two_axis": "yaw_counts yaw_rad yaw_rad_s pitch_counts pitch_rad pitch_rad_s "
    "wheel_1_counts wheel_1_rad wheel_1_rad_s current_1_A wheel_2_counts wheel_2_rad wheel_2_rad_s current_2_A",
}
"""What the logs of a kind may hold besides time and input, as docs/files.md says."""


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_the_columns_of_its_bodies(kind: str) -> None:
    assert {name for name, column in COLUMNS.items() if kind in column.kinds} == {*MEASURED[kind].split()}


def test_counts_become_the_angle_of_what_the_encoder_sits_on() -> None:
    parts = {"yaw_counts": "axis"}
    for name, column in COLUMNS.items():
        if name.endswith("_counts"):
            part = name.removesuffix("_counts")
            assert (column.output, column.encoder) == (f"{part}_rad", parts.get(name, part))
        else:
            assert column.output == ("yaw_rad" if name.startswith("position_") else name)


def test_inputs_are_time_commands_and_supply() -> None:
    assert {*INPUTS} == {"time_s", "supply_V", "enabled"} | {
        name for names in COMMANDED.values() for name in names.split()
    }


def test_no_column_is_an_input_and_every_output_has_a_unit() -> None:
    assert not {*COLUMNS} & {*INPUTS}
    assert {unit_of(column.output) for column in COLUMNS.values()} == {"rad", "rad/s", "A"}
    assert [unit_of(name) for name in ("goal_rad", "command_A", "command_Nm", "duty", "time_s")] == [
        "rad",
        "A",
        "N m",
        "",
        "s",
    ]
    assert (unit_of("yaw_rad"), unit_of("wheel_2_rad_s"), unit_of("current_1_A"), unit_of("mood")) == (
        "rad",
        "rad/s",
        "A",
        "",
    )
