"""`rwjax init`, as a user calls it."""

import numpy as np

from rwjax import simulate, write_log
from rwjax.cli.init import Kind
from rwjax.kinds import ONE_AXIS
from tests.cli.shell import LOGS, Shell
from tests.joints import joint, servo
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


def test_a_goal_is_no_command_of_a_wheel_and_a_duty_beside_it_is(shell: Shell) -> None:
    t = 0.01 * np.arange(1200)
    duty = 60.0 * np.sign(np.sin(0.8 * t)) * (t > 0.6)
    speed = np.asarray(simulate(wheel(0.0), t, 0.12 * duty)["wheel_rad_s"])
    rows = zip(1000.0 * t, np.sin(t), duty, speed * 30.0 / np.pi, strict=True)
    text = "".join(f"{ms:.0f},{goal:.4f},{given:.1f},{w:.3f}\n" for ms, goal, given, w in rows)
    (shell.folder / "both.csv").write_text(f"ms,goal_deg,duty_pct,wheel_speed_rpm\n{text}")
    code, out, err = shell("init", "both.csv", "--kind", "wheel", "--supply", "12", "--quiet")
    assert code == 0 and "\nduty = { column" in out and "servo" not in out, err
    alone = "".join(f"{a},{b},{d}\n" for a, b, _, d in (line.split(",") for line in text.splitlines()))
    (shell.folder / "goal.csv").write_text(f"ms,goal_deg,wheel_speed_rpm\n{alone}")
    code, _, err = shell("init", "goal.csv", "--kind", "wheel")
    assert code == 2 and err.count("\n") == 1 and err.startswith("rwjax: goal.csv:1: `goal_deg` is the goal of a servo")
    assert "a goal needs kind platform or reaction or joint" in err


def test_what_init_guessed_of_a_servo_is_said_by_init_check_and_fit_until_it_is_given(shell: Shell) -> None:
    t = 0.01 * np.arange(600)
    goal = np.sign(np.sin(2.0 * t)) * (t > 0.3) + 0.3 * np.sin(9.0 * t)
    moved = np.asarray(simulate(servo(joint(), kp=2.0), t, {"goal_rad": goal})["yaw_rad"])
    noisy = moved + 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    write_log(shell.folder / "run.csv", {"time_s": t, "goal_rad": goal, "yaw_rad": noisy}, {})
    code, _, err = shell("init", "run.csv", "-o", "bench.toml")
    assert (
        code == 0
        and "note: guesses, which a fit estimates: axis.inertia, axis.friction.viscous, axis.friction.coulomb\n" in err
    ), err
    (fixed,) = [line for line in err.splitlines() if "which stay as they are" in line]
    assert "motor.resistance" in fixed and "drive.servo.kp" in fixed and "drive.servo.acts_on" in fixed
    guessed = "of [drive.servo] acts_on, kp and kd are guesses"
    code, out, err = shell("check", "bench.toml", "run.csv", "--quiet")
    assert code == 0 and guessed in out and "nothing odd was found" not in out, out + err
    code, _, err = shell("fit", "bench.toml", "run.csv", "-o", "fitted.toml", "--quiet", "--force")
    assert code == 0 and err.count(guessed) == 1, err
    text = (shell.folder / "fitted.toml").read_text()
    assert 'acts_on = "voltage" # a guess\n' in text and "# I, kg m2\n" in text and "kg m2: a guess" not in text, text
    code, _, err = shell("diagnose", "fitted.toml", "run.csv", "--quiet", "--force", "--only", "axis.spring")
    assert code == 0 and "of [drive.servo] kp, kd and acts_on are guesses" in err, err
    code, out, err = shell("init", "run.csv", "--kp", "2", "--kd", "0", "-o", "given.toml")
    text = (shell.folder / "given.toml").read_text()
    assert code == 0 and "kp = 2.0   # k_p, V/rad: given" in text and "kd = 0.0   # k_d, V s/rad: given" in text, err
    assert "of [drive.servo] acts_on is a guess" in shell("check", "given.toml", "run.csv", "--quiet")[1]


def test_gains_of_a_servo_are_refused_where_there_is_none_and_below_0(shell: Shell) -> None:
    for given, words in ((("--kp", "2"), "has no drive.servo.kp"), (("--kd", "-1"), "--kd -1: has to be positive")):
        code, _, err = shell("init", LOGS[0], *given)
        assert code == 2 and words in err and err.count("\n") == 1
