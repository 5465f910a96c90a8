"""`rwjax export`, as a user calls it."""

from pathlib import Path
from xml.etree import ElementTree

from tests.cli.shell import DEMO, program


def test_export_writes_a_model_and_says_what_it_leaves_out(tmp_path: Path) -> None:
    rig = (
        DEMO / "rig.toml"
    ).read_text() + '\n[effects."axis.angle_friction"]\ns_1 = 0.2\nc_1 = 0.0\ns_2 = 0.0\nc_2 = 0.0\n'
    (tmp_path / "rig.toml").write_text(rig)
    log = sorted(DEMO.glob("*.csv"))[0]
    done = program("export", "rig.toml", str(log), "--to", "mjcf", "-o", "rig.xml", "--quiet", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert 'for a model of your own, with gear 1:\n  joint: damping="' in done.stdout
    assert ElementTree.parse(tmp_path / "rig.xml").getroot().tag == "mujoco"
    assert "axis.angle_friction" in done.stderr and "moves free runs by" in done.stderr and "(yaw_rad)" in done.stderr


def test_export_of_a_rig_that_the_tool_cannot_hold_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(
        'kind = "wheel"\n[motor]\ntorque_constant = 0.02\nresistance = 1.0\n[wheel]\ninertia = 1e-4\n'
    )
    done = program("export", "rig.toml", "--to", "c", cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "rig.toml" in done.stderr
