"""Streams of a board damaged: frames lost, twice, in another order, with any numbers; bytes changed on the line."""

from hypothesis import strategies as st

from rwjax.link import frames
from rwjax.link.frames import Frame
from rwjax.link.messages import MESSAGES
from tests.damage.values import spoilt, texts

EXTREMES = (0, 1, 2**7 - 1, 2**8 - 1, 2**15 - 1, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1)


@st.composite
def _frame(draw: st.DrawFn) -> bytes:
    """A frame of any type, mostly one of a board's with a body that is as long as it should be."""
    kind = draw(st.sampled_from((*MESSAGES, *MESSAGES, *MESSAGES, 0, 1, 8, 0x84, 0xFF)))
    size = MESSAGES[kind][1].size if kind in MESSAGES else draw(st.integers(0, frames.MAX_BODY))
    size = draw(st.sampled_from((size, size, size, max(size - 1, 0), min(size + 1, frames.MAX_BODY))))
    filled = bytes([draw(st.sampled_from((0, 1, 127, 128, 255)))]) * size
    body = draw(st.binary(min_size=size, max_size=size)) if draw(st.booleans()) else filled
    return frames.encode(Frame(kind, draw(st.sampled_from(EXTREMES)) % 2**16, body))


@st.composite
def damaged(draw: st.DrawFn, whole: list[bytes]) -> bytes:
    """The bytes of a stream after a few changes."""
    pieces = list(whole)
    for _ in range(draw(st.integers(1, 4))):
        way, k = draw(st.integers(0, 6)), draw(st.integers(0, len(pieces)))
        if way == 0:
            pieces[k : k + draw(st.sampled_from((1, 5, 15)))] = []
        elif way == 1:
            pieces[k:k] = pieces[k : k + draw(st.sampled_from((1, 2, 20)))]
        elif way == 2:
            pieces[k:k] = [draw(_frame())]
        elif way == 3:
            end = k + draw(st.sampled_from((2, 5)))
            pieces[k:end] = reversed(pieces[k:end])
        elif way == 4 and k < len(pieces):
            pieces[k] = draw(spoilt(pieces[k]))
        elif way == 5:
            pieces[k:k] = [draw(st.binary(max_size=80))]
        else:
            pieces = [piece.replace(b"\0", b"") if n == k else piece for n, piece in enumerate(pieces)]
    return b"".join(pieces)


@st.composite
def notes(draw: st.DrawFn) -> bytes:
    """The notes beside a stream."""
    pairs = draw(st.lists(st.tuples(texts(), texts()), max_size=3))
    said = "".join(f"{key}: {value}\n" for key, value in (("rig", "testbed"), *pairs))
    return said.encode("utf-8", "surrogatepass")
