"""The compiled firmware in simavr: pulses, tick, encoders, line, states."""

import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from firmware.simavr.avr import CYCLES_PER_TICK, Avr, build
from firmware.simavr.bench import Bench, counts
from firmware.simavr.host import Host
from firmware.simavr.spin import Spin, constant, still, swinging
from firmware.simavr.tables import OVERFLOW, sizes
from rwjax.link import messages
from rwjax.link.stream import stretches
from tests.boards import need_arduino, need_simavr
from tests.firmware import desk

LIMITS = {"atmega328p": (32_768, 2_048), "atmega2560": (262_144, 8_192)}  # bytes of flash and RAM
TCCR0B, TCCR2B = 0x45, 0xB1  # addresses in the data space
PULSE_ERROR = 0.01  # us: the timer's own edges, nothing in between


def host(elf: Path, first=still, second=still, mcu: str = "atmega328p", **more) -> Host:
    return Host(Bench(Avr(elf, mcu, **more), Spin(first, second)))


@pytest.mark.parametrize("mcu", LIMITS)
def test_it_compiles_without_warnings_and_fits(mcu: str) -> None:
    need_simavr()
    (flash, ram), (most_flash, most_ram) = sizes(mcu), LIMITS[mcu]
    assert flash < most_flash / 4 and ram < most_ram / 2  # the rest is stack


@pytest.mark.parametrize("mcu", LIMITS)
def test_the_arduino_ide_links_the_same_program_and_nothing_of_its_core(mcu: str) -> None:
    need_arduino()

    def functions(elf: Path) -> set[str]:
        out = subprocess.run(["avr-nm", elf], check=True, capture_output=True, text=True).stdout
        return {
            name
            for _, kind, name in (row.split()[-3:] for row in out.splitlines() if len(row.split()) == 3)
            if kind in "Tt"
        }

    ours, ide = (build(mcu=mcu, by=by) for by in ("rwbed", "arduino"))
    vectors = {name for name in functions(ours) if name.startswith("__vector")}
    assert vectors == {name for name in functions(ide) if name.startswith("__vector")}  # no timer 0 of its own
    assert "main" in functions(ide) and not functions(ide) & {
        "init",
        "initVariant",
        "setup",
        "loop",
        "millis",
        "serialEventRun",
    }
    h = host(ide, mcu=mcu)
    h.arm()  # and it runs


def test_a_variant_is_compiled_anew_for_other_flags() -> None:
    need_simavr()
    one, other = (build("test", f"-DFIRST_SEQ={seq}") for seq in (1, 2))
    assert one.read_bytes() != other.read_bytes()


def test_no_text_floats_or_heap_are_linked(elf: Path) -> None:
    """The thesis's listing builds `String`s inside an interrupt."""
    names = subprocess.run(["avr-nm", elf], check=True, capture_output=True, text=True).stdout
    assert "__vector_13" in names
    for wrong in ("malloc", "printf", "__addsf3", "__mulsf3", "dtostrf", "_ZN6String"):
        assert wrong not in names


@pytest.mark.parametrize("mcu", LIMITS)
def test_pulses_are_as_wide_as_commanded_and_never_anything_else(mcu: str) -> None:
    need_simavr()
    h = host(build(mcu=mcu), mcu=mcu)
    h.arm()
    h.bench.avr.pulses()
    seen: list[tuple[int, float]] = []
    h.bench.run = lambda until, avr=h.bench.avr: (
        avr.run(until),
        seen.extend((p.output, p.width_us) for p in avr.pulses()),
    )
    wanted = [(2000 + 13 * k, 4000 - 13 * k) for k in range(154)]
    for a, b in wanted:
        h.send(messages.PULSE, a, b)
        h.run(2, beat=0)
    h.run(2)
    assert not any(ack.result for ack in h.acks)
    for output in (0, 1):
        widths = np.array([width for k, width in seen if k == output])
        legal = np.array([3000, *(pair[output] for pair in wanted)]) / 2.0
        nearest = np.abs(widths[:, None] - legal).argmin(axis=1)
        assert np.abs(widths - legal[nearest]).max() <= PULSE_ERROR
        assert set(nearest[-2 * len(wanted) :]) >= set(range(1, len(legal)))
        assert (np.diff(nearest) >= 0).all()  # and in the order of the commands
    told = [sample.pulse_1 for sample in h.samples[-300:]]
    assert set(told) <= {a for a, _ in wanted} | {3000}


