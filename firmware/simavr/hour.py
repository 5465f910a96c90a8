"""An hour of armed streaming in simavr, all counters begun just before their wrap-arounds: `python -m firmware.simavr.hour [S]`.

Both encoders turn, a heartbeat goes out every 50 ms, the commands' numbers and the frames' wrap around many times. Prints what was
lost and whether times and counts are right; status 1 if anything is not. About six minutes.
"""

import sys
import time

import numpy as np

from firmware.simavr.avr import F_CPU, PIN_A, Avr, build, missing
from firmware.simavr.bench import counts, edges
from rwjax.link import frames, messages
from rwjax.link.stream import stretches

FIRST = {"FIRST_TICK": 2**32 - 1000, "FIRST_SEQ": 2**16 - 1000, "FIRST_COUNT": 2**31 - 1000}
RATES = np.array([1_500.3, -2_100.7])  # states/s
START = F_CPU // 10  # cycles: the board has started
BEAT = F_CPU // 20


def main(seconds: int) -> None:
    """Runs, checks, prints."""
    if packages := missing():
        sys.exit(f"needs the Debian packages {' '.join(packages)}")
    begun = time.perf_counter()
    avr = Avr(build("wrap_hour", *(f"-D{name}={value}L" for name, value in FIRST.items())))
    avr.run(START)
    data = bytearray(avr.receive())
    (hello,) = [m for f in frames.Decoder().feed(bytes(data)) if isinstance(m := messages.message(f), messages.Hello)]
    avr.send(messages.command(messages.ARM, 1, hello.nonce))
    angles = np.zeros(2)
    for k in range(seconds * F_CPU // BEAT):
        cycles = np.array([START + k * BEAT, START + (k + 1) * BEAT])
        angles = np.outer(cycles - START, RATES) / F_CPU
        avr.edges(*edges(cycles, angles, PIN_A[avr.mcu]))
        avr.send(messages.command(messages.HEARTBEAT, (k + 2) % 2**16))
        avr.run(int(cycles[1]))
        data += avr.receive()
    still = 3 * F_CPU // 100  # the last sample then shows all that was counted
    avr.send(messages.command(messages.HEARTBEAT, 0))
    avr.run(avr.cycle + still)
    data += avr.receive()
    found, damaged = stretches(bytes(data))
    last = [
        m for f in frames.Decoder().feed(bytes(data[-200:])) if isinstance(m := messages.message(f), messages.Sample)
    ][-1]
    whole = found[0]
    turned = whole.count[-1] - FIRST["FIRST_COUNT"]
    right = {
        "one stretch": len(found) == 1,
        "no frame lost": not whole.gaps() and damaged == 0 and last.dropped == 0,
        "no command lost": last.damaged == last.overruns == 0,
        "times right": bool((whole.tick == whole.tick[0] + np.arange(len(whole.tick))).all()),
        "counts right": turned.tolist() == counts(angles[-1]).tolist(),
        "armed to the end": last.state == messages.ARMED,
    }
    print(
        f"{seconds} s of the board's time in {time.perf_counter() - begun:.0f} s: {len(whole.tick)} samples, ", end=""
    )
    print(f"{len(data)} bytes, counts {turned.tolist()}; " + ", ".join(f"{k}: {v}" for k, v in right.items()))
    sys.exit(not all(right.values()))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3600)
