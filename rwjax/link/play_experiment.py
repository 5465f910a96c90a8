"""One experiment played by the board: what it refuses to play, and the session that arms, plays and disarms."""

from collections.abc import Callable

from rwjax.link import messages
from rwjax.link.channels import channels, pwm_of
from rwjax.link.messages import Sample
from rwjax.link.port import LinkError
from rwjax.link.session import Session, faults
from rwjax.planning.envelope import ONE_WAY_SHARE, PULSES_US, check_neutral
from rwjax.planning.experiment import REST_S, TICK_HZ, Experiment
from rwjax.rig.model import Rig

SHORTEST_PERIOD, LONGEST_PERIOD = 4, 2**16
"""A period has at least so many ticks, and fewer than so many, which its 16 bits hold."""
LONGEST_RUN = 360_000
"""Ticks of the longest experiment: an hour."""
REST_TICKS = round(REST_S * TICK_HZ)
"""Ticks of rest with which the board begins every experiment."""
MARGIN_TICKS = 100
"""Ticks by which the board may be late to begin, and to end."""
ROUNDING_US = 1e-6
"""By which rounding may carry a pulse [us] beyond its limit."""


def play_values(experiment: Experiment, rig: Rig) -> tuple[int, ...]:
    """What the command PLAY carries for an experiment.

    Args:
        experiment: The experiment, in V and s.
        rig: The rig that it moves.

    Returns:
        Output, kind, amplitude and offset [half us], period and length [ticks].

    Raises:
        LinkError: For what no board can play.
        RigError: Where the rig file says nothing about pulses or counts.
        InputError: Where the neutral pulse leaves too few others.
    """
    if experiment.input != "voltage_V":
        raise LinkError("a board plays voltages, no goals; give the run's CSV to what moves the servo")
    pwm = pwm_of(rig)
    check_neutral(pwm)
    half_us = [_whole(2.0 * volts / pwm.volts_per_us) for volts in (experiment.amplitude, experiment.offset)]
    ticks = [_whole(TICK_HZ * seconds) for seconds in (experiment.period, experiment.length)]
    check_pulses(experiment, rig, *PULSES_US)
    if not SHORTEST_PERIOD <= ticks[0] < LONGEST_PERIOD:
        raise LinkError(f"a period of {experiment.period:g} s: has to lie between 0.04 and 655 s")
    if not 0 < ticks[1] <= LONGEST_RUN:
        raise LinkError(f"a length of {experiment.length:g} s: has to lie between 0.01 and 3600 s")
    return channels(rig).output, messages.EXPERIMENTS.index(experiment.kind), *half_us, *ticks


def check_pulses(experiment: Experiment, rig: Rig, shortest: float, longest: float) -> None:
    """Checks that an ESC takes every pulse of an experiment.

    Args:
        experiment: The experiment, in V and s.
        rig: The rig that it moves, with `drive.pwm`.
        shortest: Shortest pulse that the ESC takes [us].
        longest: Longest pulse that it takes [us].

    Raises:
        LinkError: Where the experiment needs a pulse beyond these.
    """
    assert rig.pwm is not None
    neutral, per_us = rig.pwm
    size = (abs(experiment.amplitude) + abs(experiment.offset)) / abs(per_us)
    span = longest - neutral  # boards drive no further the other way either
    ends = [(end - neutral) * per_us for end in (max(shortest, neutral - span), longest)]
    least = ONE_WAY_SHARE * max(map(abs, ends))
    low, high = sorted(end if abs(end) >= least else 0.0 for end in ends)
    small = size <= span + ROUNDING_US
    beyond = max(low - experiment.span[0], experiment.span[1] - high) / abs(per_us)
    if not (small and beyond <= ROUNDING_US):
        right = "this ESC turns one way: add an offset" if small and 0.0 in (low, high) else "give less"
        raise LinkError(
            f"{experiment.amplitude:g} V about {experiment.offset:g} V: the pulses reach {low:g} to {high:g} V; {right}"
        )


def _whole(value: float) -> int:
    """The nearest whole number; 2^31, which every check refuses, for what is no number or beyond it."""
    return round(value) if abs(value) < 2**31 else 2**31


def play(experiment: Experiment, rig: Rig, clear: bool = False) -> Callable[[Session], None]:
    """What a session does to play an experiment.

    Args:
        experiment: The experiment, in V and s.
        rig: The rig that it moves.
        clear: Whether a latched fault is cleared first.

    Returns:
        A function that arms the board, lets it play to the end and disarms it. It raises `LinkError` where the board
        refuses or stops.

    Raises:
        LinkError: For what no board can play.
    """
    values = play_values(experiment, rig)

    def act(session: Session) -> None:
        hello = session.hello or session.greet()
        check_pulses(experiment, rig, hello.pulse_min / 2.0, hello.pulse_max / 2.0)
        if clear and session.samples()[-1].state == messages.FAULT:
            session.command(messages.CLEAR, done=lambda sample: sample.state != messages.FAULT)
        session.arm()
        session.command(messages.PLAY, *values, done=lambda sample: bool(sample.playing))
        _wait_for_the_end(session, REST_TICKS + values[-1])
        session.disarm()

    return act


def _wait_for_the_end(session: Session, ticks: int) -> None:
    """Returns when the board has played so many ticks; `LinkError` where it stops before or is not seen to begin or end."""
    begun, waited = False, 0
    for message in session.coming(ticks + MARGIN_TICKS):
        if not isinstance(message, Sample):
            continue
        if message.state != messages.ARMED:
            why = faults(message) if message.faults else f"it is {messages.STATES[message.state]}"
            raise LinkError(f"the board has stopped the experiment: {why}")
        if begun and not message.playing:
            return
        begun, waited = begun or bool(message.playing), waited + 1
        if not begun and waited >= MARGIN_TICKS:
            break
    if begun:
        raise LinkError(f"the board does not end an experiment of {ticks / TICK_HZ:g} s in time")
    raise LinkError("the board does not begin the experiment")