def test_the_sample_tells_the_pulse_that_begins_with_it(elf: Path) -> None:
    h = host(elf)
    pulses: list[float] = []
    h.bench.run = lambda until, avr=h.bench.avr: (
        avr.run(until),
        pulses.extend(p.width_us for p in avr.pulses() if p.output == 0),
    )
    h.arm()
    for width in (3100, 2500, 3900, 3001):
        h.send(messages.PULSE, width, 3000)
        h.run(3, beat=0)
    told = {s.tick + 1: s.pulse_1 / 2.0 for s in h.samples[:-1]}  # the first pulse begins before tick 0
    assert {k: pulses[k] for k in told} == pytest.approx(told, abs=PULSE_ERROR)
    assert {1550.0, 1250.0, 1950.0} <= set(told.values())


def test_ticks_come_every_10_ms_under_load_and_other_timers_stand_still(elf: Path) -> None:
    """The thesis's listing takes timer 0 away from micros(), by which it tells the time; `t` adds up readings of it."""
    h = host(elf, constant(61_803.4), constant(-73_205.1))
    h.bench.avr.watch_interrupts()
    begun = []
    for _ in range(100):
        h.run(3)
        rows = h.bench.avr.interrupts()
        begun += rows[rows[:, 2] == OVERFLOW["atmega328p"], 0].tolist()
    late = np.array(begun) - CYCLES_PER_TICK * np.arange(len(begun))
    assert len(late) >= 299
    assert np.ptp(late) <= 96  # 6 us: two interrupts that are already running
    assert np.array_equal(np.diff([s.tick for s in h.samples]), np.ones(len(h.samples) - 1))
    assert h.bench.avr.data(TCCR0B) & 7 == h.bench.avr.data(TCCR2B) & 7 == 0


def test_interrupts_are_short(elf: Path) -> None:
    h = host(elf, constant(9_000.1))
    h.arm()
    h.bench.avr.watch_interrupts()
    h.run(100)
    rows = h.bench.avr.interrupts()
    own = own_cycles(rows)
    longest = {int(v): int(own[rows[:, 2] == v].max()) for v in np.unique(rows[:, 2])}
    assert len(longest) >= 4 and max(longest.values()) < 160, longest  # 10 us; a String takes milliseconds


def own_cycles(rows: np.ndarray) -> np.ndarray:
    """How long each interrupt ran, without those that ran within it."""
    own = rows[:, 1] - rows[:, 0]
    running: list[int] = []
    for k in np.argsort(rows[:, 0], kind="stable"):
        while running and rows[running[-1], 1] <= rows[k, 0]:
            running.pop()
        if running:
            own[running[-1]] -= rows[k, 1] - rows[k, 0]
        running.append(int(k))
    return own


def test_what_runs_within_an_interrupt_is_not_its_own() -> None:
    rows = np.array([[20, 30, 1], [5, 40, 2], [32, 35, 3], [50, 60, 1], [22, 25, 4]])
    assert own_cycles(rows).tolist() == [7, 22, 3, 10, 3]


RATE = 180_000.0  # states/s of each encoder, 2637 rpm of 1024 lines: docs/firmware.md


@pytest.mark.parametrize("sense", (1.0, -1.0))
def test_no_count_is_lost_at_the_documented_speed(elf: Path, sense: float) -> None:
    h = host(elf, constant(sense * (RATE + 17.3), 0.6), constant(-sense * (RATE - 111.7), 0.6))
    h.run(70)
    assert [h.latest.count_1, h.latest.count_2] == counts(h.bench.angles).tolist()
    assert h.latest.missed == 0


