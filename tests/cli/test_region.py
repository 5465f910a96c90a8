"""`rwjax region`, as a user calls it."""

import json

import numpy as np
import pytest

from tests.cli.shell import DELAYED, FIT, Shell, table
from tests.cli.shell import RIG as RIG_TEXT


def test_region_writes_gains_and_a_figure_and_says_what_it_leaves_out(shell: Shell) -> None:
    rig = 'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02\n'
    (shell.folder / "rig.toml").write_text(rig + '[effects."drive.delay"]\ntau = 0.02\n')
    grid = ("--kp", "0:10:3", "--kd", "0:2:2")
    code, out, err = shell("region", "rig.toml", *grid, "-o", "region.csv", "--json")
    assert code == 0, err
    answer = json.loads(out)  # s^2 + (0.2 + 4 kd) s + 4 kp
    assert answer["schema"] == "rwjax.region/1" and answer["stable"] == [[0, 0], [0, 1], [0, 1]]
    assert "drive.delay" in err
    lines = (shell.folder / "region.csv").read_text().splitlines()
    assert lines[0] == "kp,kd,stable" and lines[4] == "5,2,1" and len(lines) == 7
    assert (shell.folder / "region.png").read_bytes().startswith(b"\x89PNG")
    _, out, err = shell("region", "rig.toml", *grid, "--quiet")
    assert out.splitlines() == lines and err == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--kp", "0:100"), "--kp 0:100: has to be FROM:TO:COUNT"),
        (("--kd", "0:inf:3"), "--kd 0:inf:3: has to be FROM:TO:COUNT"),
        (("--sigma", "nan"), "--sigma nan: has to be a finite number"),
        ((), "rig.toml: kind `wheel`: there is no axis"),
    ],
)
def test_region_refuses_in_one_line(shell: Shell, arguments: tuple[str, ...], message: str) -> None:
    motor = "[motor]\ntorque_constant = 0.0182\nresistance = 0.83\n[wheel]\ninertia = 1.24e-4\n"
    (shell.folder / "rig.toml").write_text('kind = "wheel"\n' + motor)
    status, out, err = shell("region", "rig.toml", *arguments, "-o", "region.csv")
    assert (status, out) == (2, "") and not (shell.folder / "region.csv").exists()
    assert err.startswith(f"rwjax: {message}") and err.count("\n") == 1


def test_region_stands_beside_what_an_effect_and_a_fit_leave_of_it(shell: Shell) -> None:
    code, out, err = shell("region", "rig.toml", "--without", "axis.stribeck", "--fit", "fit.json", "--plants", "50")
    assert code == 0, err
    found = {name: np.array([value or "nan" for value in values], float) for name, values in table(out).items()}
    assert list(found) == ["kp", "kd", "stable", "without_axis.stribeck", "share_of_plants"]
    assert np.sum(found["without_axis.stribeck"] > found["stable"]) > 5  # falling friction costs gains
    share, stable = found["share_of_plants"], found["stable"] == 1.0
    assert np.mean(share[stable]) > 0.9 > 0.5 > np.mean(share[~stable]) and np.any((share > 0.0) & (share < 1.0))
    assert "without axis.stribeck" in err and "for all 50 plants" in err


def test_region_is_that_of_the_fit_where_the_rig_file_holds_a_guess(shell: Shell) -> None:
    # known to 1e-4, four times the guess: all plants drawn are nearly the fitted one, and none is like the guess
    sharp = FIT | {"numbers": {"axis.inertia": {"value": 0.2}}, "covariance": [[1e-8]]}
    (shell.folder / "sharp.json").write_text(json.dumps(sharp))
    (shell.folder / "fitted.toml").write_text(RIG_TEXT.replace("inertia = 0.0495", "inertia = 0.2"))
    grid = ("--kp", "0:100:21", "--kd", "0:100:21")
    code, out, err = shell("region", "rig.toml", "--fit", "sharp.json", "--plants", "50", *grid)
    assert code == 0, err
    found = table(out)
    own, guess = (table(shell("region", name, *grid)[1])["stable"] for name in ("fitted.toml", "rig.toml"))
    assert found["stable"] == own != guess
    share = np.array(found["share_of_plants"], float)
    assert f"; {np.sum((share == 1.0) != (np.array(own) == '1'))} pairs are judged otherwise" in err
    assert "taken from sharp.json where rig.toml says otherwise: axis.inertia 0.2 (not 0.0495)\n" in err
    assert "taken from" not in shell("region", "rig.toml", "--fit", "fit.json", "--plants", "5", *grid)[2]


