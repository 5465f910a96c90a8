"""A log in memory: its stretches, what a user should know of it, and how it prints."""

import math
import re
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from rwjax.errors import InputError, LogError
from rwjax.logs.log import Log, with_earlier
from tests.logs.texts import HEADER, PLATFORM


def test_cut_keeps_the_origin(log):
    run = log([HEADER, *(f"{k / 100 + 3},0,{k}" for k in range(20))])
    part = run.cut(4, 8).cut(1, 4)
    assert part.origin == 3.0 and part.time == pytest.approx([3.05, 3.06, 3.07])
    assert part.outputs["yaw_rad"] == pytest.approx(np.array([5, 6, 7]) * math.tau / 256)
    assert run.cut(0, 20).name == "run.csv" and run.cut(10, 20).name == "run.csv[3.1 s…]"


def run(n: int = 100) -> Log:
    t = 0.01 * np.arange(n)
    outputs = {"yaw_rad": np.where(t == t[3], np.nan, t), "current_A": -2.0 * t}
    return Log(
        "run.csv",
        t,
        np.where(t < 0.5, -6.0, 6.0),
        outputs,
        dict.fromkeys(outputs, 0.0),
        {"why": "a test"},
        True,
        None,
        0.0,
    )


def test_a_cut_keeps_what_came_before_it() -> None:
    part = run().cut(20, 60).cut(10, 30)
    np.testing.assert_array_equal(part.earlier[0], run().time[:30])
    np.testing.assert_array_equal(with_earlier(part.earlier[1], part.command), run().command[:50])


@pytest.mark.parametrize(("first", "last"), [(0, 100), (0, 40), (7, 40), (99, 100), (-30, 100), (7, -1), (0, 1000)])
def test_a_stretch_holds_what_a_slice_holds(first: int, last: int) -> None:
    whole = replace(run(), supply=np.linspace(12.0, 11.0, 100), left_out={"yaw_rad": 0.01 * np.arange(100)})
    part, stretch = whole.cut(first, last), slice(first, last)
    pairs = [(part.time, whole.time), (part.command, whole.command), (part.supply, whole.supply)]
    pairs += [(part.outputs[name], y) for name, y in whole.outputs.items()]
    for cut, kept in pairs:
        np.testing.assert_array_equal(cut, kept[stretch])
    np.testing.assert_allclose(part.left_out["yaw_rad"], whole.time[stretch])  # both ends belong to it
    before = whole.time < part.time[0]
    np.testing.assert_array_equal(part.earlier[0], whole.time[before])
    np.testing.assert_array_equal(part.earlier[1], whole.command[before])
    assert (part.notes, part.validate, part.origin, part.added) == (whole.notes, True, 0.0, {})


def test_the_name_of_a_stretch_says_where_it_begins_and_ends() -> None:
    whole = run()
    assert [whole.cut(a, b).name for a, b in ((0, 100), (0, 51), (50, 100), (50, 81), (1, 100))] == [
        "run.csv",
        "run.csv[…0.5 s]",
        "run.csv[0.5 s…]",
        "run.csv[0.5 s…0.8 s]",
        "run.csv[0.0 s…]",
    ]


def test_a_log_of_few_samples_and_one_that_counts_for_a_fit_print_too() -> None:
    one = replace(run().cut(0, 1), validate=False, notes={})
    assert str(one).splitlines()[0] == "log `run.csv[…0.0 s]`: 0 s, 1 samples"
    two = replace(run().cut(98, 100), validate=False, notes={})
    assert str(two).splitlines() == [
        "log `run.csv[1.0 s…]`: 0.01 s, 2 samples at 100 Hz",
        "  command: 6 to 6 V",
        "  yaw_rad: 0.98 to 0.99 rad",
        "  current_A: -1.98 to -1.96 A",
    ]


def test_commands_of_two_axes_are_joined_too() -> None:
    two = np.arange(12.0).reshape(6, 2)
    np.testing.assert_array_equal(with_earlier(two[:2], two[2:]), two)
    np.testing.assert_array_equal(with_earlier(np.zeros(0), two), two)  # nothing came before


def test_outliers_are_remarked_and_cut_with_the_log() -> None:
    log = replace(run(), left_out={"yaw_rad": np.array([0.03, 0.5]), "current_A": np.array([0.7])})
    assert log.remarks() == [
        "run.csv: outliers among the readings of yaw_rad, which are left out: 2, the first at 0.03 s",
        "run.csv: outliers among the readings of current_A, which are left out: 1, the first at 0.7 s",
    ]
    assert {name: times.tolist() for name, times in log.cut(10, 60).left_out.items()} == {"yaw_rad": [0.5]}


def test_a_console_shows_a_log_as_it_prints() -> None:
    assert repr(run()) == str(run()) and "array(" not in repr([run()])


