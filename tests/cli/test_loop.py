"""What the commands that run the nonlinear loop read off a controller's options."""

import math

import pytest

from rwjax.cli.loop import controller_of, reference_of
from rwjax.errors import InputError
from tests.systems import platform, reaction


def test_a_reference_is_a_step_in_radians() -> None:
    step = reference_of(-90.0, 0.2, 0.01)
    assert (step.angle, step.seconds) == (-math.pi / 2.0, 0.2) and step.samples(0.01).tolist() == [step.angle] * 20
    with pytest.raises(InputError, match="^--seconds 0.09: has to hold 10 to 1000000 samples of 0.01 s$"):
        reference_of(10.0, 0.09, 0.01)


def test_a_controller_has_the_options_in_si_units() -> None:
    controller, timing = controller_of(reaction(), ki=2.0, volts=5.0, rpm=60.0, period=0.01, late=0.005, smooth=0.02)
    assert (controller.kp, controller.ki, controller.kd) == (0.0, 2.0, 0.0)
    assert (controller.voltage_limit, controller.filter_time) == (5.0, 0.02)
    assert controller.wheel_rate_limit == pytest.approx(2.0 * math.pi)
    assert (timing.period, timing.steps, timing.delay_steps) == (0.01, 4, 2.0)  # half of the four steps of the plant
    with pytest.raises(InputError, match="^--ki: must not be negative$"):
        controller_of(reaction(), ki=-1.0, volts=5.0, rpm=60.0, period=0.01, late=0.0, smooth=0.0)
    with pytest.raises(InputError, match="^--rpm: a `platform` rig has no rate of the wheel; leave the option out$"):
        controller_of(platform(), ki=0.0, volts=5.0, rpm=60.0, period=0.01, late=0.0, smooth=0.0)
    unlimited, _ = controller_of(platform(), ki=0.0, volts=5.0, rpm=math.inf, period=0.01, late=0.0, smooth=0.0)
    assert unlimited.wheel_rate_limit == math.inf