def test_region_knows_damping_sampling_and_margins(shell: Shell) -> None:
    grid = ("--kp", "0:100:11", "--kd", "0:400:11")

    def of(*more: str, rig: str = "rig.toml") -> tuple[dict[str, np.ndarray], str]:
        code, out, err = shell("region", rig, *grid, *more)
        assert code == 0, err
        return {name: np.array([value or "nan" for value in values], float) for name, values in table(out).items()}, err

    plain, damped = of()[0], of("--damping", "0.5")
    assert 0 < damped[0]["stable"].sum() < plain["stable"].sum() and "with a damping ratio of 0.5 or more" in damped[1]
    (shell.folder / "late.toml").write_text(DELAYED.replace("0.003", "0.03"))
    sampled, late = of("--period", "0.01"), of("--period", "0.01", rig="late.toml")
    assert 0 < late[0]["stable"].sum() < sampled[0]["stable"].sum()
    assert "every 0.01 s within |z| = exp(-0.5 h)" in sampled[1] and "commands 0.03 s" in late[1]
    assert "left out: drive.delay" not in late[1] and "left out: drive.delay" in of(rig="late.toml")[1]
    with_margins, said = of("--margins")
    names = ["gain_below", "gain_above", "phase_rad", "delay_s", "modulus"]
    assert list(with_margins) == ["kp", "kd", "stable", *names]
    inside = plain["stable"] == 1.0
    for name in names:
        assert np.array_equal(np.isnan(with_margins[name]), ~inside)
    best = np.nanargmax(with_margins["modulus"])
    assert f"at kp {plain['kp'][best]:g}, kd {plain['kd'][best]:g}\n" in said
    answer = json.loads(shell("region", "rig.toml", *grid, "--margins", "--period", "0.01", "--json")[1])
    assert answer["period"] == 0.01 and (np.array(answer["modulus"]) == None).sum() == 121 - np.sum(answer["stable"])  # noqa: E711


@pytest.mark.parametrize("more", [(), ("--period", "0.01")])
def test_region_says_how_fast_each_loop_is(shell: Shell, more: tuple[str, ...]) -> None:
    code, out, err = shell("region", "rig.toml", "--kp", "0:100:6", "--kd", "0:40:6", "--slowest", *more)
    assert code == 0, err
    found = {name: np.array(values, float) for name, values in table(out).items()}
    assert list(found) == ["kp", "kd", "stable", "slowest_per_s"]
    slowest = found["slowest_per_s"]
    assert np.array_equal(slowest < -0.5, found["stable"] == 1.0) and 0 < found["stable"].sum() < 36
    best = np.argmin(slowest)
    assert (
        f"fastest loop: slowest pole at {slowest[best]:.3g} 1/s at kp {found['kp'][best]:g}, kd {found['kd'][best]:g}\n"
        in err
    )


@pytest.mark.parametrize("more", [(), ("--period", "0.01")])
def test_a_loop_that_is_not_stable_has_no_margins(shell: Shell, more: tuple[str, ...]) -> None:
    code, out, err = shell("region", "rig.toml", "--kp", "0:0:1", "--kd", "0:0:1", "--sigma=-3", "--margins", *more)
    assert code == 0 and table(out)["stable"] == ["1"] and "margin" not in err and "--" not in err, err
    assert "sigma is negative: loops that are not stable count too; 0 or more asks for stable ones\n" in err
    assert ("exp(3 h)" if more else "left of 3 1/s") in err and table(out)["modulus"] == [""]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("region", "--without", "axis.strbeck"),
            "rig.toml: --without axis.strbeck: the rig file holds no such effect; it holds",
        ),
        (("region", "--fit", "rig.toml"), "rig.toml: is not what `rwjax fit RIG LOG… --json` prints"),
        (("region", "--plants", "10"), "--plants 10: are drawn from a fit; give it with --fit FIT.json, or leave"),
        (("region", "--kp", "0:10:1"), "--kp 0:10:1: one value leaves 10 out; give 0:0:1, or a COUNT of 2 or more"),
        (("region", "--damping", "1"), "--damping 1: has to lie between 0 and below 1"),
        (("region", "--damping", "0.5", "--period", "0.01"), "--damping 0.5: is of the continuous loop"),
        (("region", "--late", "0.01"), "--late 0.01: is of the loop as it runs; give --period"),
        (("region", "--smooth", "0.02"), "--smooth 0.02: is of the loop as it runs; give --period"),
        (("region", "--period", "0"), "--period 0: has to be positive"),
        (("region", "--kp", "1:2:2000", "--kd", "1:2:2000"), "--kp 1:2:2000 --kd 1:2:2000: 4000000 pairs"),
    ],
)
def test_bad_input_ends_in_one_line(shell: Shell, arguments: tuple[str, ...], message: str) -> None:
    command, *options = arguments
    code, out, err = shell(command, "rig.toml", *options)
    assert code == 2 and out == "" and err.startswith(f"rwjax: {message}") and err.count("\n") == 1