@pytest.mark.parametrize("mcu", LIMITS)
def test_no_count_is_lost_in_reversals(mcu: str) -> None:
    need_simavr()
    h = host(build(mcu=mcu), swinging(60_000.0, 0.037, 0.9), swinging(45_000.0, 0.0531, 0.9), mcu)
    h.run(100)
    assert [h.latest.count_1, h.latest.count_2] == counts(h.bench.angles).tolist()


def test_above_the_limit_the_board_goes_to_neutral(elf: Path) -> None:
    h = host(elf, still, lambda t: 2_000.0 * 64 * np.maximum(t - 1.2, 0.0) ** 2)
    h.arm()
    h.send(messages.PULSE, 3400, 3000)
    while h.latest.state == messages.ARMED and len(h.samples) < 400:
        h.run(1)
    assert h.latest.state == messages.FAULT and h.latest.faults == 2
    h.run(2)
    assert h.latest.pulse_1 == h.latest.pulse_2 == 3000
    moved = np.diff([s.count_2 for s in h.samples])
    assert moved[:-3].max() <= 630 < moved.max()


@pytest.mark.parametrize("mcu", LIMITS)
def test_silence_of_the_host_ends_in_neutral(mcu: str) -> None:
    need_simavr()
    h = host(build(mcu=mcu), mcu=mcu)
    h.arm()
    h.send(messages.PULSE, 3500, 2500)
    h.run(1, beat=0)
    heard = h.latest.tick
    h.run(40, beat=0)
    back = next(s.tick for s in h.samples if s.tick > heard + 2 and s.pulse_1 == 3000)
    assert 18 <= back - heard <= 22  # 200 ms and the tick in which it is written
    assert h.latest.state == messages.FAULT and h.latest.faults == 1
    h.send(messages.ARM, h.hellos[-1].nonce)
    h.run(2)
    assert h.acks[-2].result == 6 and h.latest.state == messages.FAULT  # latched
    h.send(messages.CLEAR)
    h.run(2)
    assert h.latest.state == messages.DISARMED


