"""The simulated testbed at a port, where the plain install lacks what it needs."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WITHOUT_NUMBA = """
import runpy, sys
sys.modules["numba"] = None
runpy.run_module("experiments.testbed.serve", run_name="__main__")
"""


def test_what_is_to_be_installed_is_said_in_one_line() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT_NUMBA], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 1 and done.stderr == "needs numba: pip install '.[experiments,link]'\n"
