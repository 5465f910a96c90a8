"""One experiment: what the board is told, and what is refused before it is armed."""

import math
from dataclasses import replace

import pytest

from experiments.testbed.campaign import RIG
from rwjax.errors import InputError
from rwjax.link import messages
from rwjax.link.frames import Decoder
from rwjax.link.messages import Ack, Sample
from rwjax.link.play_experiment import play, play_values
from rwjax.link.port import LinkError
from rwjax.link.session import Session
from rwjax.planning.experiment import Experiment
from rwjax.rig.read import read_rig
from tests.link.ports import HELLO, SAMPLE, Scripted, wire
from tests.link.stubborn import Stubborn


@pytest.mark.parametrize(
    ("experiment", "said"),
    [
        (Experiment("square", 9.0, 2.0, 1.0, 1.0), "9 V about 2 V: the pulses reach -10 to 10 V; give less"),
        (Experiment("square", math.nan, 0.0, 1.0, 1.0), "nan V about 0 V: the pulses reach -10 to 10 V; give less"),
        (Experiment("square", 1e308, 0.0, 1.0, 1.0), "the pulses reach -10 to 10 V; give less"),
        (Experiment("square", 1.0, 0.0, math.inf, 1.0), "a period of inf s: has to lie between 0.04 and 655 s"),
        (Experiment("square", 1.0, 0.0, 0.01, 1.0), "a period of 0.01 s: has to lie between 0.04 and 655 s"),
        (Experiment("square", 1.0, 0.0, 1.0, 4000.0), "a length of 4000 s: has to lie between 0.01 and 3600 s"),
    ],
)
def test_experiments_that_the_board_cannot_play_are_refused(experiment: Experiment, said: str) -> None:
    with pytest.raises(LinkError, match=said):
        play(experiment, read_rig(RIG))


def test_an_esc_that_turns_one_way_has_the_whole_span() -> None:
    rig = read_rig(RIG)
    assert rig.pwm
    one_way = replace(rig, pwm=rig.pwm._replace(neutral_us=1000.0))
    assert play_values(Experiment("square", 9.0, 10.0, 1.0, 1.0), one_way)[2:4] == (900, 1000)
    with pytest.raises(LinkError, match="the pulses reach 0 to 20 V; give less"):
        play_values(Experiment("square", 11.0, 10.0, 1.0, 1.0), one_way)
    for reverses in (Experiment("square", 2.0, 1.5, 1.0, 1.0), Experiment("coast-down", -1.0, 0.0, 1.0, 1.0)):
        with pytest.raises(LinkError, match="the pulses reach 0 to 20 V; this ESC turns one way: add an offset"):
            play_values(reverses, one_way)
    assert play_values(Experiment("coast-down", 1.0, 0.0, 1.0, 1.0), one_way)[2:4] == (100, 0)


def test_a_neutral_pulse_near_an_end_is_said_for_what_it_is() -> None:
    rig = read_rig(RIG)
    assert rig.pwm
    near, high, no = (replace(rig, pwm=rig.pwm._replace(neutral_us=us)) for us in (1010.0, 1700.0, 1990.0))
    assert play_values(Experiment("square", 1.0, 1.1, 1.0, 1.0), near)[2:4] == (100, 110)
    with pytest.raises(LinkError, match=r"the pulses reach 0 to 19\.8 V; this ESC turns one way: add an offset"):
        play_values(Experiment("square", 2.0, 0.0, 1.0, 1.0), near)
    little = replace(rig, pwm=rig.pwm._replace(neutral_us=1100.0))  # pulses of 1050 us are there, and mean nothing
    for reverses in (Experiment("square", 1.0, 0.0, 1.0, 1.0), Experiment("coast-down", -1.0, 0.0, 1.0, 1.0)):
        with pytest.raises(LinkError, match="the pulses reach 0 to 18 V; this ESC turns one way: add an offset"):
            play_values(reverses, little)
    assert play_values(Experiment("coast-down", -6.0, 0.0, 1.0, 1.0), high)[2:4] == (-600, 0)
    with pytest.raises(LinkError, match="the pulses reach -6 to 6 V; give less"):  # though pulses of 1000 us are -14 V
        play_values(Experiment("coast-down", -7.0, 0.0, 1.0, 1.0), high)
    with pytest.raises(InputError, match="`drive.pwm.neutral_us` is 1990, and boards give no pulses above 2000 us"):
        play_values(Experiment("square", 0.1, 0.0, 1.0, 1.0), no)


