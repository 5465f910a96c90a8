"""Frames on the host's side; `tests/firmware/test_frame.py` holds them against the firmware's."""

import tracemalloc
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.link.frames import LONGEST, MAX_BODY, Decoder, Frame, crc, decode, encode

FRAMES = st.builds(Frame, st.integers(0, 255), st.integers(0, 2**16 - 1), st.binary(max_size=MAX_BODY))


def test_the_check_sum_is_the_published_one() -> None:
    assert crc(b"123456789") == 0x29B1  # CRC-16/IBM-3740, catalogue of CRC algorithms


def test_the_bytes_on_the_line_are_those_of_the_definition() -> None:
    """type 1, seq 0x0200, no body: 01 00 02 and its check sum, with every zero replaced by the way to the next one."""
    plain = b"\x01\x00\x02"
    low, high = crc(plain).to_bytes(2, "little")
    assert 0 not in (low, high)
    assert encode(Frame(1, 0x0200, b"")) == bytes([2, 1, 4, 2, low, high, 0])


@given(frame=FRAMES)
def test_a_frame_holds_no_zero_but_its_last_byte_and_reads_back_equal(frame: Frame) -> None:
    wire = encode(frame)
    assert wire.index(0) == len(wire) - 1 < LONGEST and decode(wire[:-1]) == frame


def test_the_longest_body_makes_the_longest_frame_and_a_longer_one_is_none() -> None:
    longest = Frame(255, 2**16 - 1, bytes(range(MAX_BODY)))
    wire = encode(longest)
    assert (MAX_BODY, len(wire)) == (48, LONGEST) and decode(wire[:-1]) == longest
    assert decode(encode(longest._replace(body=bytes(MAX_BODY + 1)))[:-1]) is None


@given(frame=FRAMES, data=st.data())
def test_a_turned_bit_is_noticed(frame: Frame, data: st.DataObject) -> None:
    wire = bytearray(encode(frame)[:-1])
    bit = data.draw(st.integers(0, 8 * len(wire) - 1))
    wire[bit // 8] ^= 1 << bit % 8
    assert decode(bytes(wire)) is None


@pytest.mark.parametrize("wire", [b"", b"\x01", b"\x05ab", b"\xff" * 60])
def test_what_cannot_be_a_frame_is_none(wire: bytes) -> None:
    assert decode(wire) is None


@pytest.mark.parametrize("size", range(3))
def test_bytes_too_few_for_a_type_and_a_number_are_none_whatever_their_check_sum(size: int) -> None:
    few = b"\x01\x02"[:size]
    plain = few + crc(few).to_bytes(2, "little")
    assert 0 not in plain and decode(bytes([len(plain) + 1]) + plain) is None


def test_damage_costs_one_frame_and_is_counted() -> None:
    one, two, three = (encode(Frame(1, k, b"body")) for k in range(3))
    decoder = Decoder()
    found = [f for piece in (one[:4], one[4:] + two[:3], b"\0" + three + b"\0\0") for f in decoder.feed(piece)]
    assert [f.seq for f in found] == [0, 2] and decoder.damaged == 1


@given(data=st.binary(max_size=500), cuts=st.lists(st.integers(0, 500), max_size=5))
def test_what_comes_out_does_not_depend_on_the_pieces(data: bytes, cuts: list[int]) -> None:
    at = [0, *sorted(cuts), len(data)]
    pieces, whole = Decoder(), Decoder()
    found = [frame for begin, end in pairwise(at) for frame in pieces.feed(data[begin:end])]
    assert found == list(whole.feed(data)) and pieces.damaged == whole.damaged


def test_between_zeros_where_nothing_stands_nothing_is_damaged() -> None:
    decoder = Decoder()
    assert [*decoder.feed(b"\0\0\0\x02a" + b"\0\0\x05ab\0\0")] == [] and decoder.damaged == 2


def test_a_frame_that_goes_on_beyond_its_length_is_damaged() -> None:
    decoder, frame = Decoder(), Frame(1, 2, bytes(range(MAX_BODY)))
    for piece in (encode(frame)[:-1], b"more", b"and more"):
        assert [*decoder.feed(piece)] == []
    assert [*decoder.feed(b"\0" + encode(frame))] == [frame] and decoder.damaged == 1


def test_a_line_without_a_zero_fills_no_memory() -> None:
    decoder = Decoder()
    tracemalloc.start()
    try:
        for _ in range(500):
            assert [*decoder.feed(bytes([7]) * 1000)] == []
        assert tracemalloc.get_traced_memory()[1] < 100_000
    finally:
        tracemalloc.stop()
