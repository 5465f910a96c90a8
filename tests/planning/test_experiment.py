"""Experiments as tables of time and voltage: the board plays the same."""

import ctypes

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware.simavr.avr import desk as compiled
from rwjax.link.messages import EXPERIMENTS
from rwjax.planning.experiment import SHAPES, Experiment, length_in
from tests.boards import need_compiler
from tests.firmware import desk

HALF_US = 0.01  # V, at 0.02 V/us


@pytest.fixture(scope="module")
def c() -> ctypes.CDLL:
    need_compiler()
    return desk.load(compiled())


@given(
    kind=st.sampled_from(tuple(SHAPES)),
    amplitude=st.integers(-800, 800),
    offset=st.integers(-200, 200),
    period=st.integers(4, 1000),
    length=st.integers(4, 2000),
)
def test_the_table_of_a_run_is_what_the_firmware_plays(
    c: ctypes.CDLL, kind: str, amplitude: int, offset: int, period: int, length: int
) -> None:
    wanted = Experiment(kind, HALF_US * amplitude, HALF_US * offset, period / 100, length / 100)
    time, volts = wanted.command()
    assert np.allclose(np.diff(time), 0.01) and volts[-1] == 0.0 and len(volts) == 60 + length + 1
    played = desk.widths(c, desk.Experiment(EXPERIMENTS.index(kind), amplitude, offset, period, length), len(volts))
    assert np.abs(volts / HALF_US - played).max() <= 2.0 + abs(amplitude) / 127  # 127ths, and one rounding of them
    assert np.abs(volts).max() <= wanted.most_volts * (1.0 + 1e-12)


@given(kind=st.sampled_from(tuple(SHAPES)), length=st.integers(4, 99_999))
def test_a_note_tells_how_long_its_experiment_lasts(kind: str, length: int) -> None:
    assert length_in(Experiment(kind, -2.5, 0.1, 3.0, length / 100).words()) == length / 100


def test_other_words_tell_no_length() -> None:
    assert [length_in(words) for words in ("", "square", "by hand, some s", "square, 2.5.1 s")] == [None] * 4
