"""The session: against a board in simavr, and against what a line may do to it."""

import pytest
import serial

from firmware.simavr.avr import F_CPU, Avr, build
from firmware.simavr.bench import Bench
from firmware.simavr.protocol_simavr import url
from firmware.simavr.spin import Spin, still
from rwjax.link import frames
from rwjax.link.session import LinkError, Session, faults
from tests.boards import need_simavr
from tests.link.ports import HELLO, SAMPLE, Scripted, stream, wire


@pytest.fixture
def bench() -> Bench:
    need_simavr()
    return Bench(Avr(build()), Spin(still, still))


def connected(bench: Bench) -> Session:
    session = Session(serial.serial_for_url(url(bench)))
    session.greet()
    return session


def test_the_board_says_who_it_is_and_arms(bench: Bench) -> None:
    session = connected(bench)
    assert session.hello and session.hello.nonce == 1 and session.hello.tick_hz == 100
    session.arm()
    assert session.samples()[-1].state == frames.ARMED
    session.command(frames.PULSE, 3200, 3000)
    for _ in range(100):
        last = session.samples()[-1]
    assert last.state == frames.ARMED and last.pulse_1 == 3200  # the heartbeats keep it so
    session.leave()
    for _ in range(5):
        last = session.samples()[-1]
    assert last.state == frames.DISARMED and last.pulse_1 == 3000 and session.lost == 0


def test_a_second_host_goes_on_with_the_numbers_of_the_first(bench: Bench) -> None:
    connected(bench).arm()
    second = connected(bench)
    assert second.hello and second.hello.heard
    second.command(frames.PULSE, 3100, 3000)  # not stale


def test_a_host_that_stops_reading_leaves_the_board_in_a_fault_that_is_named(bench: Bench) -> None:
    session = connected(bench)
    session.arm()
    bench.run(bench.avr.cycle + F_CPU // 2)
    session.read()
    assert faults(session.samples()[-1]) == "silence of the host"
    with pytest.raises(LinkError, match="fault: silence of the host"):
        session.arm()
    session.command(frames.CLEAR)
    session.arm()


def test_a_refusal_is_an_error_with_its_reason(bench: Bench) -> None:
    session = connected(bench)
    with pytest.raises(LinkError, match="the board refuses: not in this state"):
        session.command(frames.PULSE, 3200, 3000)
    session.arm()
    with pytest.raises(LinkError, match="the board refuses: out of range"):
        session.command(frames.PULSE, 5000, 3000)


def test_a_port_where_nothing_or_something_else_answers() -> None:
    for pieces in ([], [b"t;pos1;pos2;speed2\r\n"] * 50):
        with pytest.raises(LinkError, match=r"no board of the testbed answers; is this the port"):
            Session(Scripted(pieces)).greet()


def test_another_protocol_is_refused() -> None:
    with pytest.raises(LinkError, match="the firmware speaks protocol 2, this rwjax 1; update the older"):
        Session(Scripted([wire(HELLO._replace(protocol=2), 0)])).greet()


def test_a_board_that_falls_silent_or_starts_anew_ends_the_session() -> None:
    session = Session(Scripted(stream(range(5))))
    session.greet()
    with pytest.raises(LinkError, match="the board is silent for 1 s; is it on"):
        while True:
            session.samples()
    session = Session(Scripted([*stream(range(5)), wire(HELLO._replace(nonce=8), 6)]))
    session.greet()
    with pytest.raises(LinkError, match="the board has started anew"):
        while True:
            session.samples()


def test_lost_frames_are_counted() -> None:
    session = Session(Scripted(stream([0, 1, 2, 7, 8, 300])))
    session.greet()
    while session.samples()[-1].tick != 300:
        pass
    assert session.lost == 4 + 291


def test_every_byte_is_kept_before_it_is_understood() -> None:
    kept: list[bytes] = []

    def full(data: bytes) -> None:
        kept.append(data)
        if len(kept) == 4:
            raise LinkError("disk full")

    pieces = stream(range(9))
    session = Session(Scripted(pieces), full)
    session.greet()
    with pytest.raises(LinkError, match="disk full"):
        while True:
            session.samples()
    assert b"".join(kept) == b"".join(pieces[:4])


def test_heartbeats_only_while_the_board_is_armed() -> None:
    beats = {}
    for state in (frames.DISARMED, frames.ARMED):
        pieces = [wire(HELLO, 0), *(wire(SAMPLE._replace(tick=k, state=state), k + 1) for k in range(50))]
        port = Scripted(pieces)
        session = Session(port)
        session.greet()
        for _ in range(50):
            session.samples()
        sent = list(frames.Decoder().feed(port.written))
        beats[state] = sum(frame.type == frames.HEARTBEAT for frame in sent)
    assert beats == {frames.DISARMED: 0, frames.ARMED: 10}
