"""Waiting for a rig to come to rest, and where its axis stands then."""

from collections import deque

from rwjax.link.messages import Hello, Sample
from rwjax.link.session import Session
from rwjax.planning.experiment import TICK_HZ
from rwjax.planning.motion import WAIT_S

STILL_TICKS = TICK_HZ
"""Ticks within which no encoder may count more than `DITHER`, for the rig to be taken to be at rest."""
DITHER = 1
"""Counts [1] between which an encoder may go back and forth at rest."""
LONGEST_WAIT = round(WAIT_S * TICK_HZ)
"""Ticks after which the wait ends: something may drift for ever."""


def settle(session: Session, encoders: tuple[int, ...] = (0, 1)) -> Sample | None:
    """Waits until encoders have been at rest for a second.

    Args:
        session: A session with the board.
        encoders: Indices of the encoders to wait for.

    Returns:
        The sample then; None where one of them still counts after `LONGEST_WAIT`.
    """
    latest: deque[Sample] = deque(maxlen=STILL_TICKS)
    for message in session.coming(LONGEST_WAIT):
        if not isinstance(message, Sample):
            continue
        latest.append(message)
        if len(latest) == STILL_TICKS and all(
            max(counts) - min(counts) <= DITHER
            for counts in ([(s.count_1, s.count_2)[k] for s in latest] for k in encoders)
        ):
            return latest[-1]
    return None


def at_rest(session: Session) -> dict[str, str]:
    """Waits for rest before a recording begins.

    Args:
        session: A session with the board.

    Returns:
        Notes for the log: none, or that the rig still moved after a minute.
    """
    return {} if settle(session) else {"start": f"the rig still moved after a wait of {WAIT_S:g} s"}


class AxisPosition:
    """Where the axis stands, through several sessions.

    Many boards start anew when their port is opened, and count from 0 again: between two sessions the axis is taken to
    stand still.

    Args:
        encoder: Index of the axis's encoder.
        per_count: Size of a count [rad].

    Attributes:
        angle: Angle [rad] from where the axis was first looked at.
        lost: Whether the axis did not come to rest in time, so that `angle` no longer holds; set by the caller.
    """

    def __init__(self, encoder: int, per_count: float) -> None:
        self.angle, self.lost = 0.0, False
        self._encoder, self._per_count = encoder, per_count
        self._seen: tuple[Hello, int] | None = None

    def look(self, session: Session) -> bool:
        """Waits for the axis to rest and takes its angle.

        Args:
            session: A session with the board.

        Returns:
            Whether it came to rest within a minute; if not, `angle` stays as it was.
        """
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
