"""A plan played on the board: everything that can be refused is refused before it is armed, and every run begins at rest and
where its travel suffices."""

import math
from collections import deque
from collections.abc import Callable
from contextlib import closing
from typing import NamedTuple

from rwjax.link.frames import Hello, Sample
from rwjax.link.recorder import check_pulses, open_port, play, to_play
from rwjax.link.session import LinkError, Session
from rwjax.link.stream import channels, check_rig
from rwjax.planning.experiment import TICK_HZ
from rwjax.planning.files import Plan, Run
from rwjax.planning.motion import WAIT_S
from rwjax.rig.model import Rig

STILL_TICKS = TICK_HZ
"""In which no encoder may count more than `DITHER`, for the rig to be taken to be at rest."""
DITHER = 1
"""Counts between which an encoder may hang."""
LONGEST_WAIT = round(WAIT_S * TICK_HZ)
"""Ticks after which the wait ends even so: something may drift for ever."""


class Task(NamedTuple):
    """What a recording waits for, with notes on it, and what it does then."""

    ready: Callable[[Session], dict[str, str]]
    act: Callable[[Session], None]


def of_plan(plan: Plan, rig: Rig, clear: bool = False) -> list[Task]:
    """What to do in the session of each run's recording. Raises `LinkError` for the first run that the board cannot play.

    Where the plan limits the travel, a run that would leave it from where the axis then stands is refused; the axis is taken
    to stand in the middle of it when the first one begins.
    """
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
    acts = [play(run.experiment, rig, clear) for run in plan.runs]
    axis, travel = channels(rig).encoders.get("axis"), plan.limits.get("yaw_rad", math.inf)
    if axis is None or math.isinf(travel):
        return [Task(at_rest, act) for act in acts]
    place = Place(axis, 2.0 * math.pi / rig.counts_per_rev["axis"])

    def task(k: int, run: Run, act: Callable[[Session], None]) -> Task:
        rest = " ".join(f"--run {later.name}" for later in plan.runs[k:])

        def ready(session: Session) -> dict[str, str]:
            if place.lost or not place.look(session):
                raise LinkError(
                    f"run `{run.name}`: the axis still moves after {WAIT_S:g} s, and its travel is limited; bring it to the middle, "
                    f"hold it, and go on with {rest}"
                )
            check_travel(run, place.angle, travel, rest)
            return {}

        def then_rest(session: Session) -> None:
            act(session)
            if k + 1 < len(plan.runs):  # so that it stands where it was seen, should the board forget its counts
                place.lost = not place.look(session)  # this run is done; the next one is refused then

        return Task(ready, then_rest)

    return [task(k, run, act) for k, (run, act) in enumerate(zip(plan.runs, acts, strict=True))]


def check_plan(url: str, plan: Plan, rig: Rig) -> None:
    """Raises `LinkError` for a run whose pulses the board at this port does not give, or in which, by its plan, an encoder
    turns faster than that allows."""
    with closing(open_port(url)) as port:
        hello = Session(port).greet()
    for run in plan.runs:
        try:
            check_pulses(run.experiment, rig, hello.pulse_min / 2.0, hello.pulse_max / 2.0)
        except LinkError as error:
            raise LinkError(f"run `{run.name}`: {error}") from None
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
    """Raises `LinkError` where a run that begins at an angle [rad] from the middle leaves the travel either way of it.

    `rest`: options that play it and what comes after it. What a run needs from the middle itself is its plan's care.
    """
    peak = run.reaches.get("yaw_rad", 0.0)
    low, high = run.way or (-peak, peak)
    if angle + high > max(travel, high) or angle + low < min(-travel, low):
        far = angle + (high if angle > 0.0 else low)
        raise LinkError(
            f"run `{run.name}`: the axis stands {angle:.3g} rad from where the plan began, and would go on to {far:.3g}, beyond "
            f"the {travel:.3g} of the plan; bring it back there and go on with {rest}"
        )


class Place:
    """Where the axis stands [rad], from where it was first looked at: through several sessions, also where the board starts
    anew with each, as many do when their port is opened, and counts from 0 again. `lost` where it did not come to rest in time."""

    def __init__(self, encoder: int, per_count: float) -> None:
        self.angle, self.lost = 0.0, False
        self._encoder, self._per_count = encoder, per_count
        self._seen: tuple[Hello, int] | None = None

    def look(self, session: Session) -> bool:
        """Waits for the axis to rest; whether it does so within a minute."""
        hello = session.hello or session.greet()
        sample = settle(session, (self._encoder,))
        if sample is None:
            return False
        count = (sample.count_1, sample.count_2)[self._encoder]
        if self._seen is not None:
            before = self._seen[1] if self._seen[0].nonce == hello.nonce else 0
            self.angle += self._per_count * ((count - before + 2**31) % 2**32 - 2**31)
        self._seen = hello, count
        return True


def at_rest(session: Session) -> dict[str, str]:
    """Waits for rest; a note where there is none within a minute."""
    return {} if settle(session) else {"start": f"the rig still moved after a wait of {WAIT_S:g} s"}


def settle(session: Session, encoders: tuple[int, ...] = (0, 1)) -> Sample | None:
    """Waits until these encoders have been at rest for a second: the sample then, or None where one still counts after a
    minute."""
    latest: deque[Sample] = deque(maxlen=STILL_TICKS)
    left = LONGEST_WAIT
    while left > 0:
        found = session.samples()
        left -= len(found)
        latest.extend(found)
        if len(latest) == STILL_TICKS and all(
            max(counts) - min(counts) <= DITHER
            for counts in ([(s.count_1, s.count_2)[k] for s in latest] for k in encoders)
        ):
            return latest[-1]
    return None
