"""Hinges of MuJoCo models: what `export` writes reads back, closed forms of a rod, and models that no rig file describes."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

from rwjax import InputError, parse_rig
from rwjax.export.mjcf import mjcf
from rwjax.methods.mujoco_joint import MujocoJoint, mujoco_joint

if os.environ.get("RWJAX_FIRMWARE") != "required":  # where the continuous test sets it, nothing may be missing
    pytest.importorskip("mujoco", reason="reading a model needs the extra `mujoco`")

LINK = """
kind = "joint"
[axis]
inertia = 0.02
[axis.friction]
viscous = 0.01
coulomb = 0.05
[axis.gravity]
torque = 0.4
angle = 0.3
"""
SERVO = '[drive.servo]\nacts_on = "torque"\nkp = 4.0\nkd = 0.1\nlimit = 1.5\ndamping_on = "speed"\n'
ROTOR, GEAR = "[motor]\ninertia = 1e-6\n", "[gear]\nratio = 50.0\n"
MOTOR = "[motor]\ntorque_constant = 0.02\nresistance = 2.0\n"
EFFECTS = """
[effects."axis.spring"]
k = 0.3
T_0 = 0.05
[effects."axis.bias_torque"]
T = 0.02
[effects."drive.delay"]
tau = 0.01
[effects."drive.lag"]
T = 0.02
[effects."drive.bias"]
u_b = -0.1
[effects."drive.saturation"]
u_m = 6.0
"""
GOAL = '[effects."drive.goal_delay"]\ntau = 0.01\n'
MASS, LENGTH = 0.6, 0.4
ROD = """
<mujoco>
  <worldbody>
    <body>
      <joint name="shoulder" type="hinge" axis="0 1 0" armature="0.003" damping="0.02" frictionloss="0.04" {joint}/>
      <inertial pos="0 0 {half}" mass="{mass}" diaginertia="{own} {own} 1e-6"/>
      <body pos="0 0 -0.1">
        <joint name="finger" type="hinge" axis="0 1 0"/>
        <inertial pos="0 0 0" mass="1e-9" diaginertia="1e-12 1e-12 1e-12"/>
      </body>
    </body>
  </worldbody>
  <actuator>{actuator}</actuator>
</mujoco>
"""


def written(folder: Path, text: str) -> Path:
    """A model's file."""
    (folder / "model.xml").write_text(text)
    return folder / "model.xml"


def rod(folder: Path, actuator: str = '<motor name="m" joint="shoulder"/>', joint: str = "") -> Path:
    """The model of a rod that hangs from a hinge."""
    own = MASS * LENGTH**2 / 12.0
    return written(folder, ROD.format(half=-0.5 * LENGTH, mass=MASS, own=own, actuator=actuator, joint=joint))


def numbers(found: MujocoJoint) -> dict[str, float]:
    """The numbers of a hinge, without where they come from."""
    return {name: known.value for name, known in found.numbers.items()}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (LINK, {}),
        (LINK + SERVO, {"drive.servo.kp": 4.0, "drive.servo.kd": 0.1, "drive.servo.limit": 1.5}),
        (LINK + ROTOR + GEAR, {"motor.inertia": 1e-6 * 50.0**2}),
        (LINK + MOTOR + GEAR, {"motor.torque_constant": 1.0, "motor.resistance": 2.0}),
        (
            LINK + MOTOR + "inductance = 0.004\n" + GEAR,
            {"motor.torque_constant": 1.0, "motor.resistance": 2.0, "motor.inductance": 0.004},
        ),
    ],
    ids=["torque", "servo", "rotor", "motor", "inductive motor"],
)
def test_what_export_writes_reads_back(text: str, expected: dict[str, float], tmp_path: Path) -> None:
    rig = parse_rig(text)
    found = mujoco_joint(written(tmp_path, mjcf(rig).text))
    kept = {name: value for name, value in rig.numbers.items() if name.startswith("axis.")}
    got = numbers(found)
    assert {name: got[name] for name in (kept | expected)} == pytest.approx(kept | expected, rel=1e-5)
    assert found.servo == ("kp" in text)


@pytest.mark.parametrize("text", [LINK + MOTOR + EFFECTS, LINK + SERVO + GOAL], ids=["motor", "servo"])
def test_effects_read_back(text: str, tmp_path: Path) -> None:
    rig = parse_rig(text)
    found = mujoco_joint(written(tmp_path, mjcf(rig).text))
    for name, given in rig.effects.items():
        assert found.effects[name] == pytest.approx(given, rel=1e-5), name
    assert found.effects.keys() == rig.effects.keys()


