"""Law, experiments, counts and states of the firmware, compiled for this machine, against independent Python."""

import ctypes
import struct
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from experiments.testbed.campaign import FOLDER
from firmware.simavr import avr
from firmware.simavr.avr import desk as compiled
from firmware.wave import TARGET, text
from rwjax.link import messages
from rwjax.planning.experiment import wave
from tests.boards import need_compiler
from tests.firmware import desk

INT32, INT16 = st.integers(-(2**31), 2**31 - 1), st.integers(-(2**15), 2**15 - 1)
NEUTRAL, SPAN, REST = 3000, 1000, 60
KINDS = ("coast-down", "square", "triangle", "staircase", "multisine")


def wrapped(value: int) -> int:
    return (value + 2**31) % 2**32 - 2**31


@given(reference=INT32, count=INT32, moved=INT32, kp=INT16, kd=INT16, breakaway=st.integers(0, SPAN))
def test_the_law_is_the_pd_law_in_whole_numbers(
    c: ctypes.CDLL, reference: int, count: int, moved: int, kp: int, kd: int, breakaway: int
) -> None:
    error, rate = (int(np.clip(v, -16383, 16383)) for v in (wrapped(reference - count), moved))
    u = np.clip((kp * error - kd * rate) / 256, -SPAN, SPAN)
    u = np.trunc(u) + np.sign(np.trunc(u)) * breakaway
    law = desk.Law(reference, kp, kd, breakaway)
    assert c.law_width(law, count, moved, SPAN) == np.clip(u, -SPAN, SPAN)


def test_one_count_of_speed_is_felt(c: ctypes.CDLL) -> None:
    """The thesis's listing divides the difference of counts by a whole number larger than it: always 0."""
    assert c.law_width(desk.Law(0, 0, 256, 0), 0, 1, SPAN) == -1
    assert c.law_width(desk.Law(0, 0, 256, 0), 0, -1, SPAN) == 1


@given(start=INT32, steps=st.lists(INT16, max_size=50))
def test_counts_are_widened_through_any_wrap(c: ctypes.CDLL, start: int, steps: list[int]) -> None:
    count, exact = start, start
    for step in steps:
        exact += step
        count = c.decode_widen(count, exact % 2**16)
        assert count == wrapped(exact)


def unit(kind: str, phase: float) -> float:
    """What an experiment of amplitude 1 plays at a share of its period, exactly."""
    if kind == "square":
        return 1.0 if phase < 0.5 else -1.0
    if kind == "triangle":
        return float(2 / np.pi * np.arcsin(np.sin(2 * np.pi * phase)))
    if kind == "staircase":
        step = int(16 * phase)
        return -1.0 + (step if step <= 8 else 16 - step) / 4.0
    return wave()[int(256 * phase)] / 127.0


@given(
    kind=st.integers(1, 4),
    amplitude=st.integers(-SPAN, SPAN),
    offset=st.integers(-100, 100),
    period=st.integers(2, 5000).map(lambda half: 2 * half),
    ticks=st.integers(0, 20_000),
)
def test_experiments_have_their_textbook_shape(
    c: ctypes.CDLL, kind: int, amplitude: int, offset: int, period: int, ticks: int
) -> None:
    experiment = desk.Experiment(kind, amplitude, offset, period, 10_000)
    played = c.experiment_width(experiment, ticks)
    if not REST <= ticks < REST + 10_000:
        assert played == 0
        return
    exact = offset + amplitude * unit(KINDS[kind], ((ticks - REST) % period) / period)
    assert abs(played - exact) <= 2.0 + abs(amplitude) / 127  # a 127th of the amplitude, and one rounding of it


@given(amplitude=st.integers(-SPAN, SPAN), drive=st.integers(4, 2**16 - 1))
def test_a_coast_down_drives_and_lets_go(c: ctypes.CDLL, amplitude: int, drive: int) -> None:
    experiment = desk.Experiment(0, amplitude, 0, drive, 100_000)
    edges = [c.experiment_width(experiment, tick) for tick in (REST - 1, REST, REST + drive - 1, REST + drive)]
    assert edges == [0, amplitude, amplitude, 0]


def test_the_wave_is_the_one_that_is_computed() -> None:
    assert TARGET.read_text() == text()
    spectrum = np.abs(np.fft.rfft(wave())) / 128
    tones = (1, 3, 5, 8, 13, 21)
    assert spectrum[list(tones)] == pytest.approx(np.full(6, spectrum[1]), rel=0.02)  # rounding to 127ths
    assert np.delete(spectrum, tones).max() < 0.02 * spectrum[1]


