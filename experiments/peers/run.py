"""Other tools on EMPS: `python -m experiments.peers.run [TOOL …] [-o build/peers.jsonl]`

Each tool is given the estimation log and has to follow the other one, `PULSES`, from its command and its first position alone, as the
benchmark asks. The error is the RMS of the position; the first 20 samples do not count. Each runs in a process of its own, with nothing
compiled and no folder of compiled programs. Lines are those of its script that are not blank. `make peers` installs the tools and runs them.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from time import perf_counter

import numpy as np

from experiments.commit import commit
from experiments.peers.logs import log
from experiments.realdata import ROOT
from experiments.speed.table import machine, show

TOOLS = {
    "scipy": "by_scipy",
    "CasADi": "by_casadi",
    "PySINDy": "by_pysindy",
    "jax-sysid": "by_jax_sysid",
    "MuJoCo sysid": "by_mujoco",
    "BAM's way": "by_bam",
    "rwjax fit": "by_rwjax",
    "rwjax diagnose": "by_rwjax_diagnosis",
}
"""The module of each tool: `fit(t, u, x)`, `run(numbers, t, u, first)`, and what it says of the cause."""
SKIPPED = 20  # first samples, as in the benchmark's rule
LIMIT = 900.0  # s


def tried(tool: str) -> dict:
    """What a tool makes of the two logs, in this process."""
    module = import_module(f"experiments.peers.{TOOLS[tool]}")
    train, other = log("DATA_EMPS"), log("DATA_EMPS_PULSES")
    begin = perf_counter()
    numbers = module.fit(*train)
    seconds = perf_counter() - begin
    errors = [(module.run(numbers, t, u, x[0]) - x)[SKIPPED:] for t, u, x in (train, other)]
    source = Path(str(module.__file__)).read_text().splitlines()
    return {
        "tool": tool,
        "commit": commit(),
        "rmse_mm": [1e3 * float(np.sqrt(np.mean(error**2))) for error in errors],
        "seconds": seconds,
        "lines": sum(bool(line.strip()) for line in source),
        "says": module.says() if hasattr(module, "says") else module.SAYS,
    }


def in_a_process(tool: str) -> dict:
    """The same in a process of its own."""
    own = ROOT / "build" / "peers" / tool / "bin" / "python"  # of a tool that cannot be installed beside the others
    command = [str(own) if own.exists() else sys.executable, "-m", "experiments.peers.run", "--here", tool]
    with tempfile.TemporaryDirectory() as empty:
        caches = os.environ | {"XDG_CACHE_HOME": empty, "NUMBA_CACHE_DIR": empty}
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=LIMIT, cwd=ROOT, env=caches, check=False
            )
        except subprocess.TimeoutExpired:
            return {"tool": tool, "failed": f"not done after {LIMIT:.0f} s"}
    if done.returncode:
        last = done.stderr.strip().rpartition("\n")[2][:120]
        return {"tool": tool, "failed": last or f"ended with status {done.returncode}"}
    return json.loads(done.stdout.splitlines()[-1])


def row(one: dict) -> list[str]:
    """A tool's row of the table."""
    if "failed" in one:
        return [one["tool"], "-", "-", "-", "-", one["failed"]]
    train, other = one["rmse_mm"]
    return [one["tool"], f"{train:.2f}", f"{other:.2f}", f"{one['seconds']:.1f}", f"{one['lines']}", one["says"]]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tools", nargs="*", metavar="TOOL", help=f"of {', '.join(TOOLS)}")
    parser.add_argument("-o", dest="path", type=Path, default=ROOT / "build" / "peers.jsonl")
    parser.add_argument("--here", choices=TOOLS, help="this tool alone, in this process; prints JSON")
    a = parser.parse_args()
    if a.here:
        return print(json.dumps(tried(a.here)))
    a.path.parent.mkdir(parents=True, exist_ok=True)
    found = [in_a_process(tool) for tool in a.tools or TOOLS]
    a.path.write_text("".join(json.dumps(one) + "\n" for one in found))
    head = ["tool", "RMSE, fitted log [mm]", "RMSE, PULSES [mm]", "time [s]", "lines", "says of the cause"]
    return show(f"EMPS; {machine()}", head, [row(one) for one in found])


if __name__ == "__main__":
    main()
