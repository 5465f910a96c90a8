"""The tables of docs/firmware.md: `python -m firmware.simavr.tables` (about two minutes)."""

import subprocess
import sys

import numpy as np

from firmware.simavr.avr import CYCLES_PER_TICK, F_CPU, Avr, build, missing
from firmware.simavr.bench import Bench, counts
from firmware.simavr.host import Host
from firmware.simavr.spin import Spin, constant, still
from rwjax.link import messages

BOARDS = ("atmega328p", "atmega2560")
OVERFLOW = {"atmega328p": 13, "atmega2560": 20}  # vectors of timer 1, data sheets
RAM = {"atmega328p": (0x100, 0x8FF), "atmega2560": (0x200, 0x21FF)}  # first and last address, data sheets
LINES = 1024
RATES = range(20_000, 500_001, 20_000)  # states/s
ODD = 137.3  # states/s apart: rates that divide the clock keep their phase to the tick, and hide misses


def host(mcu: str, first=still, second=still) -> Host:
    """A board under encoders that turn."""
    return Host(Bench(Avr(build(mcu=mcu), mcu), Spin(first, second)))


def sizes(mcu: str) -> tuple[int, int]:
    """Bytes of flash, and of RAM besides the stack."""
    out = subprocess.run(["avr-size", "-A", build(mcu=mcu)], check=True, capture_output=True, text=True).stdout
    size = {row[0]: int(row[1]) for row in map(str.split, out.splitlines()) if len(row) == 3 and row[1].isdigit()}
    return size[".text"] + size[".data"], size[".data"] + size[".bss"] + size[".noinit"]


def stack(mcu: str) -> int:
    """Deepest stack [bytes] seen in 2 s, armed and playing, both encoders fast: RAM that is no longer 0 below the top."""
    h = host(mcu, constant(60_000.0 + ODD), constant(-60_000.0))
    h.arm()
    h.send(messages.PLAY, 0, 4, 300, 0, 100, 200)
    h.run(200)
    first, last = RAM[mcu]
    free = range(first + sizes(mcu)[1], last + 1)
    return last + 1 - next(address for address in free if h.bench.avr.data(address))


def jitter(mcu: str, rate: float) -> float:
    """Peak to peak of the tick's beginning [us] over 3 s, both encoders at `rate` and the stream running."""
    h = host(mcu, constant(rate + ODD), constant(-rate + 3 * ODD))
    h.bench.avr.watch_interrupts()
    begun: list[int] = []
    for _ in range(100):
        h.run(3)
        rows = h.bench.avr.interrupts()
        begun += rows[rows[:, 2] == OVERFLOW[mcu], 0].tolist()
    return float(np.ptp(np.array(begun) - CYCLES_PER_TICK * np.arange(len(begun)))) * 1e6 / F_CPU


def pulse_error(mcu: str) -> float:
    """Largest difference [us] between a commanded width and the pulse, over the whole range."""
    h = host(mcu)
    h.arm()
    avr, worst, seen = h.bench.avr, 0.0, [0.0]

    def board_alone(until: int) -> None:
        avr.run(until)
        seen.extend(p.width_us for p in avr.pulses() if p.output == 0)

    h.bench.run = board_alone
    for width in range(2000, 4001, 8):
        h.send(messages.PULSE, width, 6000 - width)
        h.run(3, beat=0)
        worst = max(worst, abs(seen[-1] - width / 2.0))
    return worst


def loses(mcu: str, rate: float, both: bool) -> bool:
    """Whether a count is lost within a second at this rate [states/s], with heartbeats and samples on the line."""
    for sense in (1.0, -1.0):
        second = constant(-sense * (rate + 3 * ODD), 1.05) if both else still
        h = host(mcu, constant(sense * (rate + ODD), 1.05), second)
        h.run(120)
        if h.bench.avr.resets or [h.latest.count_1, h.latest.count_2] != counts(h.bench.angles).tolist():
            return True
    return False


def highest(mcu: str, both: bool) -> int:
    """Highest rate [states/s] up to which no count is lost at any lower one tried either."""
    clean = 0
    for rate in RATES:
        if loses(mcu, rate, both):
            break
        clean = rate
    return clean


def main() -> None:
    """Prints the tables."""
    if packages := missing():
        sys.exit(f"needs the Debian packages {' '.join(packages)}")
    print("| | ATmega328P | ATmega2560 |\n| --- | --- | --- |")

    def row(name: str, values: list[str]) -> None:
        print(f"| {name} | {' | '.join(values)} |", flush=True)

    of = {mcu: sizes(mcu) for mcu in BOARDS}
    row("flash", [f"{of[mcu][0]} bytes" for mcu in BOARDS])
    row("RAM besides the stack", [f"{of[mcu][1]} bytes" for mcu in BOARDS])
    row("stack, deepest seen", [f"{stack(mcu)} bytes" for mcu in BOARDS])
    row("pulse error, largest", [f"{pulse_error(mcu):.4f} us" for mcu in BOARDS])
    for rate in (0, 20_000, 100_000, 200_000):
        rpm = 60.0 * rate / (4 * LINES)
        row(f"tick jitter, peak to peak, both encoders at {rpm:.0f} rpm", [f"{jitter(m, rate):.2f} us" for m in BOARDS])
    for both in (False, True):
        rates = [highest(mcu, both) for mcu in BOARDS]
        said = [f"{rate / 1000:.0f} k states/s, {60.0 * rate / (4 * LINES):.0f} rpm" for rate in rates]
        row(f"no lost count up to, {'both encoders' if both else 'one encoder'}, {LINES} lines", said)


if __name__ == "__main__":
    main()
