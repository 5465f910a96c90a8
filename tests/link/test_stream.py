"""Raw streams as stretches: every frame that arrived is in them, whatever was lost between."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rwjax.link.stream import stretches
from tests.link.ports import HELLO, stream, wrapped


def test_a_whole_stream_is_one_stretch() -> None:
    (found,), damaged = stretches(b"".join(stream(range(5, 300))))
    assert damaged == 0 and found.hello == HELLO and found.gaps() == []
    assert np.array_equal(found.tick, np.arange(5, 300))
    assert np.array_equal(found.count, np.outer(np.arange(5, 300), [3, -5]))


@given(start=st.integers(0, 2**32 - 1), first=st.integers(0, 2**16 - 1))
def test_counters_wrap_around_anywhere(start: int, first: int) -> None:
    ticks = range(start, start + 40)
    (found,), _ = stretches(b"".join(stream(ticks, first=first)))
    assert np.array_equal(found.tick - found.tick[0], np.arange(40))
    assert np.array_equal(found.count - found.count[0], np.outer(np.arange(40), [3, -5]))
    assert found.count[0, 0] == wrapped(3 * start)


@given(lost=st.sets(st.integers(1, 120)), cut=st.integers(0, 30), data=st.data())
def test_what_arrived_is_there_and_what_did_not_is_marked(lost: set[int], cut: int, data: st.DataObject) -> None:
    pieces = [piece for k, piece in enumerate(stream(range(122))) if k - 1 not in lost]
    damaged = data.draw(st.sets(st.integers(1, len(pieces) - 1), max_size=4))
    kept = [tick for k, tick in enumerate(t for t in range(122) if t not in lost) if k + 1 not in damaged]
    sent = b"".join(p[:3] + bytes([p[3] ^ 64 or 1]) + p[4:] if k in damaged else p for k, p in enumerate(pieces))
    found, n = stretches(sent + pieces[-1][:cut])  # and a frame that was being written when the power went
    assert np.concatenate([s.tick for s in found]).tolist() == kept
    assert n <= len(damaged)  # a turned bit of COBS may make two frames of it
    for stretch in found:
        steps = np.diff(stretch.tick)
        assert steps.max(initial=0) <= 11
        assert [(k, int(steps[k - 1]) - 1) for k, _ in stretch.gaps()] == stretch.gaps()
    ends = [(a.tick[-1], b.tick[0]) for a, b in pairwise(found)]
    assert all(b - a > 11 for a, b in ends)


def test_a_reset_ends_a_stretch() -> None:
    again = stream(range(30), HELLO._replace(nonce=8))
    found, _ = stretches(b"".join(stream(range(100, 150)) + again))
    assert [len(s.tick) for s in found] == [50, 30] and found[1].hello == HELLO._replace(nonce=8)
    found, _ = stretches(b"".join(stream(range(100, 150)) + again[1:]))  # without its HELLO, the ticks tell
    assert [len(s.tick) for s in found] == [50, 30]


def test_a_stream_that_begins_inside_a_frame_is_not_called_damaged() -> None:
    whole = b"".join(stream(range(20)))
    (found,), damaged = stretches(whole[7:])
    assert damaged == 0 and len(found.tick) == 20 and found.hello is None
