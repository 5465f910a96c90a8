"""A plan played on the board: everything that can be refused is refused before it is armed, and every run begins at rest."""

import math
from collections.abc import Callable
from contextlib import closing

from rwjax.link.recorder import open_port, play, to_play
from rwjax.link.session import LinkError, Session
from rwjax.link.stream import check_rig
from rwjax.plan.experiment import TICK_HZ
from rwjax.plan.files import Plan
from rwjax.rig import Rig

STILL_TICKS = TICK_HZ
"""Without a count, after which the rig is taken to be at rest."""
LONGEST_WAIT = 60 * TICK_HZ
"""Ticks after which a run begins even so: something may drift for ever."""


def of_plan(plan: Plan, rig: Rig, clear: bool = False) -> list[Callable[[Session], None]]:
    """What to do in the session of each run's recording. Raises `LinkError` for the first run that the board cannot play."""
    check_rig(rig)
    if plan.rig != rig.name:
        raise LinkError(
            f"made for the rig `{plan.rig}`, and this is `{rig.name}`; make a plan for it with `rwjax plan`"
        )
    for run in plan.runs:
        try:
            to_play(run.experiment, rig)
        except LinkError as error:
            raise LinkError(f"run `{run.name}`: {error}") from None

    def from_rest(act: Callable[[Session], None]) -> Callable[[Session], None]:
        def settled(session: Session) -> None:
            settle(session)
            act(session)

        return settled

    return [from_rest(play(run.experiment, rig, clear)) for run in plan.runs]


def check_speeds(url: str, plan: Plan, rig: Rig) -> None:
    """Raises `LinkError` for a run in which, by its plan, an encoder turns faster than the board at this port allows."""
    with closing(open_port(url)) as port:
        hello = Session(port).greet()
    for run in plan.runs:
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


def settle(session: Session) -> None:
    """Waits until no encoder has counted for a second, a minute at most."""
    still, last = 0, None
    for _ in range(LONGEST_WAIT):
        for sample in session.samples():
            counts = sample.count_1, sample.count_2
            still = still + 1 if counts == last else 0
            last = counts
        if still >= STILL_TICKS:
            return
