"""What the commands for control share: a fit, and files that are written."""

import json

import numpy as np
import pytest

from tests.cli.shell import DELAYED, FIT, LIMITS, Shell, table


def test_a_number_of_the_fit_that_the_rig_lacks_is_named(shell: Shell) -> None:
    other = FIT | {"numbers": {"wheel.coulomb.M_c": {"value": 1e-3}}, "covariance_of": ["wheel.coulomb.M_c"]}
    (shell.folder / "other.json").write_text(json.dumps(other))
    code, out, err = shell("region", "rig.toml", "--fit", "other.json")
    assert code == 2 and out == "" and "the fit estimates `wheel.coulomb.M_c`, which this rig lacks" in err


def test_neither_table_nor_figure_replaces_what_was_read(shell: Shell) -> None:
    few = ("region", "rig.toml", "--fit", "fit.json", "--plants", "5", "--kp", "1:9:3", "--kd", "1:9:3", "--quiet")
    for output, message in (
        ("fit.json", "rwjax: fit.json: is the input"),
        ("region.png", "rwjax: -o region.png: is the table's path"),
    ):
        code, out, err = shell(*few, "-o", output)
        assert code == 2 and out == "" and err.startswith(message) and err.count("\n") == 1
    assert json.loads((shell.folder / "fit.json").read_text()) == FIT and not (shell.folder / "region.png").exists()
    (shell.folder / "there.png").mkdir()
    code, _, err = shell(*few, "-o", "there.csv")
    assert (
        code == 2
        and "there.png: is a folder" in err
        and not (shell.folder / "there.csv").exists()
        and err.count("\n") == 1
    )
    assert shell(*few, "-o", "/dev/null")[0] == 0


@pytest.mark.slow
def test_a_rig_with_a_delay_is_swept_tuned_and_turned(shell: Shell) -> None:
    (shell.folder / "late.toml").write_text(DELAYED)
    words = "the rig's own delays are in the loop: commands 0.003 s, readings 0 s\n"
    few = ("--kp", "40:80:2", "--kd", "8:16:2", "--seconds", "2")
    code, out, err = shell("sweep", "late.toml", *few)
    assert code == 0 and words in err, err
    same = table(shell("sweep", "rig.toml", *few, "--late", "0.003")[1])
    for name, values in table(out).items():  # the delay of the rig is that of a controller
        assert np.array(values, float) == pytest.approx(np.array(same[name], float), rel=1e-6, abs=1e-9)
    assert out != shell("sweep", "rig.toml", *few)[1]
    code, out, err = shell("tune", "late.toml", "--sigma", "2", "--seconds", "2", "--json")
    assert code == 0, err
    other = json.loads(shell("tune", "rig.toml", "--sigma", "2", "--seconds", "2", "--json")[1])
    assert json.loads(out)["robust"]["modulus"] < other["robust"]["modulus"]
    code, out, err = shell("slew", "late.toml", "--angle", "10", *LIMITS, "--json")
    assert code == 0 and "the drive's delay of 0.003 s is in this time" in err, err
    answer = json.loads(out)
    assert answer["delay_s"] == 0.003 and answer["least_time_s"] == pytest.approx(answer["time_s"][-1] + 0.003)
