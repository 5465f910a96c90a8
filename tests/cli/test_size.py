"""`rwjax size`, as a user calls it."""

import json

import numpy as np
import pytest

from tests.cli.shell import DELAYED, Shell, table


@pytest.mark.slow
def test_size_names_the_lightest_ring_that_does_it(shell: Shell) -> None:
    code, out, err = shell(
        "size", "rig.toml", "--angle", "30", "--seconds", "3", "--amps", "3", "-o", "size.csv", "--json"
    )
    assert code == 0, err
    found, answer = table((shell.folder / "size.csv").read_text()), json.loads(out)
    does = np.array(found["time_s"], float) <= 3.0
    lightest = np.min(np.array(found["mass_kg"], float)[does])
    assert f"{1e3 * lightest:.3g} g" in err and set(found["limit"]) <= {"current", "voltage", "wheel rate", "friction"}
    assert answer["needs"]["torque_N_m"] > 0.016  # breakaway
    assert "none of these rings" in shell("size", "rig.toml", "--angle", "300", "--seconds", "1", "--json")[2]


@pytest.mark.slow
def test_one_row_of_wheels_or_gains_is_drawn_too(shell: Shell) -> None:
    wheels = ("--angle", "30", "--seconds", "3", "--amps", "3", "--radius", "50:50:1")
    code, _, err = shell("size", "rig.toml", *wheels, "-o", "size.csv")
    assert code == 0, err
    row = ("--kp", "20:20:1", "--kd", "2:20:2", "--seconds", "1")
    code, _, err = shell("sweep", "rig.toml", *row, "-o", "row.csv")
    assert code == 0, err
    assert (shell.folder / "size.png").exists() and (shell.folder / "row.png").exists()


def test_the_lightest_ring_on_an_edge_is_said(shell: Shell) -> None:
    wheels = ("size", "rig.toml", "--angle", "30", "--seconds", "3", "--amps", "3", "--radius")
    code, _, err = shell(*wheels, "20:50:31")
    assert code == 0 and "lightest that does it: 50 mm" in err, err
    assert err.startswith("to turn in 3 s, driven first and braked right after, takes a torque of ")
    assert "it lies on the edge of --radius 20:50:31: widen that range\n" in err and "edge of --thickness" not in err
    err = shell(*wheels, "50:50:1")[2]
    assert "lightest that does it: 50 mm" in err and "edge" not in err


def test_size_says_that_the_delay_is_in_its_times(shell: Shell) -> None:
    (shell.folder / "late.toml").write_text(DELAYED)
    wheels = ("--angle", "30", "--seconds", "3", "--amps", "3", "--radius", "50:50:1", "--json")
    found, plain = (shell("size", name, *wheels) for name in ("late.toml", "rig.toml"))
    assert "the drive's delay of 0.003 s is in these times\n" in found[2] and "delay" not in plain[2]
    assert (json.loads(found[1])["delay_s"], json.loads(plain[1])["delay_s"]) == (0.003, 0.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("size", "--angle", "0", "--seconds", "1"), "--angle 0° (0 rad): has to be a positive number"),
        (("size", "--angle", "10", "--seconds", "0"), "--seconds 0: has to be positive"),
        (("size", "--angle", "10", "--seconds", "1", "--inner", "1"), "--inner 1: has to lie between 0"),
        (("size", "--angle", "10", "--seconds", "1", "--radius", "0:1:3"), "--radius: has to be positive"),
    ],
)
def test_bad_input_ends_in_one_line(shell: Shell, arguments: tuple[str, ...], message: str) -> None:
    command, *options = arguments
    code, out, err = shell(command, "rig.toml", *options)
    assert code == 2 and out == "" and err.startswith(f"rwjax: {message}") and err.count("\n") == 1
