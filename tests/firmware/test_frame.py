"""Frames: the firmware's C against the host's Python, and both against damage."""

import ctypes
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.link import frames, messages
from tests.firmware import desk

FRAMES = st.builds(frames.Frame, st.integers(0, 255), st.integers(0, 2**16 - 1), st.binary(max_size=48))


def test_the_check_sum_is_the_published_one(c: ctypes.CDLL) -> None:
    assert frames.crc(b"123456789") == 0x29B1  # CRC-16/IBM-3740, catalogue of CRC algorithms
    assert c.frame_crc(b"123456789", 9) == 0x29B1


@given(frame=FRAMES)
def test_both_ends_write_the_same_bytes_and_read_them_back(c: ctypes.CDLL, frame: frames.Frame) -> None:
    wire = frames.encode(frame)
    buffer = ctypes.create_string_buffer(desk.WIRE_LONGEST)
    length = c.frame_encode(desk.frame(*frame), buffer)
    assert buffer.raw[:length] == wire
    assert wire.count(0) == 1 and len(wire) <= frames.LONGEST
    assert list(frames.Decoder().feed(wire)) == desk.Line(c).feed(wire) == [frame]


@given(first=FRAMES, junk=st.binary(max_size=200), last=FRAMES)
def test_a_good_frame_after_any_bytes_is_found_by_both(
    c: ctypes.CDLL, first: frames.Frame, junk: bytes, last: frames.Frame
) -> None:
    stream = frames.encode(first) + junk + b"\0" + frames.encode(last)
    python, line = frames.Decoder(), desk.Line(c)
    found = list(python.feed(stream))
    assert found[0] == first and found[-1] == last
    assert line.feed(stream) == found and line.damaged == python.damaged


@given(stream=st.binary(max_size=300), cuts=st.lists(st.integers(0, 300), max_size=5))
def test_pieces_of_any_length_give_the_same_frames(stream: bytes, cuts: list[int]) -> None:
    whole = frames.encode(frames.Frame(1, 2, b"abc")) + stream + b"\0" + frames.encode(frames.Frame(3, 4, b"\0\0"))
    ends = [0, *sorted(cut % len(whole) for cut in cuts), len(whole)]
    decoder = frames.Decoder()
    pieces = [frame for a, b in pairwise(ends) for frame in decoder.feed(whole[a:b])]
    assert pieces == list(frames.Decoder().feed(whole))


NONCE = 77


