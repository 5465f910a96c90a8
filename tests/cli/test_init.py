"""`rwjax init`, as a user calls it."""

from pathlib import Path

from rwjax.cli.init import Kind
from rwjax.kinds import ONE_AXIS
from tests.cli.shell import DEMO, program


def test_init_writes_a_rig_file_that_fit_takes_and_does_not_replace_one(tmp_path: Path) -> None:
    logs = [str(path) for path in sorted(DEMO.glob("*.csv"))]
    done = program("init", *logs, "-o", "rig.toml", "--quiet", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "next: rwjax check rig.toml" in done.stdout
    fitted = program("fit", "rig.toml", *logs, "-o", "fitted.toml", "--quiet", cwd=tmp_path)
    assert fitted.returncode == 0, fitted.stderr
    again = program("init", *logs, "-o", "rig.toml", "--quiet", cwd=tmp_path)
    assert again.returncode == 2 and again.stderr.count("\n") == 1 and "is there already" in again.stderr


def test_the_command_line_names_every_kind_with_one_command() -> None:
    assert [kind.value for kind in Kind] == [*ONE_AXIS]


def test_init_refuses_a_number_that_no_datasheet_has(tmp_path: Path) -> None:
    done = program("init", str(sorted(DEMO.glob("*.csv"))[0]), "--no-load-speed", "-3", cwd=tmp_path)
    assert done.returncode == 2 and "--no-load-speed" in done.stderr


def test_a_model_of_mujoco_and_numbers_of_a_datasheet_do_not_go_together(tmp_path: Path) -> None:
    log = str(sorted(DEMO.glob("*.csv"))[0])
    for arguments, words in (
        (["--from-mjcf", "model.xml", "--mass", "1", "--length", "1"], "--mass does not go with --from-mjcf"),
        (["--joint", "elbow"], "--joint names a hinge"),
    ):
        done = program("init", log, *arguments, cwd=tmp_path)
        assert done.returncode == 2 and words in done.stderr and done.stderr.count("\n") == 1
