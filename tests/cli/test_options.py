"""What the arguments of several commands share: numbers, ranges, files."""

from pathlib import Path

import numpy as np
import pytest

from rwjax.cli.options import axis, finite, keep_input, of_file, one_name_each, positive, results, span
from rwjax.errors import InputError, LogError, RigError


def test_an_axis_holds_its_ends_and_equal_steps() -> None:
    assert axis("--kp", "0:100:5").tolist() == [0.0, 25.0, 50.0, 75.0, 100.0]
    assert axis("--kp", "7:7:1").tolist() == [7.0]
    with pytest.raises(InputError, match="^--kp 7:9:1: one value leaves 9 out; give 7:7:1, or a COUNT of 2 or more$"):
        axis("--kp", "7:9:1")


@pytest.mark.parametrize("text", ["", "1:2", "1:2:0", "1:2:2.5", "1:nan:3", "1:2:10001", "a:b:c"])
def test_an_axis_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(InputError) as wrong:
        axis("--kp", text, "0:9:10")
    assert str(wrong.value) == f"--kp {text}: has to be FROM:TO:COUNT with 1 to 10000 values, such as 0:9:10"


def test_a_span_is_both_ends() -> None:
    assert span("--kp", "0:1e2").tolist() == [0.0, 100.0]
    for text in ("1:1", "2:1", "-1:1", "0:inf", "1"):
        with pytest.raises(InputError, match=f"^--kp {text}: has to be FROM:TO, from 0 or more"):
            span("--kp", text)


def test_numbers_are_checked_in_their_order() -> None:
    finite(volts=1.0, amps=-2.0)
    positive(volts=1.0, amps=np.inf)
    with pytest.raises(InputError, match="^--amps nan: has to be a finite number$"):
        finite(volts=1.0, amps=np.nan, rpm=np.inf)
    with pytest.raises(InputError, match="^--rpm 0: has to be positive$"):
        positive(volts=1.0, rpm=0.0, amps=-1.0)


def test_sizes_that_no_quantity_has_are_refused_with_the_range() -> None:
    finite(volts=-1e12, amps=0.0)
    positive(volts=1e-12, amps=1e12)
    assert axis("--kp", "-1e12:1e12:2").tolist() == [-1e12, 1e12]
    for size in (1e300, -1.1e12):
        with pytest.raises(InputError, match="^--volts .* has to lie between -1e.12 and 1e.12$"):
            finite(volts=size)
    for size in (1e300, 0.9e-12):
        with pytest.raises(InputError, match="has to lie between 1e-12 and 1e"):
            positive(volts=size)
    for text in ("-1.7e308:1.7e308:3", "0:1e13:2"):
        with pytest.raises(InputError, match="^--kp .* has to lie between -1e.12 and 1e.12$"):
            axis("--kp", text)
    for text in ("0:1e308", "0:1e-300"):
        with pytest.raises(InputError, match="^--kp 1e.30.: has to lie between 1e-12 and 1e.12$"):
            span("--kp", text)


def test_an_input_is_spared_by_whatever_name(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text("")
    (tmp_path / "link.toml").symlink_to(tmp_path / "rig.toml")
    keep_input(tmp_path / "new.toml", tmp_path / "rig.toml")
    with pytest.raises(InputError, match="link.toml: is the input; give another path with -o"):
        keep_input(tmp_path / "link.toml", tmp_path / "absent.toml", tmp_path / "rig.toml")


def test_a_file_is_named_in_errors_of_its_kind_only() -> None:
    with pytest.raises(RigError, match="^rig.toml: no axis$"), of_file(Path("rig.toml"), RigError):
        raise RigError("no axis")
    with pytest.raises(LogError, match="^no time$"), of_file(Path("rig.toml"), RigError):
        raise LogError("no time")


def test_a_folder_without_results_is_gone_again(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="^no$"), results(tmp_path / "a" / "b") as folder:
        assert folder.is_dir()
        raise InputError("no")
    assert not (tmp_path / "a" / "b").exists()
    with pytest.raises(KeyboardInterrupt), results(tmp_path / "c") as folder:
        (folder / "part.json").write_text("")
        raise KeyboardInterrupt
    assert (tmp_path / "c" / "part.json").exists()
    with pytest.raises(InputError, match="part.json: is a file, and a folder is wanted; give another with -o"):
        with results(tmp_path / "c" / "part.json"):
            pass


def test_an_option_of_several_names_stands_before_each_of_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    given = (
        "diagnose --only axis.coulomb drive.lag parameter.axis.inertia rig.toml a.csv --without x y.z --json".split()
    )
    assert (
        one_name_each(given)
        == (
            "diagnose --only axis.coulomb --only drive.lag --only parameter.axis.inertia rig.toml a.csv --without x y.z --json"
        ).split()
    )
    (tmp_path / "drive.lag").touch()  # which is a file then
    assert one_name_each(given)[:4] == ["diagnose", "--only", "axis.coulomb", "drive.lag"]
    region = ["region", "rig.toml", "--without", "axis.coulomb", "drive.lag"]
    assert one_name_each(region) == region and one_name_each([]) == []