def test_what_the_board_is_told_is_in_half_microseconds_and_ticks() -> None:
    """0.02 V/us: 2 V are 100 us, 200 half us; square is the second kind."""
    assert play_values(Experiment("square", 2.0, -0.5, 1.0, 2.5), read_rig(RIG)) == (0, 1, 200, -50, 100, 250)


def played(states: list[Sample]) -> Scripted:
    """A board that arms, takes the experiment, and then says `states`."""
    armed = SAMPLE._replace(state=messages.ARMED)
    said = [SAMPLE, Ack(2, messages.ARM, 0), armed, Ack(3, messages.PLAY, 0), *states, Ack(4, messages.DISARM, 0)]
    return Scripted([wire(HELLO, 0), *(wire(one, k + 1) for k, one in enumerate(said))])


SQUARE = Experiment("square", 2.0, 0.0, 1.0, 2.0)
ARMED = SAMPLE._replace(state=messages.ARMED)


def test_an_experiment_is_over_when_the_board_plays_no_more() -> None:
    port = played([ARMED, ARMED._replace(playing=1), ARMED._replace(playing=1), ARMED])
    play(SQUARE, read_rig(RIG))(Session(port))
    sent = [(frame.type, frame.body) for frame in Decoder().feed(port.written)]
    values = messages.COMMANDS[messages.PLAY].pack(*play_values(SQUARE, read_rig(RIG)))
    assert [kind for kind, _ in sent] == [messages.ASK, messages.ARM, messages.PLAY, messages.DISARM]
    assert sent[2][1] == values and port.pieces == []


@pytest.mark.parametrize(
    ("last", "said"),
    [
        (SAMPLE._replace(state=messages.FAULT, faults=4), "the board has stopped the experiment: battery low"),
        (SAMPLE, "the board has stopped the experiment: it is disarmed"),
    ],
)
def test_a_board_that_stops_an_experiment_is_said_to_have(last: Sample, said: str) -> None:
    with pytest.raises(LinkError, match=said):
        play(SQUARE, read_rig(RIG))(Session(played([ARMED._replace(playing=1), last])))


def test_a_latched_fault_is_cleared_where_that_is_asked() -> None:
    fault = SAMPLE._replace(state=messages.FAULT, faults=1)
    answers = [fault, Ack(2, messages.CLEAR, 0), SAMPLE, Ack(3, messages.ARM, 0), ARMED, Ack(4, messages.PLAY, 0)]
    said = [*answers, ARMED._replace(playing=1), ARMED, Ack(5, messages.DISARM, 0)]
    port = Scripted([wire(HELLO, 0), *(wire(one, k + 1) for k, one in enumerate(said))])
    play(SQUARE, read_rig(RIG), clear=True)(Session(port))
    assert messages.CLEAR in [frame.type for frame in Decoder().feed(port.written)]
    with pytest.raises(LinkError, match="fault: silence of the host; `rwjax run-experiment --clear` clears it"):
        play(SQUARE, read_rig(RIG))(Session(Scripted([wire(HELLO, 0), wire(fault, 1)])))


@pytest.mark.parametrize("samples_every", (1, 3))
@pytest.mark.parametrize(
    ("does_not", "said"),
    [
        ("arm", "the board does not arm"),
        ("begin", "the board does not begin the experiment"),
        ("end", "the board does not end an experiment of 2.6 s in time"),
    ],
)
def test_an_experiment_that_is_not_seen_to_begin_or_to_end_is_given_up(
    does_not: str, said: str, samples_every: int
) -> None:
    port = Stubborn(does_not, samples_every=samples_every)
    with pytest.raises(LinkError, match=said):
        play(SQUARE, read_rig(RIG))(Session(port))
    assert port.now < 12.0


def test_a_board_that_is_not_seen_to_end_and_hears_no_disarm_gets_no_more_heartbeats() -> None:
    port = Stubborn("end", "disarm")
    session = Session(port)
    with pytest.raises(LinkError):
        play(SQUARE, read_rig(RIG))(session)
    session.leave()
    left = port.now
    assert port.state == messages.ARMED and port.heard[-1][1] == messages.DISARM
    while port.now < left + 1.0:
        session.read()
    assert port.heard[-1][0] <= left and port.state == messages.FAULT  # neutral pulses


def test_a_board_plays_no_goals() -> None:
    with pytest.raises(LinkError, match="a board plays voltages, no goals"):
        play_values(Experiment("square", 0.5, 0.0, 4.0, 8.0, "goal_rad"), read_rig(RIG))
