"""`rwjax init`, as a user calls it."""

import numpy as np

from rwjax import simulate, write_log
from rwjax.cli.init import Kind
from rwjax.kinds import ONE_AXIS
from tests.cli.shell import LOGS, Shell
from tests.systems import wheel


def test_init_writes_a_rig_file_that_fit_takes_and_does_not_replace_one(shell: Shell) -> None:
    code, out, err = shell("init", *LOGS, "-o", "bench.toml", "--quiet")
    assert code == 0 and "next: rwjax check bench.toml" in out, err
    code, _, err = shell("fit", "bench.toml", *LOGS, "-o", "fitted.toml", "--quiet")
    assert code == 0, err
    code, _, err = shell("init", *LOGS, "-o", "bench.toml", "--quiet")
    assert code == 2 and err.count("\n") == 1 and "is there already" in err


def test_the_command_line_names_every_kind_with_one_command() -> None:
    assert [kind.value for kind in Kind] == [*ONE_AXIS]


def test_init_refuses_a_number_that_no_datasheet_has(shell: Shell) -> None:
    code, _, err = shell("init", LOGS[0], "--no-load-speed", "-3")
    assert code == 2 and "--no-load-speed" in err


def test_a_model_of_mujoco_and_numbers_of_a_datasheet_do_not_go_together(shell: Shell) -> None:
    for arguments, words in (
        (["--from-mjcf", "model.xml", "--mass", "1", "--length", "1"], "--mass does not go with --from-mjcf"),
        (["--joint", "elbow"], "--joint names a hinge"),
        (["--bob"], "--bob says how the mass of --mass and --length is spread: give both"),
    ):
        code, _, err = shell("init", LOGS[0], *arguments)
        assert code == 2 and words in err and err.count("\n") == 1


def test_what_the_logs_do_not_tell_is_a_note_and_the_file_fits(shell: Shell) -> None:
    t = 0.01 * np.arange(2000)
    volts = 8.0 * np.sign(np.sin(0.8 * t)) * (t > 0.6)
    speed = np.asarray(simulate(wheel(0.0).with_values({"motor.friction": 0.0}), t, volts)["wheel_rad_s"])
    noisy = speed + 0.3 * np.random.default_rng(1).standard_normal(len(t))
    write_log(shell.folder / "run.csv", {"time_s": t, "voltage_V": volts, "wheel_rad_s": noisy}, {})
    slow = 12.0 / 0.0182 * 30.0 / np.pi / 1.3  # the motor turns 1.3 times as fast
    given = ("--supply", "12", "--no-load-speed", f"{slow}", "--resistance", "0.83")
    code, _, err = shell("init", "run.csv", *given, "-o", "bench.toml")
    assert code == 0 and "note: motor.friction is 0 and fixed" in err, err
    assert "note: --no-load-speed: these logs turn 1.3 times as fast per volt" in err
    assert shell("init", "run.csv", *given, "--quiet")[2] == ""
    code, _, err = shell("fit", "bench.toml", "run.csv", "-o", "fitted.toml", "--quiet")
    assert code == 0, err


def test_a_supply_and_counts_go_with_a_model_and_a_gain_does_not(shell: Shell) -> None:
    for given, words in ((("--supply", "9"), "no.xml"), (("--gain", "0.4"), "--gain does not go with --from-mjcf")):
        code, _, err = shell("init", LOGS[0], "--from-mjcf", "no.xml", *given)
        assert code == 2 and words in err and err.count("\n") == 1
    code, out, err = shell("init", LOGS[0], "--gain", "0.4", "--counts", "2048", "--quiet")
    assert code == 0 and "gain = 0.4" in out, err
