"""How robust a controller is: its linear loop as it runs, on one plant or on the worst of many."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.margins import sampled_modulus
from rwjax.control.sampled_loop import SampledLaw, sampled_loops
from rwjax.control.stability import is_stable
from rwjax.rig.model import Rig


class Robustness(NamedTuple):
    """A controller on many plants.

    Attributes:
        stable: Share of the plants whose loop is stable [1].
        modulus: Worst modulus margin of them all [1]; 0 where one loop is not stable.
    """

    stable: float
    modulus: float


def robustness(rig: Rig, thetas: Float[np.ndarray, "k p"], timing: LoopTiming, controller: Controller) -> Robustness:
    """What many plants make of a controller in their linear loop as it runs, its integral included.

    Args:
        rig: The rig whose structure the plants have.
        thetas: Parameter vectors [SI], one plant for each row.
        timing: When the controller reads and acts, without the plants' own delays.
        controller: Its gains.

    Returns:
        Share of stable loops [1] and the worst modulus margin [1].

    Raises:
        InputError: As `sampled_loops` does.
    """
    kp, ki, kd = (float(gain) for gain in (controller.kp, controller.ki, controller.kd))
    gains = (kp, ki, kd) if ki > 0.0 else (kp, kd)
    law = SampledLaw(timing, float(controller.filter_time), integral=ki > 0.0)
    loops = sampled_loops(rig, law, thetas)
    margins = [sampled_modulus(loop, *gains) if is_stable(loop, *gains) else 0.0 for loop in loops]
    return Robustness(float(np.mean(np.array(margins) > 0.0)), min(margins))
