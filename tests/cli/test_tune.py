"""`rwjax tune`, as a user calls it."""

import json

import pytest

from rwjax import read_rig
from rwjax.control.fit_estimate import draw_plants, read_fit_estimate
from rwjax.control.linear import linearised
from rwjax.control.margins import sampled_modulus
from rwjax.control.sampled_loop import sampled_pid_loop
from rwjax.control.transfer import transfer
from tests.cli.shell import Shell


@pytest.mark.slow
def test_tune_answers_with_both_sets_of_gains(shell: Shell) -> None:
    options = ("--fit", "fit.json", "--plants", "20", "--seconds", "4", "--ki", "5", "--sigma", "2", "--forward", "0.5")
    code, out, err = shell("tune", "rig.toml", *options, "--json")
    assert code == 0, err
    answer = json.loads(out)
    rig = read_rig(shell.folder / "rig.toml")
    thetas = draw_plants(rig, read_fit_estimate(shell.folder / "fit.json", rig), 20)
    plants = transfer(linearised(rig, thetas=thetas)).each()
    for name in ("robust", "tuned"):  # the worst of the plants, the integral in the loop
        gains = [answer[name][gain] for gain in ("kp", "ki", "kd")]
        moduli = [sampled_modulus(sampled_pid_loop(plant, 0.01, 0.0, 0.02), *gains) for plant in plants]
        assert answer[name]["modulus"] == pytest.approx(min(moduli), rel=1e-9) and gains[1] > 0.0
    assert answer["plants"] == 20 and answer["robust"]["modulus"] > answer["tuned"]["modulus"] > 0.4
    assert abs(answer["tuned"]["error"]) < abs(answer["robust"]["error"]) and answer["stable_with_tuned"] == 1.0
    shell.patch.setattr("rwjax.cli.progress.EVERY_S", 0.01)
    _, out, err = shell("tune", "rig.toml", *options)
    assert err.startswith("looking for the most robust gains for 20 plants\n") and "tuning through the closed" in err
    first, second = out.splitlines()[:2]
    assert first.startswith("tuned: kp ") and "; settles in " in first  # what settles leads
    assert second.startswith("robust: kp ") and "; does not settle" in second
    assert second.endswith("; take the tuned ones")


@pytest.mark.slow
def test_gains_that_do_not_move_the_axis_are_printed_with_the_reason(shell: Shell) -> None:
    code, out, err = shell(
        "tune", "rig.toml", "--kp", "0:4", "--kd", "0:4", "--sigma", "0.1", "--step", "3", "--seconds", "4"
    )
    assert code == 0, err
    robust = next(line for line in out.splitlines() if line.startswith("robust: "))
    assert ": friction holds the axis until the command is 0.73 V, and the step gives " in robust  # 16 mN m R/K
    assert "the axis does not move at all; take the tuned ones" in robust


@pytest.mark.slow
def test_an_integral_too_strong_to_begin_with_is_said(shell: Shell) -> None:
    code, out, err = shell("tune", "rig.toml", "--ki", "1000", "--fit", "fit.json", "--plants", "5")
    assert code == 2 and out == "" and err.count("\n") == 1
    assert err.startswith("rwjax: rig.toml: --ki 1000: with it the loop is not stable") and err.endswith("lower --ki\n")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("tune", "--forward", "2"), "--forward 2: has to lie between 0 and 1"),
        (("tune", "--kp", "0:100:101"), "--kp 0:100:101: has to be FROM:TO, from 0 or more"),
        (
            (
                "tune",
                "--kd=-10:10",
            ),
            "--kd -10:10: has to be FROM:TO, from 0 or more",
        ),
        (("tune", "--plants", "5"), "--plants 5: are drawn from a fit; give it with --fit"),
        (("tune", "--sigma", "-1"), "--sigma -1: must not be negative"),
        (
            ("tune", "--kp", "0:0.01", "--kd", "0:0.01"),
            "rig.toml: no gains within --kp and --kd put every pole of every plant left of -0.5",
        ),
        (("tune", "--least", "1"), "--least 1: has to lie between 0 and 1"),
    ],
)
def test_bad_input_ends_in_one_line(shell: Shell, arguments: tuple[str, ...], message: str) -> None:
    command, *options = arguments
    code, out, err = shell(command, "rig.toml", *options)
    assert code == 2 and out == "" and err.startswith(f"rwjax: {message}") and err.count("\n") == 1
