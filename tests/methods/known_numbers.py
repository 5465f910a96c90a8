"""What every method has to find again: numbers of simulated rigs that it began away from."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, Rig
from rwjax.errors import RigError
from rwjax.methods.identified import Identified
from tests.methods.logs import COMMAND, FREE, TIME, axis_log
from tests.systems import platform, record, run, wheel

Method = Callable[[Rig, Sequence[Log]], Identified]


def _wheel_log(truth: Rig) -> Log:
    u = 6.0 * COMMAND
    y = run(truth, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    return record(TIME, u, {"wheel_rad_s": y + np.random.default_rng(1).normal(0.0, 0.3, len(y))})


def finds_an_axis(method: Method, within: float) -> None:
    """Inertia and friction of an axis, from starts that are 15 % off."""
    truth = platform(free=FREE)
    believed = truth.with_values({name: 1.15 * truth.values[name] for name in truth.free})
    found = method(believed, [axis_log(truth)]).rig
    for name in truth.free:
        assert found.values[name] == pytest.approx(truth.values[name], rel=within), name
        assert found.standard_error[name] > 0.0


def finds_a_wheel(method: Method, within: float) -> None:
    """The inertia of a wheel."""
    truth = wheel()
    found = method(truth.with_values({"wheel.inertia": 1.5e-4}), [_wheel_log(truth)]).rig
    assert found.values["wheel.inertia"] == pytest.approx(1.24e-4, rel=within)


def finds_an_effect_on_the_command(method: Method, within: float) -> None:
    """A dead zone."""
    base = wheel(inductance=0.0)
    truth = replace(base, effects={"drive.deadzone": {"u_0": 0.8}}, free=(*base.free, "drive.deadzone.u_0"))
    found = method(truth.with_values({"drive.deadzone.u_0": 0.6}), [_wheel_log(truth)]).rig
    assert found.values["drive.deadzone.u_0"] == pytest.approx(0.8, rel=within)


def refuses_a_delay(method: Method) -> None:
    """A method whose commands act at once says so."""
    late = replace(platform(free=FREE), effects={"drive.delay": {"tau": 0.05}})
    with pytest.raises(RigError, match=r"has drive.delay; .* takes commands to act at once"):
        method(late, [axis_log(late)])