def test_damaged_commands_do_not_arm(elf: Path) -> None:
    h = host(elf)
    h.run(3, beat=0)
    right = messages.command(messages.ARM, 1, h.hellos[-1].nonce)
    for bit in range(8 * (len(right) - 1)):
        flipped = bytearray(right)
        flipped[bit // 8] ^= 1 << (bit % 8)
        h.bench.avr.send(bytes(flipped) + b"\0")
        h.run(1, beat=0)
    h.run(2, beat=0)
    assert h.latest.state == messages.DISARMED and all(s.state == messages.DISARMED for s in h.samples)
    assert h.latest.damaged > 60
    h.bench.avr.send(right)
    h.run(2, beat=0)
    assert h.latest.state == messages.ARMING


@pytest.mark.parametrize("mcu", LIMITS)
def test_a_hang_resets_the_board_and_what_lies_in_a_buffer_does_not_arm_it(mcu: str) -> None:
    need_simavr()
    h = host(build("hang", "-DHANG_ON_CLEAR", mcu=mcu), mcu=mcu)
    h.arm()
    h.send(messages.PULSE, 3600, 3000)
    h.run(3)
    old = h.hellos[-1].nonce
    h.send(messages.CLEAR)
    h.run(20, beat=0)
    assert h.bench.avr.resets == 1
    assert h.hellos[-1].nonce == old + 1 and h.hellos[-1].reset_cause == 8  # WDRF
    assert h.latest.state == messages.DISARMED and h.latest.pulse_1 == 3000
    h.send(messages.ARM, old)
    h.run(5)
    assert h.latest.state == messages.DISARMED and h.acks[-2].result == 4


def test_a_minute_of_samples_without_a_gap(elf: Path) -> None:
    h = host(elf)
    h.bench.run = h.bench.avr.run
    h.run(6000)
    assert h.gaps == h.latest.dropped == h.decoder.damaged == 0
    assert [s.tick for s in h.samples] == list(range(len(h.samples))) and len(h.samples) > 5990


def test_at_the_thesiss_rate_of_the_line_most_samples_are_lost() -> None:
    """9600 baud in listing A.2; 10 000 is the nearest that divides the clock."""
    need_simavr()
    h = host(build("slow", "-DBAUD=10000UL"), baud=10_000)
    h.bench.run = h.bench.avr.run
    h.run(500, beat=0)
    assert h.gaps > 0.6 * 500 and h.decoder.damaged == 0
    assert h.latest.dropped == pytest.approx(h.gaps, abs=8)  # the board counts them itself


@pytest.mark.parametrize("mcu", LIMITS)
@pytest.mark.parametrize("millivolts", (9_500, 12_000, 16_800))
def test_the_battery_is_read(mcu: str, millivolts: int) -> None:
    need_simavr()
    h = host(build(mcu=mcu), mcu=mcu, battery_mV=millivolts)
    h.run(5)
    assert h.latest.battery == pytest.approx(millivolts, abs=2 * 18_000 / 1024)


def test_counters_wrap_around_without_a_trace() -> None:
    """Ticks after 497 days, frame numbers after 11 minutes, counts after a million turns: all at once."""
    need_simavr()
    flags = "-DFIRST_TICK=0xFFFFFFC0UL", "-DFIRST_SEQ=0xFFE0", "-DFIRST_COUNT=0x7FFFFF80L"
    h = host(build("wrap", *flags), constant(20_000.0), constant(-20_000.0))
    raw = []
    receive = h.bench.avr.receive_stamped
    h.bench.avr.receive_stamped = lambda: (lambda got: (raw.append(got[0]), got)[1])(receive())
    h.run(200)
    assert h.gaps == 0 and h.latest.tick < 200 and h.latest.count_1 < 0
    (stretch,), damaged = stretches(b"".join(raw))
    assert damaged == 0 and stretch.gaps() == []
    assert np.array_equal(np.diff(stretch.tick), np.ones(len(stretch.tick) - 1))
    speed = np.diff(stretch.count[20:], axis=0)  # 10 000 counts a second
    assert np.abs(speed - [100, -100]).max() <= 1


def test_the_board_plays_the_law_tick_by_tick(elf: Path, c) -> None:
    h = host(elf, swinging(9_000.0, 0.31))
    h.arm()
    law = desk.Law(40, 900, -2500, 25)
    h.send(messages.HOLD, 0, 40, 900, -2500, 25)
    h.run(100)
    rows = [(s.count_1, s.pulse_1) for s in h.samples[-90:]]
    played = [3000 + c.law_width(law, b[0], b[0] - a[0], 1000) for a, b in pairwise(rows)]
    assert played[:-1] == [pulse for _, pulse in rows[2:]]  # written after the tick, in force from the next one on
    assert len(set(played)) > 15


@pytest.mark.parametrize("mcu", LIMITS)
def test_the_board_plays_an_experiment_tick_by_tick(mcu: str, c) -> None:
    need_simavr()
    h = host(build(mcu=mcu), mcu=mcu)
    h.arm()
    h.send(messages.PLAY, 1, 4, 300, -20, 128, 256)
    h.run(350)
    played = [s for s in h.samples if s.playing]
    wave = desk.widths(c, desk.Experiment(4, 300, -20, 128, 256), 316)
    assert len(played) == 315  # up to the tick with which the last width is written
    assert [s.pulse_2 - 3000 for s in played] == [0, *wave[:-2]]
    assert h.latest.state == messages.ARMED and h.latest.pulse_2 == 3000


def test_two_runs_give_the_same_bytes_at_the_same_cycles(elf: Path) -> None:
    digests = []
    for _ in range(2):
        h = host(elf, swinging(30_000.0, 0.31), constant(70_001.3))
        h.arm()
        h.send(messages.PLAY, 0, 1, 400, 0, 20, 50)
        h.run(120)
        digests.append(h.digest.hexdigest())
    assert digests[0] == digests[1]
