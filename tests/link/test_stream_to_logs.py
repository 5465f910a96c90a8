"""Logs from raw streams: every frame that arrived is in them, and what was lost is noted."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax.errors import LogError, RigError
from rwjax.link.messages import Hello, Message
from rwjax.link.stream import stretches
from rwjax.link.stream_to_logs import columns, numbered, read_notes, write_logs
from rwjax.logs.read import read_log
from tests.link.ports import HELLO, LIKE_RIG, RIG, SAMPLE, stream, wire


def test_a_log_holds_the_interfaces_columns_in_its_units(tmp_path: Path) -> None:
    said = [SAMPLE._replace(tick=k, count_1=2 * k, count_2=-7 * k, pulse_1=3000 + k, battery=11_500) for k in range(50)]
    raw = tmp_path / "run.raw"
    raw.write_bytes(b"".join([wire(LIKE_RIG, 0), *(wire(s, k + 1) for k, s in enumerate(said))]))
    (tmp_path / "run.notes").write_text("date: today\nrole: validate\n")
    (path,), remarks = write_logs(raw, RIG, tmp_path / "run.csv")
    log = read_log(path, RIG)
    k = np.arange(50)
    assert remarks == [] and log.validate and log.notes["date"] == "today" and log.notes["firmware"] == "abcdef01"
    assert np.array_equal(log.time, k / 100)
    assert log.command == pytest.approx(0.01 * k, abs=1e-9)  # half a microsecond is 0.01 V
    # the thesis's listing divides by 2 pi where it has to multiply
    assert log.outputs["yaw_rad"] == pytest.approx(2 * np.pi * 2 * k / 2048)
    assert log.outputs["wheel_rad"] == pytest.approx(-2 * np.pi * 7 * k / 1024)
    assert log.supply == pytest.approx(np.full(50, 11.5))


def test_gaps_are_noted_and_long_ones_end_a_log(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    raw.write_bytes(b"".join(stream([*range(50), *range(53, 100), *range(140, 200), 230, 231], LIKE_RIG)))
    paths, remarks = write_logs(raw, RIG, tmp_path / "run.csv")
    assert [p.name for p in paths] == ["run-1.csv", "run-2.csv"]
    assert remarks == ["1 stretch of under 10 samples is left out", "run-1.csv: gap of 3 samples before 0.53 s"]
    log = read_log(paths[0], RIG)
    assert log.notes["gap"] == "3 samples before 0.53 s" and len(log.time) == 97


def test_a_gap_in_which_the_command_changed_ends_a_log(tmp_path: Path) -> None:
    """What a row tells is held until the next: over a gap in a multisine that would be a command that nobody gave."""
    raw = tmp_path / "run.raw"
    said = [SAMPLE._replace(tick=k, pulse_1=3000 + k // 40 % 2) for k in range(160) if k not in (60, 61, 80, 125)]
    raw.write_bytes(b"".join(wire(s, k) for k, s in enumerate(said)))
    paths, remarks = write_logs(raw, RIG, tmp_path / "run.csv")
    assert [len(read_log(path, RIG).time) for path in paths] == [78, 78]  # ends where 79 and 81 differ
    assert remarks == ["run-1.csv: gap of 2 samples before 0.62 s", "run-2.csv: gap of 1 sample before 0.45 s"]


def test_what_the_board_counted_reaches_the_notes(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    before = SAMPLE._replace(missed=65_535, dropped=7, damaged=3, overruns=254)
    said = [before._replace(tick=k) for k in range(50)]
    said[30:] = [s._replace(missed=2, dropped=8, damaged=3, overruns=1) for s in said[30:]]
    raw.write_bytes(b"".join([wire(LIKE_RIG._replace(reset_cause=8), 0), *(wire(s, k) for k, s in enumerate(said))]))
    (path,), remarks = write_logs(raw, RIG, tmp_path / "run.csv")
    told = [
        "3 ticks missed",
        "1 frame dropped for lack of room on the line",
        "3 bytes of the host lost",
        "its last start was by the watchdog",
    ]
    assert read_log(path, RIG).notes["board"] == "; ".join(told)
    assert remarks == [f"run.csv: the board: {trouble}" for trouble in told]


def test_only_what_was_played_is_the_log_of_an_experiment(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    said = [SAMPLE._replace(tick=k, playing=20 <= k < 60) for k in range(100)]
    raw.write_bytes(b"".join(wire(s, k) for k, s in enumerate(said)))
    (path,), _ = write_logs(raw, RIG, tmp_path / "run.csv")
    assert len(read_log(path, RIG).time) == 40


def ended(folder: Path, said: Iterable[Message]) -> str:
    """What the logs of a run of 3.6 s, and the remarks on it, say of its end."""
    raw = folder / "run.raw"
    raw.write_bytes(b"".join(wire(one, k) for k, one in enumerate(said)))
    (folder / "run.notes").write_text("experiment: square, 2 V about 0 V, period 1 s, 3 s\n")
    paths, remarks = write_logs(raw, RIG, folder / "run.csv")
    (found,) = {read_log(path, RIG).notes.get("ended", "") for path in paths}
    assert [remark for remark in remarks if "ended" in remark] == ([f"the run ended {found}"] if found else [])
    return found


def samples(ticks: Iterable[int], first: int = 20, last: int = 378) -> list[Message]:
    """Samples at these ticks, those from the first to the last marked as played; a board does not mark its last tick."""
    return [SAMPLE._replace(tick=k % 2**32, playing=int(first <= k <= last)) for k in ticks]


@pytest.mark.parametrize(
    ("ticks", "last", "said"),
    [
        (range(400), 378, ""),
        (range(400), 377, "early, after 3.58 s of 3.6 s"),
        (range(20, 379), 378, ""),
        (range(20, 60), 378, "early, after 0.4 s of 3.6 s"),
        ([*range(20, 60), *range(90, 130)], 378, "early, after 1.1 s of 3.6 s"),
        ([*range(10), *range(50, 400)], 378, ""),
        ([*range(350), *range(390, 400)], 378, ""),
        ([*range(10), *range(50, 400)], 367, "early, after at most 3.58 s of 3.6 s"),
        ([*range(100), *range(200, 400)], 149, "early, after at most 1.8 s of 3.6 s"),
    ],
    ids=(
        "whole",
        "a tick short",
        "whole and nothing beside it",
        "the stream stops",
        "the stream stops after a gap that ends a log",
        "its first samples are lost",
        "its last samples are lost",
        "its first samples are lost and it broke off",
        "it broke off in a gap",
    ),
)
def test_a_log_says_at_its_head_that_its_run_ended_early(
    tmp_path: Path, ticks: Iterable[int], last: int, said: str
) -> None:
    assert ended(tmp_path, samples(ticks, last=last)) == said


def test_the_end_of_a_run_is_told_in_the_boards_own_ticks(tmp_path: Path) -> None:
    whole = samples(range(800), last=738)
    assert ended(tmp_path, [LIKE_RIG._replace(tick_hz=200), *whole]) == ""
    (tmp_path / "run.csv").unlink()
    broken = samples(range(400), last=219)
    assert ended(tmp_path, [LIKE_RIG._replace(tick_hz=200), *broken]) == "early, after 1 s of 3.6 s"


def test_a_counter_that_begins_again_within_a_run_ends_nothing(tmp_path: Path) -> None:
    ticks = [k - 100 for k in (*range(90), *range(110, 400))]  # a gap over the wrap
    assert ended(tmp_path, samples(ticks, first=-80, last=278)) == ""


def test_a_new_start_of_the_board_ends_a_run(tmp_path: Path) -> None:
    """By its HELLO, or where that is lost by ticks that go back; how long the rest of the line is says nothing then."""
    broken, again = samples(range(100)), [LIKE_RIG._replace(nonce=8), *samples(range(400, 900))]
    for start in (again, samples(range(15))):
        assert ended(tmp_path, [LIKE_RIG, *broken, *start]) == "early, after 0.8 s of 3.6 s"
        (tmp_path / "run.csv").unlink()


@pytest.mark.parametrize("hello", ([], [LIKE_RIG._replace(nonce=8)]), ids=("unheard", "heard"))
def test_nothing_is_said_of_the_end_of_a_run_that_two_starts_have_played(tmp_path: Path, hello: list[Hello]) -> None:
    assert ended(tmp_path, [LIKE_RIG, *samples(range(60, 100)), *hello, *samples(range(15, 50))]) == ""


def test_what_somebody_has_noted_stays_before_what_is_noted_of_a_run(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    raw.write_bytes(b"".join(wire(one, k) for k, one in enumerate([HELLO, *samples([*range(100), *range(103, 120)])])))
    mine = "ended: see the book\ncounts: by hand\ngap: loose plug\nboard:\n"
    (tmp_path / "run.notes").write_text(f"experiment: square, 2 V about 0 V, period 1 s, 3 s\n{mine}")
    (path,), remarks = write_logs(raw, RIG, tmp_path / "run.csv")
    notes = read_log(path, RIG).notes
    assert notes["ended"] == "see the book; early, after 1 s of 3.6 s"
    assert notes["counts"] == f"by hand; {remarks[0]}" and notes["gap"] == "loose plug; 3 samples before 0.83 s"


def test_the_other_output_and_encoder_where_the_rig_says_so() -> None:
    said = [SAMPLE._replace(tick=k, count_1=k, count_2=9 * k, pulse_2=3100) for k in range(20)]
    (found,), _ = stretches(b"".join(wire(s, k) for k, s in enumerate(said)))
    table = columns(found, replace(RIG, columns={"position": "pos2", "pulse": "pwm_2"}))
    assert table["yaw_counts"][1] == 9 and table["wheel_counts"][1] == 1 and table["voltage_V"][0] == 1.0


def test_a_rig_without_pulses_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r"no `drive.pwm`; a recording needs `pwm = \{"):
        write_logs(tmp_path / "run.raw", replace(RIG, pwm=None), tmp_path / "run.csv")


def test_nothing_is_the_log_of_an_experiment_that_was_not_played(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    raw.write_bytes(b"".join(stream(range(100), LIKE_RIG)))
    (tmp_path / "run.notes").write_text("experiment: square, 2 V about 0 V, period 1 s, 3 s\n")
    assert write_logs(raw, RIG, tmp_path / "run.csv") == (
        [],
        ["1 stretch in which nothing was played is left out"],
    )
    said = [SAMPLE._replace(tick=k, playing=k >= 140) for k in (*range(100), *range(130, 200))]
    raw.write_bytes(b"".join(wire(s, k) for k, s in enumerate(said)))
    (path,), remarks = write_logs(raw, RIG, tmp_path / "run.csv")
    assert len(read_log(path, RIG).time) == 60
    assert remarks[1:] == ["the run ended early, after 0.6 s of 3.6 s"]


def test_no_log_is_written_where_one_of_them_is_there_already(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    raw.write_bytes(b"".join(stream([*range(50), *range(100, 150)], LIKE_RIG)))
    (tmp_path / "run-2.csv").write_text("precious")
    with pytest.raises(LogError, match="run-2.csv: exists already; a recording never replaces another"):
        write_logs(raw, RIG, tmp_path / "run.csv")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run-2.csv", "run.raw"]
    assert (tmp_path / "run-2.csv").read_text() == "precious"


def test_a_board_that_disagrees_with_the_rig_file_is_told(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    raw.write_bytes(b"".join(stream(range(50))))
    (path,), remarks = write_logs(raw, RIG, tmp_path / "run.csv")
    assert remarks == [
        "the firmware's config.h has 2048 counts a turn for the encoder of the wheel, the rig file 1024, which is used"
    ]
    assert [read_log(path, RIG).notes["counts"]] == remarks
    raw.write_bytes(b"".join(stream(range(50), LIKE_RIG._replace(pulse_neutral=2000))))
    with pytest.raises(RigError, match="`neutral_us` is 1500, and the board's neutral pulse lasts 1000 us"):
        write_logs(raw, RIG, tmp_path / "other.csv")


def test_several_logs_are_numbered_and_notes_may_be_absent(tmp_path: Path) -> None:
    assert numbered(tmp_path / "run.csv", 2) == tmp_path / "run-2.csv"
    assert read_notes(tmp_path / "run.notes") == {}
    (tmp_path / "run.notes").write_text("why: because: of it\nno colon\n")
    assert read_notes(tmp_path / "run.notes") == {"why": "because: of it"}


def test_a_line_of_the_notes_is_one_note(tmp_path: Path) -> None:
    """Other line breaks than those of text files are within a note."""
    (tmp_path / "run.notes").write_bytes(
        "why: a\x0b add axis.inertia: 9\x85role: validate\u2028run: b\r\nrun: c\n".encode()
    )
    assert read_notes(tmp_path / "run.notes") == {
        "why": "a\x0b add axis.inertia: 9\x85role: validate\u2028run: b",
        "run": "c",
    }


def test_a_board_that_does_not_tick_is_refused(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    raw.write_bytes(b"".join(stream(range(50), LIKE_RIG._replace(tick_hz=0))))
    with pytest.raises(LogError, match=r"run.raw: the board says that it ticks 0 times a second"):
        write_logs(raw, RIG, tmp_path / "run.csv")
    assert list(tmp_path.iterdir()) == [raw]


def test_notes_that_somebody_has_edited_are_notes_of_the_log(tmp_path: Path) -> None:
    raw = tmp_path / "run.raw"
    raw.write_bytes(b"".join(stream(range(50), LIKE_RIG)))
    (tmp_path / "run.notes").write_text(
        "# role: validate\n: nothing\n\t#: nothing\n\t# rig: a\n\n##\x1b[2J: red\nwhy: it: is\n"
    )
    (path,), _ = write_logs(raw, RIG, tmp_path / "run.csv")
    notes = read_log(path, RIG).notes
    assert (
        notes["rig"] == "a" and notes["role"] == "validate" and notes["why"] == "it: is" and notes[r"\x1b[2j"] == "red"
    )


def test_a_battery_that_reads_nothing_is_no_supply(tmp_path: Path) -> None:
    """A board that is fed over USB alone: readers refuse a supply of 0 V."""
    raw = tmp_path / "run.raw"
    said = [SAMPLE._replace(tick=k, battery=12_000 if k < 40 else 0) for k in range(50)]
    raw.write_bytes(b"".join([wire(LIKE_RIG, 0), *(wire(s, k + 1) for k, s in enumerate(said))]))
    (path,), remarks = write_logs(raw, RIG, tmp_path / "run.csv")
    assert remarks == ["run.csv: the battery reads 0 V, so `supply_V` is left out"]
    assert read_log(path, RIG).supply is None
