"""The columns of a log by kind of rig."""

import pytest

from rwjax.kinds import ENCODERS, KINDS
from rwjax.logs.columns import COLUMNS, INPUTS, commands_of, unit_of


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_commands_and_readings(kind: str) -> None:
    assert len(commands_of(kind)) == (2 if kind == "two_axis" else 1) and {*commands_of(kind)} <= {*INPUTS}
    assert any(kind in column.kinds for column in COLUMNS.values())


def test_counts_name_an_encoder_of_their_kind() -> None:
    for name, column in COLUMNS.items():
        assert (column.encoder is not None) == name.endswith("_counts")
        for kind in column.kinds if column.encoder else ():
            assert any(on == column.encoder and kind in kinds for on, kinds in ENCODERS.values()), (name, kind)


def test_no_column_is_an_input_and_every_output_has_a_unit() -> None:
    assert not {*COLUMNS} & {*INPUTS}
    assert {unit_of(column.output) for column in COLUMNS.values()} == {"rad", "rad/s", "A"}
    assert (unit_of("yaw_rad"), unit_of("wheel_2_rad_s"), unit_of("current_1_A"), unit_of("mood")) == (
        "rad",
        "rad/s",
        "A",
        "",
    )
