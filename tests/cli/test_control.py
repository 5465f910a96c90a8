"""The commands for control, as a user calls them."""

import csv
import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from rwjax import read_rig
from rwjax.cli.main import main
from rwjax.control.fit_estimate import draw_plants, read_fit_estimate
from rwjax.control.linear import linearised
from rwjax.control.margins import sampled_modulus
from rwjax.control.sampled_loop import sampled_pid_loop
from rwjax.control.transfer import transfer

RIG = """kind = "reaction"
[motor]
torque_constant = 0.0182
resistance = 0.83
[wheel]
inertia = 1.24e-4
[axis]
inertia = 0.0495
[axis.friction]
viscous = 0.002
[effects."axis.stribeck"]
M_c = 0.01
M_e = 0.006
v_s = 0.3
n = 1.0
[encoder]
counts_per_rev = 2048
"""
FIT = {"numbers": {"axis.inertia": {"value": 0.0495}}, "covariance_of": ["axis.inertia"], "covariance": [[2.5e-5]]}
GRID = ("--kp", "20:100:3", "--kd", "2:20:2")
LIMITS = ("--amps", "3", "--rpm", "4000")


class Shell:
    """Calls a command in a folder with `rig.toml` and `fit.json`."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str], patch: pytest.MonkeyPatch) -> None:
        self.folder, self.capsys, self.patch = folder, capsys, patch
        (folder / "rig.toml").write_text(RIG)
        (folder / "fit.json").write_text(json.dumps(FIT))
        patch.chdir(folder)

    def __call__(self, *arguments: str) -> tuple[int, str, str]:
        self.patch.setattr(sys, "argv", ["rwjax", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = self.capsys.readouterr()
        return ended.value.code or 0, out, err


@pytest.fixture
def shell(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Shell:
    return Shell(tmp_path, capsys, monkeypatch)


def table(text: str) -> dict[str, list[str]]:
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: [row[name] for row in rows] for name in rows[0]}


def test_region_stands_beside_what_an_effect_and_a_fit_leave_of_it(shell: Shell) -> None:
    code, out, err = shell("region", "rig.toml", "--without", "axis.stribeck", "--fit", "fit.json", "--plants", "50")
    assert code == 0, err
    found = {name: np.array(values, float) for name, values in table(out).items()}
    assert list(found) == ["kp", "kd", "stable", "without_axis.stribeck", "share_of_plants"]
    assert np.sum(found["without_axis.stribeck"] > found["stable"]) > 5  # falling friction costs gains
    share, stable = found["share_of_plants"], found["stable"] == 1.0
    assert np.mean(share[stable]) > 0.9 > 0.5 > np.mean(share[~stable]) and np.any((share > 0.0) & (share < 1.0))
    assert "without axis.stribeck" in err and "for all 50 plants" in err


def test_region_is_that_of_the_fit_where_the_rig_file_holds_a_guess(shell: Shell) -> None:
    # known to 1e-4, four times the guess: all plants drawn are nearly the fitted one, and none is like the guess
    sharp = FIT | {"numbers": {"axis.inertia": {"value": 0.2}}, "covariance": [[1e-8]]}
    (shell.folder / "sharp.json").write_text(json.dumps(sharp))
    (shell.folder / "fitted.toml").write_text(RIG.replace("inertia = 0.0495", "inertia = 0.2"))
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


def test_a_number_of_the_fit_that_the_rig_lacks_is_named(shell: Shell) -> None:
    other = FIT | {"numbers": {"wheel.coulomb.M_c": {"value": 1e-3}}, "covariance_of": ["wheel.coulomb.M_c"]}
    (shell.folder / "other.json").write_text(json.dumps(other))
    code, out, err = shell("region", "rig.toml", "--fit", "other.json")
    assert code == 2 and out == "" and "the fit estimates `wheel.coulomb.M_c`, which this rig lacks" in err


def test_sweep_writes_maps_and_answers_in_json(shell: Shell) -> None:
    code, out, err = shell("sweep", "rig.toml", *GRID, "--seconds", "4", "--ki", "20", "-o", "maps.csv", "--json")
    assert code == 0, err
    answer, found = json.loads(out), table((shell.folder / "maps.csv").read_text())
    assert answer["schema"] == "rwjax.sweep/1" and np.shape(answer["overshoot"]) == (3, 2)
    assert np.ravel(answer["error_rad"]) == pytest.approx(np.array(found["error_rad"], float), rel=1e-8)
    assert [v is None for v in np.ravel(answer["settling_s"])] == [v == "inf" for v in found["settling_s"]]
    assert (shell.folder / "maps.png").read_bytes().startswith(b"\x89PNG") and "settle within 2 %" in err


def test_slew_and_dump_write_their_courses(shell: Shell) -> None:
    code, out, err = shell("slew", "rig.toml", "--angle", "20", *LIMITS)
    assert code == 0, err
    assert float(table(out)["yaw_rad"][-1]) == pytest.approx(np.radians(20.0), rel=1e-3) and "short" in err
    code, out, err = shell("dump", "rig.toml", "--spin", "4000", "--json", "-o", "dump.csv")
    assert code == 0, err
    answer = json.loads(out)
    assert answer["bound_s"] < answer["least_time_s"] < 1.1 * answer["bound_s"] and answer["moved_deg"] < 1e-3
    assert (shell.folder / "dump.png").exists()


def test_size_names_the_lightest_ring_that_does_it(shell: Shell) -> None:
    code, out, err = shell(
        "size", "rig.toml", "--angle", "30", "--seconds", "3", "--amps", "3", "-o", "size.csv", "--json"
    )
    assert code == 0, err
    found, answer = table((shell.folder / "size.csv").read_text()), json.loads(out)
    does = np.array(found["time_s"], float) <= 3.0
    lightest = np.min(np.array(found["mass_kg"], float)[does])
    assert f"{1e3 * lightest:.3g} g" in err and set(found["limit"]) <= {"current", "voltage", "wheel rate", "friction"}
    assert answer["needs"]["torque_N_m"] > 0.016  # breakaway
    assert "none of these rings" in shell("size", "rig.toml", "--angle", "300", "--seconds", "1", "--json")[2]


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
    assert shell("tune", "rig.toml", *options)[1].startswith("robust: kp ")


def test_an_integral_too_strong_to_begin_with_is_said(shell: Shell) -> None:
    code, out, err = shell("tune", "rig.toml", "--ki", "1000", "--fit", "fit.json", "--plants", "5")
    assert code == 2 and out == "" and err.count("\n") == 1
    assert err.startswith("rwjax: rig.toml: --ki 1000: with it the loop is not stable") and err.endswith("lower --ki\n")


def test_one_row_of_wheels_or_gains_is_drawn_too(shell: Shell) -> None:
    wheels = ("--angle", "30", "--seconds", "3", "--amps", "3", "--radius", "50:50:1")
    code, _, err = shell("size", "rig.toml", *wheels, "-o", "size.csv")
    assert code == 0, err
    row = ("--kp", "20:20:1", "--kd", "2:20:2", "--seconds", "1")
    code, _, err = shell("sweep", "rig.toml", *row, "-o", "row.csv")
    assert code == 0, err
    assert (shell.folder / "size.png").exists() and (shell.folder / "row.png").exists()


DELAYED = RIG + '[effects."drive.delay"]\ntau = 0.003\n'


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


def test_size_says_that_the_delay_is_in_its_times(shell: Shell) -> None:
    (shell.folder / "late.toml").write_text(DELAYED)
    wheels = ("--angle", "30", "--seconds", "3", "--amps", "3", "--radius", "50:50:1", "--json")
    found, plain = (shell("size", name, *wheels) for name in ("late.toml", "rig.toml"))
    assert "the drive's delay of 0.003 s is in these times\n" in found[2] and "delay" not in plain[2]
    assert (json.loads(found[1])["delay_s"], json.loads(plain[1])["delay_s"]) == (0.003, 0.0)


def test_the_fastest_pair_on_an_edge_is_said(shell: Shell) -> None:
    (shell.folder / "smooth.toml").write_text(RIG[: RIG.index("[effects")])
    few = ("--kp", "40:80:2", "--kd", "8:16:2", "--seconds", "4")
    code, _, err = shell("sweep", "smooth.toml", *few)
    assert code == 0 and "fastest: " in err, err
    for name, text in (("kp", "40:80:2"), ("kd", "8:16:2")):
        assert f"it lies on the edge of --{name} {text}: widen that range\n" in err
    one = ("--kp", "40:40:1", "--kd", "8:8:1", "--seconds", "4")
    err = shell("sweep", "smooth.toml", *one)[2]
    assert "fastest: " in err and "edge" not in err


def test_region_knows_damping_sampling_and_margins(shell: Shell) -> None:
    grid = ("--kp", "0:100:11", "--kd", "0:400:11")

    def of(*more: str, rig: str = "rig.toml") -> tuple[dict[str, np.ndarray], str]:
        code, out, err = shell("region", rig, *grid, *more)
        assert code == 0, err
        return {name: np.array(values, float) for name, values in table(out).items()}, err

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
def test_a_loop_that_is_not_stable_has_no_margins(shell: Shell, more: tuple[str, ...]) -> None:
    code, out, err = shell("region", "rig.toml", "--kp", "0:0:1", "--kd", "0:0:1", "--sigma=-3", "--margins", *more)
    assert code == 0 and table(out)["stable"] == ["1"] and "margin" not in err and "--" not in err, err
    assert ("exp(3 h)" if more else "left of 3 1/s") in err and np.isnan(float(table(out)["modulus"][0]))


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
    assert code == 2 and "there.png: cannot be written" in err and err.count("\n") == 1
    assert shell(*few, "-o", "/dev/null")[0] == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("region", "--without", "axis.strbeck"),
            "rig.toml: --without axis.strbeck: the rig file holds no such effect; it holds",
        ),
        (("region", "--fit", "rig.toml"), "rig.toml: is not what `rwjax fit RIG LOG… --json` prints"),
        (("region", "--damping", "1"), "--damping 1: has to lie between 0 and below 1"),
        (("region", "--damping", "0.5", "--period", "0.01"), "--damping 0.5: is of the continuous loop"),
        (("region", "--late", "0.01"), "--late 0.01: is of the loop as it runs; give --period"),
        (("region", "--smooth", "0.02"), "--smooth 0.02: is of the loop as it runs; give --period"),
        (("region", "--period", "0"), "--period 0: has to be positive"),
        (("sweep", "--kp", "1:2"), "--kp 1:2: has to be FROM:TO:COUNT"),
        (("sweep", "--step", "0"), "--step 0: has to be a number other than 0"),
        (("sweep", "--late", "1"), "--late 1: has to lie between 0 and the period of 0.01 s"),
        (("sweep", "--smooth", "-1"), "--smooth: must not be negative"),
        (("sweep", "--seconds", "0"), "--seconds 0: has to hold 10 to 1000000 samples"),
        (("sweep", "--volts", "nan"), "--volts nan: has to be a finite number"),
        (("sweep", "--kp", "1:2:2000", "--kd", "1:2:2000"), "--kp 1:2:2000 --kd 1:2:2000: 4000000 pairs"),
        (("region", "--kp", "1:2:2000", "--kd", "1:2:2000"), "--kp 1:2:2000 --kd 1:2:2000: 4000000 pairs"),
        (("tune", "--forward", "2"), "--forward 2: has to lie between 0 and 1"),
        (("tune", "--kp", "0:100:101"), "--kp 0:100:101: has to be FROM:TO, from 0 or more"),
        (
            (
                "tune",
                "--kd=-10:10",
            ),
            "--kd -10:10: has to be FROM:TO, from 0 or more",
        ),
        (("tune", "--sigma", "-1"), "--sigma -1: must not be negative"),
        (
            ("tune", "--kp", "0:0.01", "--kd", "0:0.01"),
            "rig.toml: no gains within --kp and --kd put every pole of every plant left of -0.5",
        ),
        (("tune", "--least", "1"), "--least 1: has to lie between 0 and 1"),
        (("slew", "--angle", "0"), "rig.toml: angle 0 rad: has to be a number other than 0"),
        (("slew", "--angle", "10", "--amps", "0"), "--amps 0: has to be positive"),
        (("dump", "--spin", "0"), "rig.toml: wheel at 0 rad/s"),
        (("size", "--angle", "10", "--seconds", "0"), "--seconds 0: has to be positive"),
        (("size", "--angle", "10", "--seconds", "1", "--inner", "1"), "--inner 1: has to lie between 0"),
        (("size", "--angle", "10", "--seconds", "1", "--radius", "0:1:3"), "--radius: has to be positive"),
    ],
)
def test_bad_input_ends_in_one_line(shell: Shell, arguments: tuple[str, ...], message: str) -> None:
    command, *options = arguments
    code, out, err = shell(command, "rig.toml", *options)
    assert code == 2 and out == "" and err.startswith(f"rwjax: {message}") and err.count("\n") == 1
