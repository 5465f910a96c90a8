"""Gains for a rig, designed in two steps: the most robust ones for all plants, then tuned through the nonlinear loop."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from rwjax.control.breakaway import breakaway
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import DEFAULT_CONTROLLER, Controller, LoopTiming, loop_timing
from rwjax.control.response import BAND, DEFAULT_STEP, Response, StepReference, step_response
from rwjax.control.robust_gains import RobustGains, robust_gains
from rwjax.control.robustness import Robustness, robustness
from rwjax.control.tuning import LEAST_MODULUS, tune_from
from rwjax.control.unsettled import least_kp, why_unsettled
from rwjax.errors import InputError, counted, in_two_digits, refuses_other_types
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig


@dataclass(frozen=True)
class GainRequirement:
    """Where gains are looked for, and what their loops have to keep.

    Attributes:
        kp: Range of the proportional gain [V/rad], from 0 or more.
        kd: Range of the derivative gain [V s/rad], from 0 or more.
        sigma: Rate at which every motion of every plant's loop dies away at least, without the integral [1/s].
        least_modulus: Modulus margin that the tuned loop keeps on the rig itself [1].
    """

    kp: tuple[float, float] = (0.0, 100.0)
    kd: tuple[float, float] = (0.0, 100.0)
    sigma: float = 0.5
    least_modulus: float = LEAST_MODULUS

    def __post_init__(self) -> None:
        for name, (low, high) in (("kp", self.kp), ("kd", self.kd)):
            if not 0.0 <= low < high < np.inf:
                raise InputError(f"{name} {low:g} to {high:g}: has to run from 0 or more to a larger number")
        if not 0.0 <= self.sigma < np.inf:
            raise InputError(f"sigma {self.sigma:g}: must not be negative, the loop has to be stable to be tuned")
        if not 0.0 < self.least_modulus < 1.0:
            raise InputError(f"least_modulus {self.least_modulus:g}: has to lie between 0 and 1")


DEFAULT_REQUIREMENT = GainRequirement()
"""Gains of up to 100, motions that die away with 0.5 1/s, and a modulus margin of 0.5."""


HELD = (5.0 * BAND, 2.5 * BAND, 0.9 * BAND)
"""Shares of a step off which friction may hold the axis with the robust gains, tried in this order: with the last of them an axis at rest
breaks loose wherever it is not settled, with the others its momentum has to help."""


class DesignedController(NamedTuple):
    """A controller with what it does.

    Attributes:
        controller: Gains and limits.
        robustness: Its linear loop on all plants.
        response: Figures of its step response on the rig.
        why: Why its step does not settle, in words; empty where it does.
    """

    controller: Controller
    robustness: Robustness
    response: Response
    why: str = ""

    @property
    def settles(self) -> str:
        """How its step ends, in words: after how many seconds it settles, or why it does not."""
        return f"does not settle: {self.why}" if self.why else f"settles in {float(self.response.settling):.3g} s"


@dataclass(frozen=True, eq=False)
class GainDesign:
    """Gains designed for a rig.

    Attributes:
        robust: The controller with the largest worst-case margin over the plants, without an integral of those whose
            step settles, or that stay least off, where their margin is that of the tuned loop.
        tuned: The same tuned through the rig's nonlinear loop.
        least_modulus: Modulus margin that the tuning kept on the rig itself [1]; less than was asked for where the robust
            gains have less.
        plants: Number of plants [1].
    """

    robust: DesignedController
    tuned: DesignedController
    least_modulus: float
    plants: int

    def __str__(self) -> str:
        lines = [f"gains for {self.plants} plant{'s' * (self.plants != 1)}:"]
        for name, found in (("robust", self.robust), ("tuned", self.tuned)):
            law, seen = found.controller, found.response
            lines.append(
                f"  {name}: kp {float(law.kp):.4g} V/rad, ki {float(law.ki):.4g} V/(rad s), kd {float(law.kd):.4g} V s/rad; "
                f"modulus margin {found.robustness.modulus:.2f}; overshoot {in_two_digits(100.0 * float(seen.overshoot))} %, {found.settles}"
            )
        return "\n".join(lines)


class _Task(NamedTuple):
    """What every controller of a design is judged on; `breakaway`: the command at which the axis breaks loose [V]; `progress` hears of what takes long."""

    rig: Rig
    plants: Float[np.ndarray, "k p"]
    reference: Float[np.ndarray, " s"]
    timing: LoopTiming
    breakaway: float
    progress: Callable[[str], None]

    def response(self, controller: Controller) -> Response:
        """The step response of a controller on the rig."""
        run = run_rig(self.rig, controller, self.reference, self.timing)
        return step_response(run, self.reference[-1], self.timing.period, controller.voltage_limit)

    def judge(self, controller: Controller, found: Robustness) -> DesignedController:
        """A controller with its robustness and its step response."""
        seen, step = self.response(controller), float(self.reference[-1])
        settles = bool(np.isfinite(seen.settling))
        why = "" if settles else why_unsettled(controller, self.breakaway, step, self.timing, float(seen.error))
        return DesignedController(controller, found, seen, why)


@refuses_other_types
def tune(
    rig: Rig,
    requirement: GainRequirement = DEFAULT_REQUIREMENT,
    *,
    controller: Controller = DEFAULT_CONTROLLER,
    friction_share: float = 0.0,
    step: StepReference = DEFAULT_STEP,
    timing: LoopTiming | None = None,
    thetas: Float[np.ndarray, "k p"] | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> GainDesign:
    """Gains for a rig's axis: those of the largest worst-case margin, then tuned through the nonlinear closed loop.

    Args:
        rig: The rig.
        requirement: Where gains are looked for, and what their loops have to keep.
        controller: Integral gain to begin with (0: none), filter, deadband and limits; its `kp` and `kd` are not used.
        friction_share: Share of the breakaway command that is fed forward [1]; more than 1 makes the loop oscillate.
        step: The step along which the loop is tuned.
        timing: When the controller reads and acts; without it 100 Hz on the rig's encoder (`loop_timing`).
        thetas: Plants for the worst-case margin [SI], one for each row, `(k, p)` (`fit_estimate.draw_plants`); without them the
            rig itself counts.
        progress: Hears of what takes long, in words.

    Returns:
        Both controllers with their margins and responses; the result prints itself.

    Raises:
        InputError: For no rig, where no gains meet the requirement, where the loop is not stable with the integral; as `loop_setup`,
            `robust_gains`, `breakaway` and `tune_from` do.
    """
    if not 0.0 <= friction_share <= 1.0:
        raise InputError(
            f"friction_share {friction_share:g}: has to lie between 0 and 1; more makes the loop oscillate"
        )
    timing = loop_timing(rig) if timing is None else timing
    plants = theta_of(rig, structure_of(rig))[None] if thetas is None else thetas
    task = _Task(rig, plants, step.samples(timing.period), timing, breakaway(rig), progress)
    start, found = _robust_start(task, requirement, controller._replace(feedforward=friction_share * task.breakaway))
    tuned = tune_from(rig, start, task.reference, timing, requirement.least_modulus, progress)
    progress("looking at the margins and the step response of what was found")
    end = robustness(rig, plants, timing, tuned.controller)
    return GainDesign(task.judge(start, found), task.judge(tuned.controller, end), tuned.least, len(plants))


def _robust_start(task: _Task, requirement: GainRequirement, controller: Controller) -> tuple[Controller, Robustness]:
    """The controller with the most robust gains. Raises `InputError` where its loop is not stable with the integral."""
    start = _settling(task, requirement, controller)
    found = robustness(task.rig, task.plants, task.timing, start)
    if found.stable < 1.0:
        ki = float(controller.ki)
        less = f"--ki {ki:g}: with it" if ki > 0.0 else f"--sigma {requirement.sigma:g}:"
        right = "lower --ki" if ki > 0.0 else "ask for a larger --sigma"
        raise InputError(
            f"{less} the loop is not stable at the most robust gains, kp {start.kp:.3g} and kd {start.kd:.3g}; {right}"
        )
    return start, found


def _settling(task: _Task, requirement: GainRequirement, controller: Controller) -> Controller:
    """The controller with the most robust gains; where friction holds the axis off with them, with those that settle, or stay least off.

    These keep the margin of the tuned loop, or are not taken. An integral brings the axis to its angle in the end, so it is left to that.
    """

    def of(low: float) -> tuple[Controller, RobustGains]:
        kp, kd = np.array([low, requirement.kp[1]]), np.array(requirement.kd)
        filter_time = float(controller.filter_time)
        gains = robust_gains(task.rig, task.plants, kp, kd, requirement.sigma, task.timing, filter_time)
        return controller._replace(kp=gains.kp, kd=gains.kd), gains

    low, high = requirement.kp
    task.progress(f"looking for the most robust gains for {counted(len(task.plants), 'plant')}")
    best, _ = of(low)
    if float(controller.ki) > 0.0:
        return best
    off, step = _off(task, best), abs(float(task.reference[-1]))
    for k, share in enumerate(HELD):
        if off == 0.0:
            break
        task.progress(f"looking for gains that settle: {k + 1} of {len(HELD)} ranges at most")
        least = min(least_kp(controller, task.breakaway, share * step), high)
        if least <= low:
            continue
        try:
            one, gains = of(least)
        except InputError:  # none of these gains meets the requirement, nor do larger ones
            break
        if gains.modulus < requirement.least_modulus:
            break
        if (closer := _off(task, one)) < off - BAND * step or closer == 0.0:
            best, off = one, closer
        low = least
    return best


def _off(task: _Task, controller: Controller) -> float:
    """How far off its angle a controller leaves the axis [rad]; 0 where the step settles, infinite where the run diverges."""
    seen = task.response(controller)
    error = abs(float(seen.error)) + float(seen.cycle)
    return 0.0 if np.isfinite(seen.settling) else error if np.isfinite(error) else np.inf
