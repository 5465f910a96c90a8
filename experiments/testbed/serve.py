"""The simulated testbed at a serial port of this machine, in real time: `python -m experiments.testbed.serve [CASE]`.

Prints the port, for `rwjax monitor data/testbed/rig.toml PORT` and its kin to be tried without a rig. Ends with Ctrl-C.
"""

import os
import select
import sys
import time
import tty
from typing import TYPE_CHECKING

from firmware.simavr.avr import F_CPU, missing

if TYPE_CHECKING:
    from firmware.simavr.bench import Bench

SLICE_S = 0.002  # s between two looks at the line
MOST = F_CPU // 50
"""Cycles in one go. On a machine that is too slow, simulated time falls behind; leaps would starve the board of heartbeats."""


def serve(on: "Bench", master: int, seconds: float | None = None) -> None:
    """Keeps a board's line and a pseudo terminal joined, so long or until interrupted; simulated time is real time."""
    start, from_cycle = time.monotonic(), on.avr.cycle
    while seconds is None or time.monotonic() - start < seconds:
        now = from_cycle + round((time.monotonic() - start) * F_CPU)
        on.run(min(now, on.avr.cycle + MOST))
        if data := on.avr.receive():
            _, writable, _ = select.select([], [master], [], 0)
            if writable:  # where nobody reads, what does not fit is lost, as on a real line
                os.write(master, data)
        readable, _, _ = select.select([master], [], [], SLICE_S)
        if readable:
            on.avr.send(os.read(master, 256))


def main(arguments: list[str]) -> None:
    """Serves until Ctrl-C."""
    try:
        from experiments.testbed.campaign import bench
        from experiments.testbed.cases import CHANGES, truth
    except ModuleNotFoundError as why:
        sys.exit(f"needs {why.name}: pip install '.[experiments,link]'")
    case = arguments[0] if arguments else "none"
    if case not in CHANGES:
        sys.exit(f"no case {case}: what the rig file lacks, one of {', '.join(CHANGES)}; none without an argument")
    if packages := missing():
        sys.exit(f"needs the Debian packages {' '.join(packages)}")
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    print(os.ttyname(slave), flush=True)
    print(f"until Ctrl-C; for example: rwjax monitor data/testbed/rig.toml {os.ttyname(slave)}", file=sys.stderr)
    try:
        serve(bench(truth(case)), master)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main(sys.argv[1:])