def test_a_rod_has_the_inertia_and_the_weight_of_a_rod(tmp_path: Path) -> None:
    found = mujoco_joint(rod(tmp_path), "shoulder")
    got = numbers(found)
    assert got["axis.inertia"] == pytest.approx(MASS * LENGTH**2 / 3.0, rel=1e-5)
    assert got["axis.gravity.torque"] == pytest.approx(0.5 * MASS * 9.81 * LENGTH, rel=1e-5)
    assert got["axis.gravity.angle"] == pytest.approx(0.0, abs=1e-6)
    assert (got["motor.inertia"], got["axis.friction.viscous"], got["axis.friction.coulomb"]) == (0.003, 0.02, 0.04)
    assert any("all other joints held" in note for note in found.notes)


def test_gears_scale_what_the_actuator_gives(tmp_path: Path) -> None:
    found = mujoco_joint(
        rod(tmp_path, '<position name="p" joint="shoulder" kp="3" kv="0.2" gear="2" forcerange="-1 2"/>')
    )
    got = numbers(found)
    assert (got["drive.servo.kp"], got["drive.servo.kd"], got["drive.servo.limit"]) == pytest.approx((12.0, 0.8, 4.0))
    assert any("larger bound" in note for note in found.notes) and any("gear, 2" in note for note in found.notes)


def test_limits_and_offset_of_a_torque_are_in_newton_metres(tmp_path: Path) -> None:
    motor = '<general name="m" joint="shoulder" gear="-100" gainprm="2" biastype="affine" biasprm="0.01 0 0" ctrlrange="-1 1"/>'
    found = mujoco_joint(rod(tmp_path, motor))
    assert found.effects["drive.saturation"]["u_m"] == 200.0 and found.effects["drive.bias"] == {"u_b": -1.0}
    assert any("is -200 N m" in note for note in found.notes)
    weaker = rod(tmp_path, motor.replace("ctrlrange", 'forcerange="-0.5 0.5" ctrlrange'))
    assert mujoco_joint(weaker).effects["drive.saturation"]["u_m"] == 50.0
    limited = rod(tmp_path, motor, 'actuatorfrcrange="-20 20"')
    assert mujoco_joint(limited).effects["drive.saturation"]["u_m"] == 20.0


def test_other_actuators_before_it_change_nothing(tmp_path: Path) -> None:
    more = '<general name="f" joint="finger" gear="7" ctrlrange="-9 9"/><motor name="m" joint="shoulder" ctrlrange="-2 2"/>'
    assert mujoco_joint(rod(tmp_path, more), "shoulder").effects["drive.saturation"]["u_m"] == 2.0


def test_armature_and_damping_of_the_actuator_count(tmp_path: Path) -> None:
    plain = numbers(mujoco_joint(rod(tmp_path)))
    more = numbers(
        mujoco_joint(rod(tmp_path, '<motor name="m" joint="shoulder" gear="3" armature="0.01" damping="0.02"/>'))
    )
    assert more["axis.inertia"] == plain["axis.inertia"]
    assert (
        more["motor.inertia"] > plain["motor.inertia"]
        and more["axis.friction.viscous"] > plain["axis.friction.viscous"]
    )


def test_a_free_base_and_a_reference_before_the_hinge_change_nothing_of_it(tmp_path: Path) -> None:
    text = rod(tmp_path, joint='ref="20" springref="5" stiffness="0.2"').read_text()
    found = mujoco_joint(written(tmp_path, text))
    assert found.effects["axis.spring"]["T_0"] == pytest.approx(0.2 * math.radians(5.0), rel=1e-5)
    ball = '<body pos="1 0 0"><freejoint/><geom size="0.1"/></body><body>'
    other = mujoco_joint(written(tmp_path, text.replace("<body>", ball, 1)), "shoulder")
    assert numbers(other) == pytest.approx(numbers(found))
    # at `ref` the rod hangs down
    assert numbers(found)["axis.gravity.angle"] == pytest.approx(-math.radians(20.0), abs=1e-5)


@pytest.mark.parametrize("gear", [5.0, -5.0])
def test_a_dc_motor_makes_in_mujoco_the_torque_of_its_numbers(gear: float, tmp_path: Path) -> None:
    import mujoco

    path = rod(
        tmp_path,
        f'<dcmotor name="m" joint="shoulder" gear="{gear}" motorconst="0.05" resistance="2" ctrlrange="-9 9"/>',
    )
    found = mujoco_joint(path, "shoulder")
    K, R = numbers(found)["motor.torque_constant"], numbers(found)["motor.resistance"]
    assert (K, R, found.effects["drive.saturation"]["u_m"]) == (0.25, 2.0, 9.0)
    model = mujoco.MjModel.from_xml_path(str(path))
    data, volts, rate = mujoco.MjData(model), 6.0, 3.0
    data.ctrl[0], data.qvel[0] = volts, rate
    mujoco.mj_forward(model, data)
    sign = np.sign(gear)  # as the note says
    assert data.qfrc_actuator[0] == pytest.approx(K * (sign * volts - K * rate) / R)
    assert any("scale -1" in note for note in found.notes) == (gear < 0.0)


