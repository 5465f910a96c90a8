"""The session: against a board in simavr, and against what a line may do to it."""

import threading
import time
from contextlib import suppress

import pytest
import serial
from hypothesis import given
from hypothesis import strategies as st

from firmware.simavr.avr import F_CPU, Avr, build
from firmware.simavr.bench import Bench
from firmware.simavr.protocol_simavr import url
from firmware.simavr.spin import Spin, still
from rwjax.link import frames, messages
from rwjax.link.messages import Ack
from rwjax.link.port import LinkError
from rwjax.link.session import Session, faults
from tests.boards import need_simavr
from tests.damage.frames import damaged
from tests.link.ports import HELLO, SAMPLE, Scripted, stream, wire
from tests.link.stubborn import Stubborn


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


@pytest.mark.parametrize("acks_every", (1, 9, 99))
def test_a_board_that_answers_and_sends_no_samples_ends_the_session(acks_every: int) -> None:
    port = Stubborn(samples_every=None, acks_every=acks_every)
    session = Session(port)
    session.greet()
    with pytest.raises(LinkError, match="scripted: the board answers and has sent no sample for 1 s"):
        session.samples()
    assert port.now < 2.5


@pytest.mark.parametrize("acks_every", (1, 30, None))
def test_a_board_that_answers_everything_but_who_it_is_is_no_board(acks_every: int | None) -> None:
    port = Stubborn("greet", samples_every=None, acks_every=acks_every)
    with pytest.raises(LinkError, match="no board of the testbed answers"):
        Session(port).greet()
    assert 2.0 < port.now < 15.0  # a bootloader takes up to 2 s


@pytest.mark.parametrize("samples_every", (1, 30, 90))
def test_a_command_that_nothing_answers_ends_though_samples_come_slowly(samples_every: int) -> None:
    port = Stubborn("acknowledge", samples_every=samples_every)
    session = Session(port)
    session.greet()
    with pytest.raises(LinkError, match="the board does not answer a command"):
        session.command(messages.PULSE, 3000, 3000)
    assert 3.9 < port.now < 12.0
    assert [kind for _, kind in port.heard] == [messages.ASK, messages.PULSE, messages.PULSE]


@pytest.mark.parametrize("samples_every", (1, 30))
def test_a_board_that_takes_the_command_and_is_never_armed_is_given_up(samples_every: int) -> None:
    port = Stubborn("arm", samples_every=samples_every)
    session = Session(port)
    with pytest.raises(LinkError, match="the board does not arm"):
        session.arm()
    assert port.now < 12.0 and messages.HEARTBEAT not in [kind for _, kind in port.heard]


def test_a_wait_is_counted_in_samples_and_ended_by_the_clock() -> None:
    """At full rate so many samples as ticks; a board at a tenth of it gets twice the time and a second."""
    for every, count in ((1, 500), (10, 110)):
        port = Stubborn(samples_every=every)
        session = Session(port)
        session.greet()
        start = port.now
        samples = [m for m in session.coming(500) if isinstance(m, messages.Sample)]
        assert len(samples) == pytest.approx(count, abs=2)
        assert port.now - start == pytest.approx(0.01 * every * count, abs=0.2)


def test_a_host_that_was_suspended_does_not_blame_the_board() -> None:
    port = Stubborn()
    session = Session(port)
    session.greet()
    for _ in session.coming(50):
        port.now += 100.0 if port.tick == 20 else 0.0
    assert port.tick >= 50 and session.samples()


def test_a_frame_that_comes_twice_is_counted_and_passed_on_once() -> None:
    seen = []
    pieces = stream([0, 1, 2, 2, 2, 3, 5])
    session = Session(
        Scripted([piece for piece in pieces for _ in range(2)]), watch=lambda _, sample: seen.append(sample)
    )
    session.greet()
    while session.samples()[-1].tick != 5:
        pass
    assert session.lost == 1 and [sample.tick for sample in seen] == [0, 1, 2, 3, 5]


def test_frames_that_come_late_are_not_counted_as_lost_ones() -> None:
    pieces = stream(range(10))
    session = Session(Scripted([*pieces[:4], pieces[5], pieces[4], *pieces[3:]]))
    session.greet()
    while session.samples()[-1].tick != 9:
        pass
    assert session.lost == 1  # of the two that change places


def test_the_session_ends_at_the_next_read_where_it_is_told_to() -> None:
    told = []
    session = Session(Stubborn(), watch=lambda _, sample: told.append(sample), stop=lambda: len(told) == 7)
    session.greet()
    with pytest.raises(KeyboardInterrupt):
        while True:
            session.samples()
    assert len(told) == 7


def test_a_line_that_takes_nothing_does_not_keep_the_host(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the other end of a USB line has died, the system waits for ever to have its bytes taken."""
    released = threading.Event()
    monkeypatch.setattr("rwjax.link.session.FLUSH_S", 0.02)
    port = Stubborn()
    monkeypatch.setattr(port, "flush", released.wait)
    session = Session(port)
    session.greet()
    before = time.monotonic()
    session.leave()
    assert time.monotonic() - before < 5.0 and port.heard[-1][1] == messages.DISARM
    released.set()


@given(sent=damaged(stream(range(60))), size=st.integers(1, 400))
def test_whatever_comes_a_session_ends_and_says_why(sent: bytes, size: int) -> None:
    """No other error, no wait without an end, and no more lost than numbers can be missing."""
    port = Scripted([sent[k : k + size] for k in range(0, len(sent), size)])
    session = Session(port)
    with suppress(LinkError):
        session.greet()
        session.arm()
        session.command(messages.PULSE, 3000, 3000)
    with suppress(LinkError):
        for _ in session.coming(100):
            pass
    session.leave()
    assert port.now < 60.0 and 0 <= session.lost < 2**15 * 80
    assert [*frames.Decoder().feed(port.written)][-1].type == messages.DISARM