def damaged(wire: bytes, rng: np.random.Generator) -> bytes:
    """A frame with 1 to 8 bits turned, cut short, or with bytes swapped, doubled or put in."""
    kind, data = rng.integers(5), bytearray(wire)
    at = int(rng.integers(len(wire) - 1))
    if kind == 0:
        for bit in rng.choice(8 * len(data), rng.integers(1, 9), replace=False):
            data[bit // 8] ^= 1 << (bit % 8)
    elif kind == 1:
        del data[at : at + int(rng.integers(1, len(wire)))]
    elif kind == 2:
        other = int(rng.integers(len(wire) - 1))
        data[at], data[other] = data[other], data[at]
    elif kind == 3:
        data[at:at] = data[at : at + int(rng.integers(1, 9))]
    else:
        data[at:at] = rng.bytes(int(rng.integers(1, 9)))
    return bytes(data)


def test_ten_thousand_damaged_frames_none_taken_for_good_none_good_lost(c: ctypes.CDLL) -> None:
    """Damage leaves two things to say: what was intact is found, and what is found was sent.

    A swap or an inserted copy may leave the bytes as they were, and a deleted zero joins a frame with the next: what was
    sent is then a good frame between two zeros of the stream itself. CRC-16 lets about one in 2^16 of badly damaged frames
    pass: none of these does.
    """
    rng = np.random.default_rng(6)
    sent, stream, intact, harmed = set(), b"", [], 0
    for k in range(10_000):
        bad = frames.Frame(int(rng.integers(256)), k, rng.bytes(int(rng.integers(0, 20))))
        good = frames.Frame(int(rng.integers(256)), k, rng.bytes(int(rng.integers(0, 20))))
        broken = damaged(frames.encode(bad), rng)
        sent |= {bad, good}
        harmed += broken != frames.encode(bad)
        stream += broken + b"\0" + frames.encode(good)
        intact.append(good)
    found, line = list(frames.Decoder().feed(stream)), desk.Line(c)
    assert harmed > 9_000
    assert [frame for frame in found if frame not in sent] == []
    at = iter(found)
    assert all(frame in at for frame in intact)  # every intact frame, in order
    assert line.feed(stream) == found


def test_nothing_arms_but_an_arm_that_arrives_whole(c: ctypes.CDLL) -> None:
    """Half of 10 000 frames are ARM with the right nonce. All but one in fifty of these are damaged, lose their separator, or
    exchange their ends with the frame before; then neighbours are put out of order. Neither number nor state guards."""
    rng = np.random.default_rng(8)
    pieces, sent = [], set()
    for k in range(10_000):
        kind = (
            messages.ARM
            if k % 2
            else int(rng.choice([messages.ASK, messages.HEARTBEAT, messages.DISARM, messages.CLEAR]))
        )
        wire = messages.command(kind, k, *([NONCE] if kind == messages.ARM else []))
        if kind == messages.ARM:
            sent.add(wire[:-1])
        if kind == messages.ARM and k % 100 != 99:
            harm = rng.integers(4)
            if harm < 2:
                wire = damaged(wire, rng)
            elif harm == 2:
                wire = wire[:-1]
            else:
                before = pieces.pop()
                wire = before[:-4] + wire[-4:-1] + wire[:-4] + before[-4:]
        pieces.append(wire)
    for k in range(0, len(pieces) - 1, 7):
        pieces[k], pieces[k + 1] = pieces[k + 1], pieces[k]
    stream = b"".join(pieces)
    whole = [part for part in stream.split(b"\0") if part in sent]  # as they were sent, between two zeros
    assert 50 < len(whole) < 500
    machine, line, armed = desk.Machine(), desk.Line(c), []
    for found in line.feed(stream):
        c.machine_init(machine, NONCE)
        c.machine_command(machine, desk.frame(*found))
        assert machine.state in (messages.DISARMED, messages.ARMING)
        if machine.state == messages.ARMING:
            armed.append(frames.encode(frames.Frame(*found))[:-1])
    assert armed == whole and line.damaged > 2_000


def test_damaged_commands_never_arm(c: ctypes.CDLL) -> None:
    """ARM for another boot, and every one-bit error of the right one."""
    machine, line = desk.Machine(), desk.Line(c)
    c.machine_init(machine, 77)
    right = messages.command(messages.ARM, 1, 77)
    wrong = [messages.command(messages.ARM, 1, nonce) for nonce in (0, 76, 78, 2**32 - 1)]
    for bit in range(8 * (len(right) - 1)):
        flipped = bytearray(right)
        flipped[bit // 8] ^= 1 << (bit % 8)
        wrong.append(bytes(flipped) + b"\0")
    for wire in wrong:
        for found in line.feed(wire):
            assert c.machine_command(machine, desk.frame(*found)) != 0
        assert machine.state == messages.DISARMED
    (found,) = line.feed(right)
    assert c.machine_command(machine, desk.frame(*found)) == 0 and machine.state == messages.ARMING


@given(values=st.lists(st.integers(-(2**31), 2**31 - 1), min_size=2, max_size=2), small=st.integers(0, 255))
def test_a_sample_reads_as_the_board_wrote_it(c: ctypes.CDLL, values: list[int], small: int) -> None:
    machine, body = desk.Machine(), desk.Frame()
    c.machine_init(machine, 5)
    machine.faults, machine.missed, machine.damaged = small, 300 + small, 600 + small
    now = desk.Readings(
        values[0] % 2**32, tuple(values), (2000 + small, 4000 - small), 12_000 + small, small, 900 + small, small
    )
    c.machine_sample(machine, now, body)
    assert messages.message(frames.Frame(*desk.plain(body))) == messages.Sample(
        values[0] % 2**32, *values, 2000 + small, 4000 - small, 12_000 + small, 0, small, 0,
        300 + small, 900 + small, 600 + small, small,
    )  # fmt: skip


def test_hello_and_ack_read_as_the_board_wrote_them(c: ctypes.CDLL) -> None:
    machine, body = desk.Machine(), desk.Frame()
    c.machine_init(machine, 0x01020304)
    c.machine_hello(machine, 8, body)
    hello = messages.message(frames.Frame(*desk.plain(body)))
    assert isinstance(hello, messages.Hello)
    assert hello._replace(firmware=0) == messages.Hello(
        1, 0, 0x01020304, 8, 0, 0, 100, 2048, 2048, 2000, 3000, 4000, 100, 20, 630, 9000
    )
    c.machine_ack(desk.frame(messages.PULSE, 513, b""), 5, body)
    assert messages.message(frames.Frame(*desk.plain(body))) == messages.Ack(513, messages.PULSE, 5)


@pytest.mark.parametrize("kind", messages.COMMANDS)
def test_every_command_has_the_length_that_the_board_expects(c: ctypes.CDLL, kind: int) -> None:
    machine = desk.Machine()
    c.machine_init(machine, 0)
    size = messages.COMMANDS[kind].size
    for length in range(0, 20):
        wrong_length = c.machine_command(machine, desk.frame(kind, length + 1, bytes(length))) == 2
        assert wrong_length == (length != size)