@cache
def library() -> ctypes.CDLL:
    """As the fixture `c`, for a state machine, which takes none."""
    return desk.load(compiled())


class States(RuleBasedStateMachine):
    """Any commands and readings in any order: the outputs move only where they may."""

    def __init__(self) -> None:
        super().__init__()
        need_compiler()
        self.c, self.machine, self.now = library(), desk.Machine(), desk.Readings()
        self.nonce = 1234
        self.c.machine_init(self.machine, self.nonce)
        self.now.battery, self.number, self.first = 12_000, 0, 1
        self.silent = self.neutral_ticks = 0  # ticks since a command was accepted; with neutral pulses while arming

    def send(self, kind: int, body: bytes) -> int:
        self.number = (self.number + 1) % 2**16
        result = self.c.machine_command(self.machine, desk.frame(kind, self.number, body))
        self.silent = 0 if result == 0 else self.silent
        return result

    @rule(right=st.booleans())
    def arm(self, right: bool) -> None:
        before = self.machine.state
        result = self.send(messages.ARM, struct.pack("<I", self.nonce + (not right)))
        assert (result == 0) == (right and before == messages.DISARMED)
        self.neutral_ticks = 0 if result == 0 else self.neutral_ticks

    @precondition(lambda self: self.machine.state == messages.DISARMED)
    @rule()
    def all_the_way(self) -> None:
        """A second of heartbeats; without it nothing here would ever be armed."""
        self.arm(True)
        for _ in range(10):
            assert self.machine.state == messages.ARMING
            self.plain(messages.HEARTBEAT)
            self.run(10, 0, 0, 12_000)
        assert self.machine.state == messages.ARMED

    @rule(kind=st.sampled_from((messages.HEARTBEAT, messages.DISARM, messages.CLEAR)))
    def plain(self, kind: int) -> None:
        before = self.machine.state
        self.send(kind, b"")
        if kind == messages.DISARM:
            assert self.machine.state == (messages.FAULT if before == messages.FAULT else messages.DISARMED)
        if kind == messages.CLEAR and before == messages.FAULT:
            assert self.machine.state == messages.DISARMED and self.machine.faults == 0

    @rule(a=st.integers(1900, 4100), b=st.integers(1900, 4100))
    def pulse(self, a: int, b: int) -> None:
        before = list(self.machine.width)
        legal = all(NEUTRAL - SPAN <= width <= NEUTRAL + SPAN for width in (a, b))
        result = self.send(messages.PULSE, struct.pack("<HH", a, b))
        assert result == (5 if not legal else 0 if self.machine.state == messages.ARMED else 6)
        assert list(self.machine.width) == ([a, b] if result == 0 else before)  # nothing of a command that is refused

    @rule(values=st.tuples(st.integers(0, 2), INT32, INT16, INT16, st.integers(0, 1100)))
    def hold(self, values: tuple[int, ...]) -> None:
        legal = values[0] < 2 and values[4] <= SPAN
        result = self.send(messages.HOLD, struct.pack("<BihhH", *values))
        assert result == (5 if not legal else 0 if self.machine.state == messages.ARMED else 6)

    @rule(values=st.tuples(st.integers(0, 2), st.integers(0, 5), INT16, INT16, st.integers(0, 99), st.integers(0, 500)))
    def play(self, values: tuple[int, ...]) -> None:
        self.send(messages.PLAY, struct.pack("<BBhhHI", *values))

    @rule(body=st.binary(max_size=20), kind=st.integers(0, 255))
    def anything(self, body: bytes, kind: int) -> None:
        if kind != messages.ARM:
            self.send(kind, body)

    @rule(
        ticks=st.one_of(st.integers(1, 20), st.integers(1, 120)),
        first=st.integers(-640, 640),
        second=st.integers(-640, 640),
        battery=st.sampled_from((12_000, 12_000, 8_000)),
    )
    def run(self, ticks: int, first: int, second: int, battery: int) -> None:
        for _ in range(ticks):
            before, boot = self.machine.state, self.first
            self.now.tick += 1
            for k, moved in enumerate((first, second)):
                self.now.count[k] = wrapped(self.now.count[k] + moved)
            self.now.battery = battery
            self.c.machine_tick(self.machine, self.now, boot)
            self.first = 0
            self.silent += 1
            self.neutral_ticks += 1
            if before == messages.ARMING and self.machine.state == messages.ARMED:
                assert self.neutral_ticks >= 100  # the ESCs have had their second of neutral
            if before != messages.ARMED and before != messages.ARMING:
                assert self.machine.state == before  # nothing arms, nor leaves a fault, by itself
            if before in (messages.ARMING, messages.ARMED) and max(abs(first), abs(second)) > 630 and not boot:
                assert self.machine.state == messages.FAULT and self.machine.faults & 2

    @invariant()
    def outputs(self) -> None:
        if self.machine.state != messages.ARMED:
            assert list(self.machine.width) == [NEUTRAL, NEUTRAL]
        else:
            assert self.silent <= 20
        assert all(NEUTRAL - SPAN <= width <= NEUTRAL + SPAN for width in self.machine.width)
        assert (self.machine.state == messages.FAULT) == bool(self.machine.faults)


