"""What the commands that run the nonlinear loop share: a controller's options, and what is read off them."""

import math
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.control import timing_of
from rwjax.cli.options import RATE, finite, positive
from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.control.controller import Controller, LoopTiming
    from rwjax.control.response import StepReference
    from rwjax.rig.model import Rig

Period = Annotated[float, typer.Option(help="sample time of the controller [s]")]
Step = Annotated[float, typer.Option(help="step of the reference [°]")]
Seconds = Annotated[float, typer.Option(help="length of a response [s]")]


def controller_of(
    rig: "Rig", ki: float, volts: float, rpm: float, period: float, late: float, smooth: float
) -> "tuple[Controller, LoopTiming]":
    """What a controller's options say.

    Args:
        rig: the rig that it drives.
        ki: integral gain [V/(rad s)].
        volts: largest command [V].
        rpm: largest rate of the wheel [1/min].
        period: sample time [s].
        late: time from a reading to its command [s].
        smooth: time constant of the derivative's filter [s].

    Returns:
        The controller, its gains but the integral one 0, and the timing of its loop.

    Raises:
        InputError: an option is out of its range.
    """
    from rwjax.control.controller import Controller
    from rwjax.planning.envelope import check_has

    finite(ki=ki, volts=volts)
    positive(volts=volts, rpm=rpm)
    if rpm < math.inf:
        check_has(rig.kind, "wheel_rad_s")
    if ki < 0.0:
        raise InputError("--ki: must not be negative")
    timing = timing_of(rig, period, late, smooth)
    return Controller(0.0, ki=ki, filter_time=smooth, voltage_limit=volts, wheel_rate_limit=rpm * RATE), timing


def reference_of(step: float, seconds: float, period: float) -> "StepReference":
    """The reference that the options ask for, a step at the first sample.

    Args:
        step: size of the step [°].
        seconds: length of the response [s].
        period: sample time [s].

    Returns:
        The step in SI units.

    Raises:
        InputError: an option is out of its range.
    """
    from rwjax.control.response import StepReference

    finite(step=step, seconds=seconds)
    if step == 0.0:
        raise InputError("--step 0: has to be a number other than 0")
    samples = round(seconds / period) if seconds > 0.0 else 0
    if not 10 <= samples <= 1_000_000:
        raise InputError(f"--seconds {seconds:g}: has to hold 10 to 1000000 samples of {period:g} s")
    return StepReference(math.radians(step), seconds)
