"""`rwjax slew`, as a user calls it."""

import numpy as np
import pytest

from tests.cli.shell import DEMO, LIMITS, Shell, table


@pytest.mark.slow
def test_slew_writes_its_course(shell: Shell) -> None:
    shell.patch.setattr("rwjax.cli.progress.EVERY_S", 0.01)
    code, out, err = shell("slew", "rig.toml", "--angle", "20", *LIMITS)
    assert code == 0, err
    assert float(table(out)["yaw_rad"][-1]) == pytest.approx(np.radians(20.0), rel=1e-3) and "short" in err
    assert "looking for the least time: search 1 of 4 at most, step " in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("slew", "--angle", "0"), "--angle 0° (0 rad): has to be a number other than 0"),
        (("slew", "--angle", "10", "--amps", "0"), "--amps 0: has to be positive"),
        (("slew", "--angle", "1e12"), "--angle 1e+12° (1.74533e+10 rad): takes "),
        (
            ("slew", "--angle", "10", "--spin", "90000"),
            "--spin 90000 1/min (9424.78 rad/s): the limits allow 5246.87 1/min (549.451 rad/s) at most",
        ),
        (("dump", "--spin", "3000", "--margin", "1e-300"), "--margin 1e-300: has to lie between 1e-12 and 1e+12"),
    ],
)
def test_bad_input_ends_in_one_line(shell: Shell, arguments: tuple[str, ...], message: str) -> None:
    command, *options = arguments
    code, out, err = shell(command, "rig.toml", *options)
    assert code == 2 and out == "" and err.startswith(f"rwjax: {message}") and err.count("\n") == 1


def test_a_rig_without_a_wheel_is_the_rig_files_fault(shell: Shell) -> None:
    (shell.folder / "bare.toml").write_text((DEMO / "rig.toml").read_text())
    code, _, err = shell("slew", "bare.toml", "--angle", "10")
    assert code == 2 and err.startswith("rwjax: bare.toml: kind `platform`: there is no wheel")
