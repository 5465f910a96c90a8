"""Waiting for rest, and where the axis stands then."""

import pytest

from rwjax.link import rest
from rwjax.link.session import Session
from tests.link.ports import HELLO, SAMPLE, Scripted, resting, stream, wire
from tests.link.stubborn import Stubborn


def test_a_run_waits_until_nothing_has_counted_for_a_second() -> None:
    moving = [wire(SAMPLE._replace(tick=k, count_1=k), k + 1) for k in range(50)]
    still = [wire(SAMPLE._replace(tick=50 + k, count_1=50), 51 + k) for k in range(120)]
    port = Scripted([*stream(range(1))[:1], *moving, *still])
    session = Session(port)
    rest.settle(session)
    assert len(port.pieces) == 120 + 1 - rest.STILL_TICKS  # the last count before it is within the dither


def test_an_encoder_that_hangs_between_two_counts_is_at_rest_and_one_that_creeps_is_not() -> None:
    for counts, at_rest in (([0, 1], True), (range(0, 90_000, 1), False), ([0, 2], False)):
        said = [wire(SAMPLE._replace(tick=k, count_2=counts[k % len(counts)]), k + 1) for k in range(6_100)]
        session = Session(Scripted([*stream(range(1))[:1], *said]))
        assert bool(rest.at_rest(session)) != at_rest


def test_the_position_of_the_axis_is_followed_through_boards_that_start_anew() -> None:
    position = rest.AxisPosition(0, 0.001)
    seen = []
    for count, nonce in ((2**31 - 50, 7), (2**31 + 250, 7), (0, 8), (-400, 8), (20, 9)):
        position.look(resting(count, nonce))
        seen.append(position.angle)
    assert seen == pytest.approx([0.0, 0.3, 0.3, -0.1, -0.08])


def test_the_position_waits_for_the_axis_alone_and_is_lost_where_that_does_not_rest() -> None:
    turning = [wire(SAMPLE._replace(tick=k, count_1=40, count_2=5 * k), k + 1) for k in range(200)]
    position = rest.AxisPosition(0, 0.001)
    assert position.look(Session(Scripted([wire(HELLO, 0), *turning])))  # the wheel coasts
    assert not rest.AxisPosition(1, 0.001).look(Session(Scripted([wire(HELLO, 0), *turning * 40])))


def test_the_wait_for_rest_ends_by_the_clock_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rest, "LONGEST_WAIT", 500)
    port = Stubborn(samples_every=40)
    assert rest.settle(Session(port)) is None
    assert port.now == pytest.approx(11.0, abs=0.5)  # twice 5 s, and one more
