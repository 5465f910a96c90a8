"""A plan played on the board.

Everything that can be refused is refused before the board is armed. Every run begins at rest, and where the axis's travel
is limited, where its own travel suffices.
"""

import math
from collections.abc import Callable
from contextlib import closing
from typing import NamedTuple

from rwjax.link.channels import channels, pwm_of
from rwjax.link.messages import Hello
from rwjax.link.play_experiment import check_pulses, play, play_values
from rwjax.link.port import LinkError, open_port
from rwjax.link.rest import AxisPosition, at_rest
from rwjax.link.session import Session
from rwjax.planning.files import Plan, Run
from rwjax.planning.motion import WAIT_S
from rwjax.rig.model import Rig


class Task(NamedTuple):
    """What a recording does.

    Attributes:
        ready: Waits until it may begin, and returns notes on that.
        act: What it records.
    """

    ready: Callable[[Session], dict[str, str]]
    act: Callable[[Session], None]


def tasks_of_plan(plan: Plan, rig: Rig, clear: bool = False) -> list[Task]:
    """What to do in the session of each run's recording.

    Where the plan limits the travel, the axis is taken to stand in the middle of it when the first run begins. A run that
    would leave the travel from where the axis then stands is refused.

    Args:
        plan: The plan.
        rig: The rig that it moves.
        clear: Whether a latched fault is cleared first.

    Returns:
        A task for each run.

    Raises:
        LinkError: For a plan of another rig, and for the first run that no board can play.
        RigError: Where the rig file says nothing about pulses or counts.
    """
    pwm_of(rig)
    if plan.rig != rig.name:
        raise LinkError(
            f"made for the rig `{plan.rig}`, and this is `{rig.name}`; make a plan for it with `rwjax plan`"
        )
    for run in plan.runs:
        try:
            play_values(run.experiment, rig)
        except LinkError as error:
            raise LinkError(f"run `{run.name}`: {error}") from None
    acts = [play(run.experiment, rig, clear) for run in plan.runs]
    axis, travel = channels(rig).encoders.get("axis"), plan.limits.get("yaw_rad", math.inf)
    if axis is None or math.isinf(travel):
        return [Task(at_rest, act) for act in acts]
    limited = _LimitedTravel(plan.runs, travel, AxisPosition(axis, 2.0 * math.pi / rig.counts_per_rev["axis"]))
    return [limited.task(k, act) for k, act in enumerate(acts)]


class _LimitedTravel:
    """Tasks of runs that share one travel of the axis [rad] either way, and follow where the axis stands."""

    def __init__(self, runs: tuple[Run, ...], travel: float, position: AxisPosition) -> None:
        self._runs, self._travel, self._position = runs, travel, position

    def task(self, k: int, act: Callable[[Session], None]) -> Task:
        """The k-th run's: it is refused where it would leave the travel, and looks where the axis stands at its end."""
        run, position = self._runs[k], self._position
        rest = " ".join(f"--run {later.name}" for later in self._runs[k:])

        def ready(session: Session) -> dict[str, str]:
            if position.lost or not position.look(session):
                raise LinkError(
                    f"run `{run.name}`: the axis still moves after {WAIT_S:g} s, and its travel is limited; bring it to the middle, "
                    f"hold it, and go on with {rest}"
                )
            check_travel(run, position.angle, self._travel, rest)
            return {}

        def act_then_look(session: Session) -> None:
            act(session)
            if k + 1 < len(self._runs):  # the board may forget its counts before the next run
                position.lost = not position.look(session)  # this run is done; the next one is refused then

        return Task(ready, act_then_look)


def check_plan(url: str, plan: Plan, rig: Rig) -> None:
    """Checks that the board at a port can play a plan.

    Args:
        url: The port, as `open_port` takes it.
        plan: The plan.
        rig: The rig that it moves.

    Raises:
        LinkError: For a run with pulses that the board does not give, or in which, by the plan's simulation, an encoder
            turns faster than the board allows; and where no board answers.
    """
    with closing(open_port(url)) as port:
        hello = Session(port).greet()
    for run in plan.runs:
        try:
            check_pulses(run.experiment, rig, hello.pulse_min / 2.0, hello.pulse_max / 2.0)
        except LinkError as error:
            raise LinkError(f"run `{run.name}`: {error}") from None
        _check_rates(run, rig, hello)


def _check_rates(run: Run, rig: Rig, hello: Hello) -> None:
    """`LinkError` where an encoder turns faster than the board allows."""
    for who, output, option, unit in (
        ("axis", "yaw_rad_s", "--rate", 1.0),
        ("wheel", "wheel_rad_s", "--rpm", 30.0 / math.pi),
    ):
        counts, rate = rig.counts_per_rev.get(who), run.reaches.get(output, 0.0)
        most = hello.most_counts * hello.tick_hz * 2.0 * math.pi / counts if counts else math.inf
        if rate > most:
            raise LinkError(
                f"run `{run.name}`: the {who} reaches {rate:.4g} rad/s, and the board stops at {most:.4g} rad/s; "
                f"make a plan with `rwjax plan {option} {unit * most:.4g}`"
            )


def check_travel(run: Run, angle: float, travel: float, rest: str) -> None:
    """Checks that a run keeps to the travel from where it begins. What it needs from the middle is the plan's care.

    Args:
        run: The run.
        angle: Where it begins [rad], from the middle.
        travel: How far the axis may turn from the middle [rad], either way.
        rest: Options that play this run and those after it, for the message.

    Raises:
        LinkError: Where the run would leave the travel.
    """
    peak = run.reaches.get("yaw_rad", 0.0)
    low, high = run.angle_range or (-peak, peak)
    if angle + high > max(travel, high) or angle + low < min(-travel, low):
        far = angle + (high if angle > 0.0 else low)
        raise LinkError(
            f"run `{run.name}`: the axis stands {angle:.3g} rad from where the plan began, and would go on to {far:.3g}, beyond "
            f"the {travel:.3g} of the plan; bring it back there and go on with {rest}"
        )
