"""Other tools on measured rigs: coarser steps keep the command's mean, and every tool is told the same."""

from pathlib import Path

import numpy as np
import pytest

from experiments.peers.problems import PROBLEMS, Log, Problem
from experiments.peers.run import TOOLS, row

HERE = Path(__file__).parents[2] / "experiments" / "peers"
NONE = Log(np.zeros(2), np.zeros((2, 2)), np.zeros(2))


def problem(**changed: object) -> Problem:
    """A pendulum on a motor."""
    given = dict(
        unit="mrad",
        per_si=1e3,
        reads=0,
        gain=2.0,
        kp=None,
        load=0.5,
        scale=(0.1, 0.2, 0.3, 0.4),
        bounds=((0.0, 1.0),) * 4,
    )
    more = dict(width=0.01, every=1, train=NONE, other=NONE, text="", bare="", skipped=0)
    return Problem(**(given | more | changed))  # pyright: ignore[reportArgumentType]


def test_coarser_steps_hold_the_mean_command_of_their_samples() -> None:
    u = np.arange(25.0)
    log = Log(0.001 * np.arange(25), np.stack([u, -u], axis=1), 2.0 * u).coarser(10)
    assert np.allclose(log.t, [0.0, 0.01]) and np.allclose(log.y, [0.0, 20.0])
    assert np.allclose(log.u, [[4.5, -4.5], [14.5, -14.5]])


def test_the_equation_is_that_of_a_motor_with_its_load() -> None:
    z, u = np.array([1.0, 2.0, 3.0, 0.5]), np.array([1.5, 0.0])
    expected = (2.0 * 1.5 - 0.4 * 0.7 - 0.9 - 0.2 - 0.5 * np.sin(0.3)) / 0.1
    assert problem().acceleration(np, 0.3, 0.7, u, z, sign=1.0) == pytest.approx(expected)
    servo = problem(gain=None, kp=5.0)
    expected = (0.2 * 12.0 * min(5.0 * 0.1, 1.0) - 0.4 * 0.7 - 0.9 * np.tanh(70.0) - 0.5 * np.sin(0.3)) / 0.1
    assert servo.acceleration(np, 0.3, 0.7, np.array([0.4, 12.0]), z) == pytest.approx(expected)
    assert servo.effort(np, 0.0, np.array([9.0, 12.0])) == 12.0


def test_every_tool_has_a_script_with_what_the_table_needs() -> None:
    for module in TOOLS.values():
        text = (HERE / f"{module}.py").read_text()
        assert "def fit(p: Problem)" in text, module
        assert ("def run(p: Problem" in text or "import log_of, run" in text) and (
            "SAYS = " in text or "def says()" in text
        ), module


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_problem_has_two_logs_that_begin_where_its_rig_can(name: str, realdata: Path) -> None:
    from rwjax import parse_rig

    p = PROBLEMS[name]()
    for log in (p.train, p.other):
        assert len(log.t) == len(log.u) == len(log.y) > 500 and np.ptp(np.diff(log.t)) < 1e-9
    assert len(parse_rig(p.text).free) == 4 > len(parse_rig(p.bare).free)


def test_a_tool_that_fails_says_why_in_the_table() -> None:
    failed = {"rig": "emps", "tool": "scipy", "failed": "not done after 900 s"}
    assert row(failed) == ["emps", "scipy", "-", "-", "-", "-", "not done after 900 s"]
    told = dict(rig="emps", tool="scipy", unit="mm", rms=[1.234, 5.678], seconds=2.0, lines=20, says="nothing")
    assert row(told) == ["emps", "scipy", "1.23 mm", "5.68 mm", "2.0", "20", "nothing"]
