"""`rwjax export`, as a user calls it."""

from xml.etree import ElementTree

import numpy as np
import pytest

from rwjax import simulate, write_log, write_rig
from tests.cli.shell import DEMO, LOGS, Shell
from tests.joints import joint, servo
from tests.systems import wheel


def test_export_writes_a_model_and_says_what_it_leaves_out(shell: Shell) -> None:
    rig = (
        DEMO / "rig.toml"
    ).read_text() + '\n[effects."axis.angle_friction"]\ns_1 = 0.2\nc_1 = 0.0\ns_2 = 0.0\nc_2 = 0.0\n'
    (shell.folder / "rig.toml").write_text(rig)
    code, out, err = shell("export", "rig.toml", LOGS[0], "--to", "mjcf", "-o", "rig.xml", "--quiet")
    assert code == 0, err
    assert 'for a model of your own, with gear 1:\n  joint: damping="' in out
    assert ElementTree.parse(shell.folder / "rig.xml").getroot().tag == "mujoco"
    assert "axis.angle_friction" in err and "moves free runs by" in err and "(yaw_rad)" in err


def test_export_of_a_rig_that_the_tool_cannot_hold_is_refused_in_one_line(shell: Shell) -> None:
    (shell.folder / "rig.toml").write_text(
        'kind = "wheel"\n[motor]\ntorque_constant = 0.02\nresistance = 1.0\n[wheel]\ninertia = 1e-4\n'
    )
    for to in ("c", "python-control"):
        code, _, err = shell("export", "rig.toml", "--to", to, "--quiet")
        assert code == 2 and err.count("\n") == 1 and err.startswith("rwjax: rig.toml: kind `wheel`")
        assert "logs of a wheel can be exported as a `joint`" in err


def test_the_logs_of_a_wheel_are_exported_as_those_of_a_joint(shell: Shell) -> None:
    t = 0.01 * np.arange(1000)
    volts = 8.0 * np.sign(np.sin(0.8 * t)) * (t > 0.6)
    speed = np.asarray(simulate(wheel(0.0), t, volts)["wheel_rad_s"])
    noisy = speed + 0.3 * np.random.default_rng(1).standard_normal(len(t))
    write_log(shell.folder / "run.csv", {"time_s": t, "voltage_V": volts, "yaw_rad_s": noisy}, {})
    code, _, err = shell("init", "run.csv", "--kind", "joint", "-o", "bench.toml", "--quiet")
    assert code == 0, err
    for to, holds in (("c", "_friction_torque(float rate)"), ("python-control", "control.ss")):
        code, out, err = shell("export", "bench.toml", "--to", to, "--quiet")
        assert code == 0 and holds in out, err


@pytest.mark.parametrize(
    ("effect", "servo", "says"),
    [
        ('"drive.deadzone"]\nu_0 = 0.5', "", "apply it to the command before the actuator"),
        (
            '"drive.deadzone"]\nu_0 = 0.5',
            '[drive.servo]\nacts_on = "voltage"\nkp = 2.0\nperiod = 0.01\n',
            "close the loop in your own code",
        ),
        ('"axis.angle_friction"]\ns_1 = 0.2\nc_1 = 0.0\ns_2 = 0.0\nc_2 = 0.0', "", "add its torque to the hinge"),
        ('"sensor.delay"]\ntau = 0.05', "", "apply it to what the sensors give"),
    ],
)
def test_what_a_model_lacks_is_said_with_what_to_do_instead(shell: Shell, effect: str, servo: str, says: str) -> None:
    rig = (DEMO / "rig.toml").read_text().replace("[axis]", f"{servo}[axis]", 1)
    (shell.folder / "rig.toml").write_text(f"{rig}\n[effects.{effect}\n")
    code, _, err = shell("export", "rig.toml", "--to", "mjcf", "-o", "rig.xml", "--quiet")
    name = effect.split('"')[1]
    (line,) = [line for line in err.splitlines() if line.startswith(f"note: not in it: {name}: ")]
    assert code == 0 and says in line, err


def test_a_fit_of_a_number_that_the_rig_lacks_is_named_by_its_file(shell: Shell) -> None:
    code, _, err = shell("export", str(DEMO / "rig.toml"), "--to", "json", "--fit", "fit.json", "--quiet")
    assert code == 0, err
    (shell.folder / "other.json").write_text((shell.folder / "fit.json").read_text().replace("inertia", "mass"))
    code, _, err = shell("export", "rig.toml", "--to", "json", "--fit", "other.json", "--quiet")
    assert code == 2 and err.startswith("rwjax: other.json: the fit estimates `axis.mass`, which this rig lacks")


def test_a_duty_takes_the_logged_supply_and_what_the_number_does_not_hold_is_said(shell: Shell) -> None:
    t = 0.01 * np.arange(300)
    rig = servo(joint(), "duty", kp=2.5)
    goal, on, volts = 1.5 * np.sign(np.sin(3.0 * t)) * (t > 0.6), (t < 2.5).astype(float), np.full(len(t), 11.8)
    columns = {"time_s": t, "goal_rad": goal, "enabled": on, "supply_V": volts}
    moved = np.asarray(simulate(rig, t, {name: columns[name] for name in columns if name != "time_s"})["yaw_rad"])
    write_log(shell.folder / "run.csv", columns | {"yaw_rad": moved}, {})
    (shell.folder / "joint.toml").write_text(write_rig(rig))
    code, out, err = shell("export", "joint.toml", "run.csv", "--to", "mjcf", "--quiet")
    supply, *others, far, switch = err.splitlines()
    assert code == 0 and "gainprm" in out and "11.8 V is taken for it, the mean of the logged `supply_V`" in supply, err
    assert any(line.startswith("note: not in it: drive.supply: the duty is not clipped at 1") for line in others)
    assert far.startswith("note: what is left out moves free runs by ") and float(far.split()[9]) > 0.05
    assert (
        switch
        == "note: torque is off in both runs where `enabled` is 0; the model has no such switch, and that is not counted"
    )
    code, _, err = shell("export", "joint.toml", "--to", "mjcf")
    assert code == 2 and "write [drive] supply = 12 (volts), or give logs that hold `supply_V`" in err
