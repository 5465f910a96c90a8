"""What is said of arguments that do not fit a command, as a user reads it."""

import pytest

from tests.cli.shell import Shell


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("slew rig.toml --angle 45deg", "--angle 45deg: has to be a number in degrees (`rwjax slew --help` "),
        ("size rig.toml --angle 45 --seconds 3 --rpm x", "--rpm x: has to be a number in 1/min (`rwjax size --help` "),
        ("export rig.toml --to urdf", "--to urdf: has to be one of mjcf, c, python-control, json (`rwjax export "),
        ("run-experiment rig.toml port --kind sqare", "--kind sqare: has to be one of coast-down, square, triangle, "),
        ("fit rig.toml run.csv --bootstrap 1.5", "--bootstrap 1.5: has to be a whole number (`rwjax fit --help` "),
        ("region rig.toml --plants 0", "--plants 0: has to be greater than or equal to 1 (`rwjax region --help` "),
        ("region rig.toml --sigma", "Option '--sigma' requires an argument. (`rwjax region --help` lists what is "),
        ("slwe rig.toml", "No such command 'slwe'. Did you mean 'slew', 'sweep'? (`rwjax --help` lists what is right)"),
    ],
)
def test_one_line_says_the_option_what_would_be_right_and_whose_help_to_read(
    shell: Shell, arguments: str, said: str
) -> None:
    code, out, err = shell(*arguments.split())
    assert code == 2 and out == "" and err.startswith(f"rwjax: {said}") and err.count("\n") == 1
    assert "Input should" not in err and "Value error" not in err and "COMMAND" not in err