test_states = States.TestCase


def test_a_command_that_comes_twice_or_late_is_refused(c: ctypes.CDLL) -> None:
    machine = desk.Machine()
    c.machine_init(machine, 0)
    beat = [
        c.machine_command(machine, desk.frame(messages.HEARTBEAT, seq, b"")) for seq in (65535, 65535, 2, 65535, 1, 3)
    ]
    assert beat == [0, 3, 0, 3, 3, 0]


@pytest.fixture
def armed(c: ctypes.CDLL) -> desk.Machine:
    """A machine after a second of neutral pulses, at count 0."""
    machine, now = desk.Machine(), desk.Readings(battery=12_000)
    c.machine_init(machine, 0)
    assert c.machine_command(machine, desk.frame(messages.ARM, 1, bytes(4))) == 0
    for k in range(100):
        assert c.machine_command(machine, desk.frame(messages.HEARTBEAT, k + 2, b"")) == 0
        c.machine_tick(machine, now, k == 0)
    assert machine.state == messages.ARMED
    return machine


@pytest.mark.parametrize("sense", (1, -1))
@pytest.mark.parametrize("encoder", (0, 1))
@pytest.mark.parametrize(
    ("counts", "missed", "faults"),
    [
        (630, 0, 0),
        (631, 0, 2),
        (0, 2, 0),
        (0, 3, 8),
        (2 * 630, 1, 0),  # in two ticks, one of which nobody answered
        (2 * 631, 1, 2),
        (4 * 631, 3, 2 | 8),
    ],
)
def test_an_armed_board_faults_at_its_limits_and_not_below(
    c: ctypes.CDLL, armed: desk.Machine, encoder: int, sense: int, counts: int, missed: int, faults: int
) -> None:
    now = desk.Readings(tick=200, battery=12_000, missed=missed)
    now.count[encoder] = sense * counts
    c.machine_tick(armed, now, 0)
    assert armed.faults == faults and armed.state == (messages.FAULT if faults else messages.ARMED)
    assert armed.missed == missed and armed.moved[encoder] == sense * (counts // (missed + 1))


@pytest.mark.parametrize(("half_us", "good"), [(1998, False), (2000, True), (2120, True), (3600, True), (3980, False)])
def test_firmware_whose_neutral_pulse_leaves_next_to_nothing_does_not_compile(half_us: int, good: bool) -> None:
    need_compiler()
    source = Path(avr.FIRMWARE, "rwbed", "machine.c")
    done = subprocess.run(
        ["cc", "-std=gnu99", "-fsyntax-only", f"-DPULSE_NEUTRAL={half_us}", source], capture_output=True, text=True
    )
    assert (done.returncode == 0) == good and ("PULSE_NEUTRAL: not below PULSE_MIN" in done.stderr) != good


def test_the_logs_in_data_were_recorded_with_this_firmware(c: ctypes.CDLL) -> None:
    machine, hello = desk.Machine(), desk.Frame()
    c.machine_init(machine, 0)
    c.machine_hello(machine, 0, hello)
    sources = int.from_bytes(desk.plain(hello)[2][1:5], "little")
    logs = sorted(FOLDER.glob("*.csv"))
    assert len(logs) == 7
    for log in logs:
        head = log.read_text().partition("time_s")[0]
        assert f"# firmware: {sources:08x}\n" in head, f"{log.name}: run python -m experiments.testbed.make_data"