def test_a_rate_to_follow_is_said_beside_the_motor_that_it_is_like(tmp_path: Path) -> None:
    found = mujoco_joint(rod(tmp_path, '<velocity name="v" joint="shoulder" kv="2"/>'))
    assert numbers(found)["motor.torque_constant"] == 1.0 and numbers(found)["motor.resistance"] == 0.5
    assert any("rate to follow" in note for note in found.notes)


def test_gains_of_a_servo_are_free_where_its_weight_tells_the_scale(tmp_path: Path) -> None:
    lifted = '<position name="p" joint="shoulder" kp="3"/>'
    numbers = mujoco_joint(rod(tmp_path, lifted)).numbers
    assert numbers["drive.servo.kp"].free and str(numbers["drive.servo.kd"].value) == "0.0"
    upright = rod(tmp_path, lifted).read_text().replace('axis="0 1 0" armature', 'axis="0 0 1" armature')
    upright = upright.replace('pos="0 0 -0.2"', 'pos="-0.2 0 0"')
    upright = upright.replace("<body>", '<body euler="33 0 0"><body euler="-33 0 0">', 1)  # leaves rounding errors
    upright = upright.replace("</worldbody>", "</body></worldbody>")
    found = mujoco_joint(written(tmp_path, upright))
    assert "axis.gravity.torque" not in found.numbers and not found.numbers["drive.servo.kp"].free


def test_a_hinge_with_stops_says_that_they_are_left_out(tmp_path: Path) -> None:
    found = mujoco_joint(rod(tmp_path, joint='range="-1.5 1.5" limited="true"'))  # in degrees, as MJCF has them
    low = math.radians(1.5)
    assert any(f"-{low:.4g} and {low:.4g} rad" in note for note in found.notes)


@pytest.mark.parametrize(
    ("actuator", "joint", "words"),
    [
        ('<motor joint="shoulder"/>', "sholder", "nearest is `shoulder`"),
        ("", None, "give --joint"),
        ("", "shoulder", "no actuators"),
        ('<motor joint="shoulder"/><motor joint="shoulder"/>', "shoulder", "2 actuators"),
        ('<motor joint="shoulder"/><motor joint="finger"/>', None, "`shoulder`, `finger`"),
        (
            '<general name="g" joint="shoulder" gainprm="1" biastype="affine" biasprm="0 -2 0"/>',
            None,
            "minus the other",
        ),
        ('<general name="g" joint="shoulder" gainprm="1" biastype="affine" biasprm="0 0 2"/>', None, "no motor has"),
        ('<damper name="d" joint="shoulder" kv="1" ctrlrange="0 1"/>', None, "of a kind"),
        ('<intvelocity name="i" joint="shoulder" kp="1" actrange="-1 1"/>', None, "of a kind"),
        ('<general name="g" joint="shoulder" gear="0"/>', None, "gear of 0"),
        (
            '<dcmotor name="d" joint="shoulder" motorconst="1" resistance="1" input="pos"/>',
            None,
            "dcmotor at a voltage",
        ),
        (
            '<dcmotor name="d" joint="shoulder" motorconst="1" resistance="1" input="none"/>',
            None,
            "dcmotor at a voltage",
        ),
        (
            '<general name="g" joint="shoulder" gaintype="dcmotor" gainprm="2 0.05" dyntype="filter" dynprm="0.3"/>',
            None,
            "dcmotor at a voltage",
        ),
        (
            '<dcmotor name="d" joint="shoulder" motorconst="1" resistance="1" cogging="0.1 2 0"/>',
            None,
            "more than motorconst, resistance and inductance",
        ),
        ('<position name="p" joint="shoulder" kp="-2"/>', None, "negative gain"),
    ],
)
def test_what_no_rig_file_describes_is_refused_in_one_line(
    actuator: str, joint: str | None, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words) as refused:
        mujoco_joint(rod(tmp_path, actuator), joint)
    assert "\n" not in str(refused.value) and "model.xml" in str(refused.value)


@pytest.mark.parametrize("text", ["", "<mujoco>", "no XML", None])
def test_a_file_that_is_no_model_is_refused_in_one_line(text: str | None, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match="MuJoCo does not read it") as refused:
        mujoco_joint(path)
    assert "\n" not in str(refused.value)


def test_a_weight_within_rounding_is_none(tmp_path: Path) -> None:
    found = mujoco_joint(
        written(tmp_path, mjcf(parse_rig(LINK.replace("torque = 0.4\nangle = 0.3", "torque = 0.0"))).text)
    )
    assert "axis.gravity.torque" not in found.numbers
    assert np.isfinite([*numbers(found).values()]).all()
