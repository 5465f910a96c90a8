"""The separate simulator against closed forms, and the demo's logs made again byte for byte."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.blind.cases import KINDS, make_case
from experiments.blind.simulator import STEP, Truth, simulate

DEMO = Path(__file__).resolve().parents[2] / "data" / "demo"
TIME = np.arange(1001) * 0.01


def test_coast_down_stops_at_its_closed_form() -> None:
    truth = Truth(kind=1, I=0.1, gain=0.4, viscous=0.02, coulomb=0.05)
    start = np.array([0.0, 2.0, 0.0, 0.0, 0.0])
    w = simulate(TIME, np.zeros_like(TIME), TIME, start, truth.array(), STEP)[:, 1]
    stop = 0.1 / 0.02 * np.log1p(0.02 * 2.0 / 0.05)
    exact = np.where(stop > TIME, (2.0 + 0.05 / 0.02) * np.exp(-0.2 * TIME) - 0.05 / 0.02, 0.0)
    assert np.max(np.abs(w - exact)) < 1e-8  # midpoint steps of 0.1 ms
    assert np.all(w[stop < TIME] == 0.0)


def test_a_stuck_axis_stays() -> None:
    truth = Truth(kind=1, I=0.1, gain=0.4, coulomb=0.05, excess=0.03)
    x = simulate(TIME, np.full_like(TIME, 0.9 * 0.08 / 0.4), TIME, np.zeros(5), truth.array(), STEP)
    assert np.all(x[:, 0] == 0.0)


def test_wheel_friction_keeps_angular_momentum() -> None:
    truth = Truth(kind=2, I=0.05, wheel_coulomb=0.01)
    x = simulate(TIME, 4.0 * np.sign(np.sin(2.0 * TIME)), TIME, np.zeros(5), truth.array(), STEP)
    assert np.ptp(x[:, 3]) > 100.0
    assert np.max(np.abs(truth.I * x[:, 1] + truth.J * x[:, 3])) < 1e-12


@pytest.mark.parametrize("kind", KINDS)
def test_a_case_has_runs_to_fit_and_to_judge(kind: str) -> None:
    case = make_case(kind, "drive.delay", 1)
    assert case == make_case(kind, "drive.delay", 1)
    assert case.truth["effects"] == ["drive.delay"]
    assert sum(text.startswith("# role: validate") for text in case.logs.values()) == 2
    assert len(case.logs) == 6


def test_the_demo_is_made_again_byte_for_byte(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("make_demo", DEMO / "make_demo.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main(tmp_path)
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (DEMO / path.name).read_bytes(), path.name
