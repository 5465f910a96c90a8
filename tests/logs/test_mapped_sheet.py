"""Columns by rwjax's names: which count, which are passed over, and how messages call them."""

import re
from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.logs.mapped_sheet import mapped
from rwjax.logs.text_sheet import text_sheet
from rwjax.rig.columns import columns_of
from rwjax.rig.read import parse_rig
from tests.logs.forms import RIG, text


def log_of(tmp_path, content: str, rig=RIG):
    from rwjax.logs.read import read_log

    (tmp_path / "run.csv").write_text(content)
    return read_log(tmp_path / "run.csv", rig)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        (
            "angle",
            "winkel",
            ":1: no column `angle`, which [columns] names for `yaw_rad`; found `ms`, `pwm`, `winkel`, `rpm`",
        ),
        (
            "rpm",
            "rpms",
            "no column `rpm`, which [columns] names for `yaw_rad_s`; found `ms`, `pwm`, `angle`, `rpms`, `state`, nearest `rpms`",
        ),
        ("\n20,", "\n10,", ":4: `time_s` (column `ms`) is 0.01 after 0.01; time has to increase from row to row"),
        ("\n20,-128", "\n20,", ":4: `voltage_V` (column `pwm`) is missing; it has to be a finite number in every row"),
        ("\n20,-128", "\n20,x", ":4: `pwm` is 'x'; it has to be a number"),
        ("\n20,-128", "\n20,1e9", ":4: `voltage_V` (column `pwm`) is 4.70588e+07; a voltage lies between"),
    ],
)
def test_messages_name_the_files_own_column(tmp_path, before: str, after: str, message: str) -> None:
    with pytest.raises(LogError, match=re.escape(message)):
        log_of(tmp_path, text().replace(before, after, 1))


def test_what_is_asked_for_is_not_near_a_reading_that_is_missing(tmp_path) -> None:
    rig = replace(RIG, sources=RIG.sources | {"yaw_rad": RIG.sources["yaw_rad"]._replace(column="shaft_angle")})
    for column, near in (
        ("shaft_angle_des", ""),
        ("shaft_angle_cmd", ""),
        ("shaft_angles", ", nearest `shaft_angles`"),
    ):
        with pytest.raises(LogError) as bad:
            log_of(tmp_path, text().replace("angle", column, 1), rig)
        assert str(bad.value).endswith(f"`state`{near}")


def test_columns_under_rwjaxs_names_count_and_others_are_passed_over(tmp_path) -> None:
    content = text().replace("angle", "yaw_rad").replace("state", "current_A")
    log = log_of(tmp_path, content, replace(RIG, sources={n: s for n, s in RIG.sources.items() if n != "yaw_rad"}))
    assert log.outputs["yaw_rad"][1] == float(content.split("\n")[2].split(",")[2]) and "current_A" not in log.outputs


@pytest.mark.parametrize(
    ("column", "name"), [("ms", "time_s"), ("pwm", "voltage_V"), ("angle", "yaw_rad"), ("rpm", "yaw_rad_s")]
)
def test_a_misspelt_column_is_refused_though_the_file_has_one_of_rwjaxs_name(tmp_path, column: str, name: str) -> None:
    with pytest.raises(LogError, match=re.escape(f"no column `{column}`, which [columns] names for `{name}`; found ")):
        log_of(tmp_path, text().replace(column, name, 1))


def test_a_file_in_rwjaxs_layout_by_its_note_is_read_as_it_is(tmp_path) -> None:
    """Else a column of the same name would be converted twice."""
    rig = replace(RIG, sources={"yaw_rad": RIG.sources["yaw_rad"]._replace(column="yaw_rad")})
    rows = "time_s,voltage_V,yaw_rad\n" + "\n".join(f"{k / 100},1,{k}" for k in range(12))
    assert log_of(tmp_path, "# layout: rwjax\n" + rows, rig).outputs["yaw_rad"][1] == 1.0
    assert log_of(tmp_path, rows, rig).outputs["yaw_rad"][1] == pytest.approx(np.deg2rad(2.0))


def test_of_several_commands_that_are_named_a_file_holds_one() -> None:
    sources = RIG.sources | {"goal_rad": RIG.sources["yaw_rad"]._replace(column="goal")}
    valid = columns_of("platform")
    assert "goal_rad" not in mapped(text_sheet("x", text()), sources, valid).names
    with pytest.raises(LogError, match="no column `pwm`"):
        mapped(text_sheet("x", text().replace("pwm", "pwn")), sources, valid)


def test_a_column_that_is_there_twice_is_refused(tmp_path) -> None:
    with pytest.raises(LogError, match="column `angle` is there 2 times; rename or leave out others"):
        log_of(
            tmp_path,
            text().replace("rpm", "angle", 1),
            replace(RIG, sources={**RIG.sources} | {"yaw_rad_s": RIG.sources["yaw_rad"]}),
        )


def test_a_note_leaves_out_columns_by_the_files_own_names(tmp_path) -> None:
    run = log_of(tmp_path, "# ignore: state, rpm\n" + text())
    assert [*run.outputs] == ["yaw_rad"]


def test_a_column_that_becomes_another_is_not_taken_by_its_own_name_besides(tmp_path) -> None:
    run = log_of(
        tmp_path,
        text().replace("angle", "yaw_counts"),
        replace(RIG, sources={**RIG.sources, "yaw_rad": RIG.sources["yaw_rad"]._replace(column="yaw_counts")}),
    )
    assert run.resolution["yaw_rad"] == 0.0
    assert np.array_equal(run.outputs["yaw_rad"], log_of(tmp_path, text()).outputs["yaw_rad"])


DATES = re.sub(r"\n(\d+)0,", lambda row: f"\n2024-05-01 12:00:00.{int(row[1]):02d},", text().replace("\n0,", "\n00,"))


def dated_rig(key: str):
    section = f'time_s = {{ column = "ms", {key} }}\nvoltage_V = "pwm"\nyaw_rad = "angle"\n'
    return parse_rig('kind = "platform"\ndrive.gain = 1\naxis.inertia = 1\n[columns]\n' + section)


def test_dates_are_seconds_already(tmp_path) -> None:
    assert log_of(tmp_path, DATES, dated_rig('unit = "s"')).time == pytest.approx(np.arange(50) / 100)


@pytest.mark.parametrize("key", ['unit = "ms"', "scale = 10", "sign = -1", "offset = 1"])
def test_dates_take_no_unit_and_no_scale(tmp_path, key: str) -> None:
    message = (
        "`ms` is '2024-05-01 12:00:00.00'; it has to be a number: dates are read as `time_s` alone, and there without"
    )
    with pytest.raises(LogError, match=re.escape(message)):
        log_of(tmp_path, DATES, dated_rig(key))
