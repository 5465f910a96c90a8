"""`rwjax sweep`, as a user calls it."""

import json

import numpy as np
import pytest

from tests.cli.shell import GRID, Shell, table
from tests.cli.shell import RIG as RIG_TEXT


def test_sweep_writes_maps_and_answers_in_json(shell: Shell) -> None:
    code, out, err = shell("sweep", "rig.toml", *GRID, "--seconds", "4", "--ki", "20", "-o", "maps.csv", "--json")
    assert code == 0, err
    answer, found = json.loads(out), table((shell.folder / "maps.csv").read_text())
    assert answer["schema"] == "rwjax.sweep/1" and np.shape(answer["overshoot"]) == (3, 2)
    assert np.ravel(answer["error_rad"]) == pytest.approx(np.array(found["error_rad"], float), rel=1e-8)
    assert [v is None for v in np.ravel(answer["settling_s"])] == [v == "inf" for v in found["settling_s"]]
    assert (shell.folder / "maps.png").read_bytes().startswith(b"\x89PNG") and "settle within 2 %" in err


def test_the_fastest_pair_on_an_edge_is_said(shell: Shell) -> None:
    (shell.folder / "smooth.toml").write_text(RIG_TEXT[: RIG_TEXT.index("[effects")])
    few = ("--kp", "40:80:2", "--kd", "8:16:2", "--seconds", "4")
    code, _, err = shell("sweep", "smooth.toml", *few)
    assert code == 0 and "fastest: " in err, err
    for name, text in (("kp", "40:80:2"), ("kd", "8:16:2")):
        assert f"it lies on the edge of --{name} {text}: widen that range\n" in err
    one = ("--kp", "40:40:1", "--kd", "8:8:1", "--seconds", "4")
    err = shell("sweep", "smooth.toml", *one)[2]
    assert "fastest: " in err and "edge" not in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("sweep", "--kp", "1:2"), "--kp 1:2: has to be FROM:TO:COUNT"),
        (("sweep", "--step", "0"), "--step 0: has to be a number other than 0"),
        (("sweep", "--late", "1"), "--late 1: has to lie between 0 and the period of 0.01 s"),
        (("sweep", "--smooth", "-1"), "--smooth: must not be negative"),
        (("sweep", "--seconds", "0"), "--seconds 0: has to hold 10 to 1000000 samples"),
        (("sweep", "--volts", "nan"), "--volts nan: has to be a finite number"),
        (("sweep", "--kp", "1:2:2000", "--kd", "1:2:2000"), "--kp 1:2:2000 --kd 1:2:2000: 4000000 pairs"),
    ],
)
def test_bad_input_ends_in_one_line(shell: Shell, arguments: tuple[str, ...], message: str) -> None:
    command, *options = arguments
    code, out, err = shell(command, "rig.toml", *options)
    assert code == 2 and out == "" and err.startswith(f"rwjax: {message}") and err.count("\n") == 1