def test_a_log_prints_duration_rate_ranges_and_notes() -> None:
    assert (
        str(run())
        == """\
log `run.csv`: 0.99 s, 100 samples at 100 Hz, kept for validation
  command: -6 to 6 V
  yaw_rad: 0 to 0.99 rad, 1 missing
  current_A: -1.98 to 0 A
  # why: a test"""
    )
    silent = replace(run(), outputs={"yaw_rad": np.full(100, np.nan)}, notes={}, validate=False)
    assert str(silent).endswith("samples at 100 Hz\n  command: -6 to 6 V\n  yaw_rad: no reading, 100 missing")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time": np.arange(12.0)[::-1]}, "log run: `time` is 10.0 after 11.0 (sample 2); time has to increase"),
        ({"time": np.append(np.arange(11.0), np.nan)}, "`time` is nan after 10.0 (sample 12)"),
        ({"time": np.zeros((12, 1))}, "`time` has the shape (12, 1)"),
        ({"command": np.zeros(11)}, "`command` has the shape (11,), and there are 12 samples"),
        ({"outputs": {"yaw": np.zeros(12)}}, "unknown output `yaw`; the nearest is `yaw_rad`"),
        ({"outputs": {"yaw_rad": np.zeros(3)}}, "`yaw_rad` has the shape (3,)"),
        ({"supply": np.zeros(3)}, "`supply` has the shape (3,)"),
        ({"enabled": np.ones(13, bool)}, "`enabled` has the shape (13,)"),
        ({"input": "volts"}, "`input` is 'volts'; the nearest command is `voltage_V`"),
    ],
)
def test_a_log_whose_arrays_do_not_belong_together_is_refused(changes: dict, message: str) -> None:
    t = np.arange(12.0)
    whole = Log("run", t, t, {"yaw_rad": t}, {}, {}, False, None, 0.0)
    with pytest.raises(LogError, match=re.escape(message)):
        replace(whole, **changes)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"time_s": range(12)}, "from_arrays: the times of the samples [s] are given as `time`, not `time_s`"),
        (
            {"time": range(12), "time_s": range(12)},
            "from_arrays: the times of the samples [s] are given as `time`, not `time_s`",
        ),
        ({}, "from_arrays: the times of the samples [s] are given as `time`, which is missing"),
        ({"time": range(12), "name": 3}, "from_arrays: `name` is a `int`; it has to be a text"),
        (
            {"time": range(12), "notes": ["role"]},
            'from_arrays: `notes` is a `list`; it has to be notes by key, as {"role": "validate"}',
        ),
        ({"time": [0.0, 10**400] * 6}, "run: sample 2: `time_s` is too large for a number; "),
    ],
)
def test_arrays_under_other_arguments_are_told_in_one_line(given: dict, said: str) -> None:
    with pytest.raises(InputError, match=f"^{re.escape(said)}"):
        Log.from_arrays(PLATFORM, voltage_V=np.zeros(12), yaw_rad=np.zeros(12), **given)


def test_a_rig_and_a_frame_that_have_changed_places_are_told_apart() -> None:
    frame = pl.DataFrame({"time_s": [0.0, 1.0]})
    with pytest.raises(InputError, match="^from_frame: `rig` is a `DataFrame`; it has to be a rig, as "):
        Log.from_frame(frame, PLATFORM)  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="^from_frame: `name` is a `int`; it has to be a text$"):
        Log.from_frame(PLATFORM, frame, name=3)  # pyright: ignore[reportArgumentType]


def test_arrays_go_through_the_checks_of_a_file() -> None:
    t = np.arange(12) / 100.0
    log = Log.from_arrays(
        PLATFORM, time=t, voltage_V=t, yaw_counts=np.arange(12), name="a run", notes={"role": "validate"}
    )
    assert log.name == "a run" and log.validate and log.resolution["yaw_rad"] == 2.0 * np.pi / 256
    for columns, message in (
        ({"voltage_V": t, "yaw_counts": t}, "run: sample 2: `yaw_counts` is 0.01; counts have to be whole numbers"),
        ({"voltage_V": t}, "run: no measured output; a `platform` rig needs at least one of"),
        (
            {"voltage_V": t, "yaw_rads": t},
            "run: unknown column `yaw_rads`; did you mean `yaw_rad_s`? Else, if it is a reading, say which by [columns] of the rig file ",
        ),
        ({"yaw_rad": t}, "run: no column `voltage_V`, which every log needs"),
    ):
        with pytest.raises(LogError, match=re.escape(message)):
            Log.from_arrays(PLATFORM, time=t, **columns)
    with pytest.raises(LogError, match=re.escape("run: sample 7: `time_s` is 0.05 after 0.05; time has to increase")):
        Log.from_arrays(PLATFORM, time=np.where(np.arange(12) == 6, 0.05, t), voltage_V=t, yaw_rad=t)
