"""`rwjax export`, as a user calls it."""

from xml.etree import ElementTree

from tests.cli.shell import DEMO, LOGS, Shell


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
    code, _, err = shell("export", "rig.toml", "--to", "c")
    assert code == 2 and err.count("\n") == 1 and "rig.toml" in err
