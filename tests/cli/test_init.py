"""`rwjax init`, as a user calls it."""

from rwjax.cli.init import Kind
from rwjax.kinds import ONE_AXIS
from tests.cli.shell import LOGS, Shell


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
    ):
        code, _, err = shell("init", LOGS[0], *arguments)
        assert code == 2 and words in err and err.count("\n") == 1
