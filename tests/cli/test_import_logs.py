"""The command `import`: logs written by [columns], and a section proposed without it."""

import re
from pathlib import Path

import pytest

from rwjax.cli.import_logs import import_logs
from rwjax.errors import InputError
from rwjax.logs.read import read_log
from rwjax.rig.write import write_rig
from tests.logs.forms import FORMS, RIG
from tests.rig.texts import PLATFORM


def files(folder: Path) -> list[Path]:
    for name in ("semicolons.csv", "packed.csv.gz", "struct.mat"):
        (folder / name).write_bytes(FORMS[name])
    (folder / "rig.toml").write_text(write_rig(RIG))
    return [folder / name for name in ("semicolons.csv", "packed.csv.gz", "struct.mat")]


def test_files_become_logs_in_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import_logs(files(tmp_path), tmp_path / "rig.toml", tmp_path / "logs")
    assert sorted(path.name for path in (tmp_path / "logs").iterdir()) == ["packed.csv", "semicolons.csv", "struct.csv"]
    read = read_log(tmp_path / "logs" / "packed.csv", RIG)
    assert len(read.time) == 50 and [*read.outputs] == ["yaw_rad", "yaw_rad_s"]
    assert "packed.csv.gz: time_s, voltage_V, yaw_rad, yaw_rad_s; written to" in capsys.readouterr().out


@pytest.mark.parametrize("with_rig", [False, True])
def test_without_a_section_one_is_proposed(tmp_path: Path, capsys: pytest.CaptureFixture[str], with_rig: bool) -> None:
    found = files(tmp_path)
    (tmp_path / "plain.toml").write_text(PLATFORM)
    import_logs(found[:1], tmp_path / "plain.toml" if with_rig else None, None)
    said = capsys.readouterr().out
    assert "semicolons.csv: 5 columns" in said and "  state: no numbers" in said
    section, _, ahead = said[said.index("[columns]") :].partition("next: ")
    assert ahead == ("" if with_rig else f"rwjax init {found[0]} -o rig.toml\n")
    (tmp_path / "rig.toml").write_text(PLATFORM + section)
    import_logs(found, tmp_path / "rig.toml", tmp_path / "logs")
    assert (tmp_path / "logs" / "struct.csv").exists()


def test_a_section_is_proposed_for_the_kind_of_rig_that_a_first_rig_file_would_have(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "servo.csv").write_text("time,position_rad,command_Nm\n0,0,0.1\n0.01,0.001,0.1\n0.02,0.002,0.2\n")
    import_logs([tmp_path / "servo.csv"], None, None)
    assert "for a `joint` rig file:" in capsys.readouterr().out


def test_what_cannot_be_written_is_said_before_anything_is(tmp_path: Path) -> None:
    found = files(tmp_path)
    for output, given, message in (
        (None, found, "no folder for the logs; give one with -o"),
        (tmp_path, [*found, tmp_path / "struct.csv"], "two of the files would have the same name there"),
        (tmp_path, found, "semicolons.csv: is the input; give another path with -o"),
    ):
        with pytest.raises(InputError, match=re.escape(message)):
            import_logs(given, tmp_path / "rig.toml", output)
    with pytest.raises(InputError, match="logs are written by a rig file; give it with --rig"):
        import_logs(found, None, tmp_path / "logs")
    (tmp_path / "bad.csv").write_text("ms,pwm\n1,2\n")
    with pytest.raises(InputError, match="bad.csv:1: no column `angle`"):
        import_logs([*found, tmp_path / "bad.csv"], tmp_path / "rig.toml", tmp_path / "logs")
    assert not (tmp_path / "logs").exists()


def test_a_log_that_was_edited_since_is_not_replaced_and_an_equal_one_is_no_hindrance(tmp_path: Path) -> None:
    found, logs = files(tmp_path), tmp_path / "logs"
    import_logs(found[:2], tmp_path / "rig.toml", logs)
    import_logs(found[:2], tmp_path / "rig.toml", logs)
    (logs / "semicolons.csv").unlink()
    edited = (logs / "packed.csv").read_text().replace("# from:", "# role: validate\n# from:")
    (logs / "packed.csv").write_text(edited)
    said = (
        f"{logs / 'packed.csv'}: is there already and is not what would be written: it may have been edited, or imported with "
        "other [columns]; give another folder with -o, or move it"
    )
    with pytest.raises(InputError, match=re.escape(said)):
        import_logs(found, tmp_path / "rig.toml", logs)
    assert [path.name for path in logs.iterdir()] == ["packed.csv"]  # none is written before all are looked at
    assert (logs / "packed.csv").read_text() == edited
    import_logs(found, tmp_path / "rig.toml", tmp_path / "others")
    (tmp_path / "taken" / "semicolons.csv").mkdir(parents=True)
    with pytest.raises(InputError, match=re.escape("semicolons.csv: is there already and is not what would be")):
        import_logs(found, tmp_path / "rig.toml", tmp_path / "taken")


def test_files_with_rwjaxs_own_names_need_no_section(tmp_path: Path) -> None:
    import_logs([files(tmp_path)[0]], tmp_path / "rig.toml", tmp_path / "logs")
    (tmp_path / "plain.toml").write_text(PLATFORM)
    import_logs([tmp_path / "logs" / "semicolons.csv"], tmp_path / "plain.toml", tmp_path / "again")
    first, again = ((tmp_path / folder / "semicolons.csv").read_text() for folder in ("logs", "again"))
    assert again.splitlines()[-50:] == first.splitlines()[-50:]


def test_a_supply_is_for_a_section_that_is_proposed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [f"{10 * k},{255 * (-1) ** (k // 50)},{30 * k}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["ms,pwm,counts", *rows, ""]))
    import_logs([tmp_path / "run.csv"], None, None, 7.4)
    said = capsys.readouterr().out
    assert '"7.4 V / 255"' in said and "is a guess" not in said
    assert said.endswith(f"next: rwjax init {tmp_path / 'run.csv'} --supply 7.4 -o rig.toml\n")
    (tmp_path / "rig.toml").write_text(PLATFORM + said[said.index("[columns]") :].partition("next: ")[0])
    with pytest.raises(InputError, match="^--supply is of a section that is proposed, and here the rig file says what"):
        import_logs([tmp_path / "run.csv"], tmp_path / "rig.toml", tmp_path / "logs", 7.4)
    for wrong in (-1.0, 0.0, float("inf"), float("nan")):
        with pytest.raises(InputError, match="--supply"):
            import_logs([tmp_path / "run.csv"], None, None, wrong)


def test_a_section_for_files_alike_is_printed_once_with_their_names(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "".join(f"{k / 100},{k / 50},{k % 7}\n" for k in range(20))
    text = f"time,position_rad,command_Nm\n{rows}"
    paths = [tmp_path / name for name in ("a.csv", "b.csv", "other.csv")]
    for path in paths:
        path.write_text(text if path != paths[2] else text.replace("command_Nm", "volts"))
    import_logs(paths, None, None)
    said = capsys.readouterr().out
    assert said.count("[columns]") == 2 and said.count("3 columns") == 3
    assert f"for a `joint` rig file of {paths[0]}, {paths[1]}:\n" in said
    assert said.endswith(f"\n\nnext: rwjax init {paths[0]} {paths[1]} -o rig.toml\n")


def test_of_files_that_init_does_not_take_no_command_is_suggested(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "".join(f"{k / 100},{k / 50}\n" for k in range(20))
    (tmp_path / "a.csv").write_text(f"time,position_rad\n{rows}")
    import_logs([tmp_path / "a.csv"], None, None)
    assert "next:" not in capsys.readouterr().out
