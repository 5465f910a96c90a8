"""What a table says of one run: commands of every name, torque off, and the size of readings without a sign."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.logs.array_sheet import ArraySheet
from rwjax.logs.fields import fields_of
from rwjax.rig.columns_section import Source
from tests.logs.texts import PLATFORM, REACTION

T = np.arange(20) / 100.0


def table(**columns: np.ndarray) -> ArraySheet:
    held = {"time_s": T, **columns}
    return ArraySheet("run", {}, list(held), held, "sample")


@pytest.mark.parametrize("name", ["voltage_V", "duty", "command_A", "goal_rad"])
def test_the_command_says_what_it_is(name: str) -> None:
    found = fields_of(table(**{name: T, "yaw_rad": T, "enabled": np.arange(20) % 2}), REACTION)
    assert found["input"] == name and np.array_equal(found["command"], T)
    assert found["enabled"].dtype == bool and found["enabled"].tolist() == [False, True] * 10


def test_torque_that_is_never_switched_is_not_logged() -> None:
    assert fields_of(table(voltage_V=T, yaw_rad=T), PLATFORM)["enabled"] is None


def test_a_reading_without_a_sign_is_never_negative() -> None:
    rig = replace(PLATFORM, sources={"yaw_rad_s": Source("yaw_rad_s", unsigned=True)})
    assert fields_of(table(voltage_V=T, yaw_rad_s=T), rig)["outputs"]["yaw_rad_s"][3] == T[3]
    with pytest.raises(LogError, match="run: sample 4: `yaw_rad_s` .*is -0.03, and .columns. says that it is unsigned"):
        fields_of(table(voltage_V=T, yaw_rad_s=np.where(np.arange(20) == 3, -0.03, T)), rig)
