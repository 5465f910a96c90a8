"""Other tools on a measured rig: coarser steps keep the command's mean, and every tool is told the same."""

from pathlib import Path

import numpy as np

from experiments.peers.logs import coarser
from experiments.peers.run import TOOLS, row

HERE = Path(__file__).parents[2] / "experiments" / "peers"


def test_coarser_steps_hold_the_mean_command_of_their_samples() -> None:
    t = 0.001 * np.arange(25)
    u = np.arange(25.0)
    time, command, position = coarser(10, t, u, 2.0 * u)
    assert np.allclose(time, [0.0, 0.01]) and np.allclose(command, [4.5, 14.5]) and np.allclose(position, [0.0, 20.0])


def test_every_tool_has_a_script_with_what_the_table_needs() -> None:
    for module in TOOLS.values():
        text = (HERE / f"{module}.py").read_text()
        assert "def fit(t: np.ndarray, u: np.ndarray, x: np.ndarray)" in text, module
        assert "def run(" in text and ("SAYS = " in text or "def says()" in text), module


def test_a_tool_that_fails_says_why_in_the_table() -> None:
    assert row({"tool": "scipy", "failed": "not done after 900 s"}) == [
        "scipy",
        "-",
        "-",
        "-",
        "-",
        "not done after 900 s",
    ]
    told = {"tool": "scipy", "rmse_mm": [1.234, 5.678], "seconds": 2.0, "lines": 20, "says": "nothing"}
    assert row(told) == ["scipy", "1.23", "5.68", "2.0", "20", "nothing"]
