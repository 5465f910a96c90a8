"""Published logs of real rigs, brought into the log format. Their contents never enter the repository."""

import os
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]


def folder() -> Path | None:
    """Folder of the published logs (`RWJAX_REALDATA`, else `../shared/realdata` beside the checkout), None if absent."""
    path = Path(os.environ.get("RWJAX_REALDATA", ROOT.parent / "shared" / "realdata"))
    return path if path.is_dir() else None


def need() -> Path:
    """The folder, or a plain message and the end."""
    if (path := folder()) is None:
        raise SystemExit(
            "real data not found: set RWJAX_REALDATA to the folder that holds emps/, dcmotor_deadzone_l298n/ …"
        )
    return path


def _write(path: Path, header: str, columns: list[np.ndarray], notes: tuple[str, ...] = ()) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = "\n".join(",".join(f"{v:.9g}" for v in row) for row in zip(*columns, strict=True))
    path.write_text("\n".join([*(f"# {note}" for note in notes), header, rows, ""]))
    return path


def emps(target: Path) -> list[Path]:
    """EMPS: estimation and validation log as `platform` logs in metres, written into `target`."""
    found = []
    for name in ("DATA_EMPS", "DATA_EMPS_PULSES"):
        t, u, x = np.genfromtxt(need() / "emps" / f"{name}.csv", delimiter=",", skip_header=1, usecols=(0, 1, 2)).T
        found.append(_write(target / f"{name.lower()}.csv", "time_s,voltage_V,position_m", [t, u, x]))
    return found


def dcmotor(target: Path) -> Path:
    """Geared motor on an L298N bridge: staircase as a `wheel` log, written into `target`."""
    source = need() / "dcmotor_deadzone_l298n" / "staircase_run.csv"
    t, u, rpm = np.genfromtxt(source, delimiter=",", skip_header=1, usecols=(0, 1, 2)).T
    return _write(target / "staircase.csv", "time_s,voltage_V,wheel_rad_s", [t, u, rpm * 2.0 * np.pi / 60.0])
