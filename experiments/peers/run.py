"""Other tools on measured rigs: `python -m experiments.peers.run [TOOL …] [--rig emps geared-motor …] [-o build/peers.jsonl]`

Each tool is given one log of a rig (`experiments.peers.problems`) and has to follow another one, from its command and its first reading
alone. The error is the RMS of the reading; of EMPS the first 20 samples do not count, as its authors ask. Each runs in a process of its own,
with nothing compiled and no folder of compiled programs. Lines are those of its script that are not blank. `make peers` installs the tools and
runs them.
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
from experiments.peers.problems import PROBLEMS
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
"""The module of each tool: `fit(problem)`, `run(problem, numbers, log)`, and what it says of the cause."""
LIMIT = 900.0  # s


def tried(tool: str, rig: str) -> dict:
    """What a tool makes of a rig's two logs, in this process."""
    module, p = import_module(f"experiments.peers.{TOOLS[tool]}"), PROBLEMS[rig]()
    begin = perf_counter()
    numbers = module.fit(p)
    seconds = perf_counter() - begin
    errors = [(module.run(p, numbers, log) - log.y)[p.skipped :] for log in (p.train, p.other)]
    source = Path(str(module.__file__)).read_text().splitlines()
    return {
        "rig": rig,
        "tool": tool,
        "commit": commit(),
        "unit": p.unit,
        "rms": [p.per_si * float(np.sqrt(np.mean(error**2))) for error in errors],
        "seconds": seconds,
        "lines": sum(bool(line.strip()) for line in source),
        "says": module.says() if hasattr(module, "says") else module.SAYS,
    }


def in_a_process(tool: str, rig: str) -> dict:
    """The same in a process of its own."""
    own = ROOT / "build" / "peers" / tool / "bin" / "python"  # of a tool that cannot be installed beside the others
    command = [
        str(own) if own.exists() else sys.executable,
        "-m",
        "experiments.peers.run",
        tool,
        "--rig",
        rig,
        "--here",
    ]
    with tempfile.TemporaryDirectory() as empty:
        caches = os.environ | {"XDG_CACHE_HOME": empty, "NUMBA_CACHE_DIR": empty}
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=LIMIT, cwd=ROOT, env=caches, check=False
            )
        except subprocess.TimeoutExpired:
            return {"rig": rig, "tool": tool, "failed": f"not done after {LIMIT:.0f} s"}
    if done.returncode:
        last = done.stderr.strip().rpartition("\n")[2][:120]
        return {"rig": rig, "tool": tool, "failed": last or f"ended with status {done.returncode}"}
    return json.loads(done.stdout.splitlines()[-1])


def row(one: dict) -> list[str]:
    """A tool's row of the table."""
    if "failed" in one:
        return [one["rig"], one["tool"], "-", "-", "-", "-", one["failed"]]
    errors = [f"{value:.3g} {one['unit']}" for value in one["rms"]]
    return [one["rig"], one["tool"], *errors, f"{one['seconds']:.1f}", f"{one['lines']}", one["says"]]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tools", nargs="*", metavar="TOOL", help=f"of {', '.join(TOOLS)}")
    parser.add_argument("--rig", dest="rigs", nargs="+", choices=PROBLEMS, default=tuple(PROBLEMS))
    parser.add_argument("-o", dest="path", type=Path, default=ROOT / "build" / "peers.jsonl")
    parser.add_argument("--here", action="store_true", help="one tool and one rig in this process; prints JSON")
    a = parser.parse_args()
    if a.here:
        return print(json.dumps(tried(a.tools[0], a.rigs[0])))
    a.path.parent.mkdir(parents=True, exist_ok=True)
    found = [in_a_process(tool, rig) for rig in a.rigs for tool in a.tools or TOOLS]
    a.path.write_text("".join(json.dumps(one) + "\n" for one in found))
    head = ["rig", "tool", "RMS, fitted log", "RMS, other log", "time [s]", "lines", "says of the cause"]
    return show(machine(), head, [row(one) for one in found])


if __name__ == "__main__":
    main()
