"""All findings about logs together."""

from dataclasses import replace

import numpy as np

from rwjax.fitting.questions.check import check
from tests.fitting.questions.test_numbers import RIG, U, log


def test_units_numbers_and_logs_are_looked_at() -> None:
    good = log(U)
    assert check(RIG, [good]) == []
    degrees = replace(good, outputs={"yaw_rad": np.rad2deg(good.outputs["yaw_rad"])})
    first, *_ = check(RIG, [degrees])
    assert first.about == "units" and "degrees" in first.says
    holey = replace(good, outputs={"yaw_rad": np.where(np.arange(len(U)) % 5 == 1, np.nan, good.outputs["yaw_rad"])})
    tied = replace(RIG, free=("drive.gain", "axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"))
    assert [found.about for found in check(tied, [holey])] == ["readings", "numbers"]
    assert {found.about for found in check(tied, [degrees])} == {"units"}  # what numbers it tells depends on the answer


def test_a_drop_out_is_said_once() -> None:
    good = log(U)
    lost = (np.arange(len(U)) >= 300) & (np.arange(len(U)) < 340)
    (found,) = check(RIG, [replace(good, outputs={"yaw_rad": np.where(lost, 40.0, good.outputs["yaw_rad"])})])
    assert found.about == "units" and "yaw_rad is exactly 40 rad from " in found.says
