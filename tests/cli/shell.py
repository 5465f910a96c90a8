"""The command line as a user's shell sees it: in a process of its own (`program`), and within a test's (`Shell`)."""

import csv
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rwjax.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
DEMO = ROOT / "data" / "demo"
LOGS = [str(DEMO / f"{name}.csv") for name in ("square", "triangle", "multisine", "stair", "mixed")]
RIG = """kind = "reaction"
[motor]
torque_constant = 0.0182
resistance = 0.83
[wheel]
inertia = 1.24e-4
[axis]
inertia = 0.0495
[axis.friction]
viscous = 0.002
[effects."axis.stribeck"]
M_c = 0.01
M_e = 0.006
v_s = 0.3
n = 1.0
[encoder]
counts_per_rev = 2048
"""
DELAYED = RIG + '[effects."drive.delay"]\ntau = 0.003\n'
FIT = {"numbers": {"axis.inertia": {"value": 0.0495}}, "covariance_of": ["axis.inertia"], "covariance": [[2.5e-5]]}
GRID = ("--kp", "20:100:3", "--kd", "2:20:2")
LIMITS = ("--amps", "3", "--rpm", "4000")


def program(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "rwjax", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )


class Shell:
    """Calls a command in a folder with `rig.toml` and `fit.json`."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str], patch: pytest.MonkeyPatch) -> None:
        self.folder, self.capsys, self.patch = folder, capsys, patch
        (folder / "rig.toml").write_text(RIG)
        (folder / "fit.json").write_text(json.dumps(FIT))
        patch.chdir(folder)
        patch.setattr("rwjax.cli.progress.EVERY_S", 600.0)  # a slow machine says no more than a fast one

    def __call__(self, *arguments: str) -> tuple[int, str, str]:
        self.patch.setattr(sys, "argv", ["rwjax", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = self.capsys.readouterr()
        return ended.value.code or 0, out, err


def table(text: str) -> dict[str, list[str]]:
    """Columns of CSV text."""
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: [row[name] for row in rows] for name in rows[0]}
