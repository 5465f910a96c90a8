"""The session: against a board in simavr, and against what a line may do to it."""

import pytest
import serial

from firmware.simavr.avr import F_CPU, Avr, build
from firmware.simavr.bench import Bench
from firmware.simavr.protocol_simavr import url
from firmware.simavr.spin import Spin, still
from rwjax.link import frames, messages
from rwjax.link.messages import Ack
from rwjax.link.port import LinkError
from rwjax.link.session import Session, faults
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
    assert session.samples()[-1].state == messages.ARMED
    session.command(messages.PULSE, 3200, 3000)
    for _ in range(100):
        last = session.samples()[-1]
    assert last.state == messages.ARMED and last.pulse_1 == 3200  # the heartbeats keep it so
    session.leave()
    for _ in range(5):
        last = session.samples()[-1]
    assert last.state == messages.DISARMED and last.pulse_1 == 3000 and session.lost == 0


def test_a_second_host_goes_on_with_the_numbers_of_the_first(bench: Bench) -> None:
    connected(bench).arm()
    second = connected(bench)
    assert second.hello and second.hello.heard
    second.command(messages.PULSE, 3100, 3000)  # not stale


def test_a_host_that_stops_reading_leaves_the_board_in_a_fault_that_is_named(bench: Bench) -> None:
    session = connected(bench)
    session.arm()
    bench.run(bench.avr.cycle + F_CPU // 2)
    session.read()
    assert faults(session.samples()[-1]) == "silence of the host"
    with pytest.raises(LinkError, match="fault: silence of the host"):
        session.arm()
    session.command(messages.CLEAR)
    session.arm()


def test_a_refusal_is_an_error_with_its_reason(bench: Bench) -> None:
    session = connected(bench)
    with pytest.raises(LinkError, match="the board refuses: not in this state"):
        session.command(messages.PULSE, 3200, 3000)
    session.arm()
    with pytest.raises(LinkError, match="the board refuses: out of range"):
        session.command(messages.PULSE, 5000, 3000)


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


def test_heartbeats_only_from_the_session_that_armed() -> None:
    """Whoever only listens must not keep the ESCs driven for a host that has died."""

    def beats(arms: bool, state: int) -> int:
        pieces = [
            wire(HELLO, 0),
            wire(SAMPLE, 1),
            wire(Ack(2, messages.ARM, 0), 2),
            wire(SAMPLE._replace(state=state), 3),
        ]
        port = Scripted([*pieces, *(wire(SAMPLE._replace(tick=k, state=state), k + 3) for k in range(1, 50))])
        session = Session(port)
        session.greet()
        if arms:
            session.arm()
        while port.pieces:
            session.read()
        session.leave()
        return sum(frame.type == messages.HEARTBEAT for frame in frames.Decoder().feed(port.written))

    assert beats(False, messages.ARMED) == beats(False, messages.DISARMED) == 0
    assert beats(True, messages.ARMED) == 10


def test_a_passive_host_does_not_keep_a_board_armed(bench: Bench) -> None:
    connected(bench).arm()
    passive = connected(bench)
    for _ in range(40):
        last = passive.samples()[-1]
    assert last.state == messages.FAULT and faults(last) == "silence of the host"


@pytest.mark.parametrize("size", (1, 7, 5000))
def test_waiting_does_not_depend_on_the_size_of_reads(size: int) -> None:
    samples = [wire(SAMPLE._replace(tick=k), k) for k in range(300)]
    whole = b"".join([*samples[:4], wire(HELLO, 4), *samples[5:150], wire(Ack(2, messages.PULSE, 0), 150)])
    session = Session(Scripted([whole[k : k + size] for k in range(0, len(whole), size)]))
    session.greet()
    if size < 5000:
        session.command(messages.PULSE, 3000, 3000)


def test_a_line_that_never_says_anything_sensible_ends_the_wait() -> None:
    for before in ([], stream(range(3))):
        session = Session(Scripted([*before, *[b"t;pos1;pos2;speed2\r\n\0"] * 10_000]))
        with pytest.raises(LinkError, match=r"no board of the testbed answers; is this the port"):
            session.greet()
            while True:
                session.samples()


def test_a_fault_while_arming_is_named() -> None:
    fault = SAMPLE._replace(state=messages.FAULT, faults=4)
    session = Session(Scripted([*stream(range(1)), wire(Ack(2, messages.ARM, 0), 2), wire(fault, 3)]))
    session.greet()
    with pytest.raises(LinkError, match="scripted: the board does not arm: battery low"):
        session.arm()


def test_answers_of_a_newer_firmware_are_passed_over() -> None:
    odd = [wire(SAMPLE._replace(state=4), 1), wire(Ack(2, messages.PULSE, 7), 2), wire(Ack(2, messages.PULSE, 4), 3)]
    session = Session(Scripted([wire(HELLO, 0), *odd]))
    session.greet()
    with pytest.raises(LinkError, match="the board refuses: wrong nonce"):
        session.command(messages.PULSE, 3000, 3000)


def test_another_tick_is_refused() -> None:
    with pytest.raises(LinkError, match="the firmware ticks at 200 Hz, this rwjax at 100 Hz"):
        Session(Scripted([wire(HELLO._replace(tick_hz=200), 0)])).greet()
