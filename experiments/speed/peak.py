"""Runs a module as a command and notes the most memory it held: `python -m experiments.speed.peak FILE MODULE [ARGUMENT …]`.

The system's own figure for a process that has ended counts its parent too, so the process asks for its own.
"""

import atexit
import resource
import runpy
import sys
from pathlib import Path


def peak() -> float:
    """Most memory that this process has held so far [MiB]."""
    status = Path("/proc/self/status")
    if status.exists():
        row = next(row for row in status.read_text().splitlines() if row.startswith("VmHWM"))
        return int(row.split()[1]) / 1024.0
    unit = 1024.0**2 if sys.platform == "darwin" else 1024.0  # bytes on macOS, KiB elsewhere
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def main() -> None:
    """Runs the module; its own end notes the memory."""
    file, module, *arguments = sys.argv[1:]
    atexit.register(lambda: Path(file).write_text(f"{peak():.1f}"))
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
