"""What notes say: the role of a run, what was added to the rig, what is to be ignored."""

import re

import numpy as np
import pytest

from rwjax.errors import LogError
from rwjax.rig.read import parse_rig
from tests.logs.texts import HEADER, ROWS

MALFORMED = [
    (["# ignore: yaw", HEADER, *ROWS], "`# ignore: yaw`: no such column; the nearest is `yaw_counts`"),
    (["# a: b", "# role: test", HEADER, *ROWS], ":2: `# role: test` is unknown; it is `train` or `validate`"),
]


@pytest.mark.parametrize(("lines", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_a_note_that_cannot_be_is_refused_in_one_line(refused, lines: list[str], message: str) -> None:
    refused(lines, message)


@pytest.mark.parametrize(
    ("note", "validate"),
    [("", False), ("# role: train", False), ("# Role: validate", True), ("# role: Validate,,", True)],
)
def test_the_role_says_whether_a_log_is_held_out(log, note: str, validate: bool) -> None:
    assert log([note, HEADER, *ROWS]).validate == validate


def test_a_run_may_be_called_by_the_word_of_a_role(log) -> None:
    assert log(["# run: validate", "# why: train", HEADER, *ROWS]).notes == {"run": "validate", "why": "train"}


@pytest.mark.parametrize("sign", ["\u2028", "\x0b", "\x0c", "\x1c", "\x85"])
def test_only_a_line_break_ends_a_note(log, sign: str) -> None:
    run = log([f"# why: a{sign}# role: validate{sign}role: validate", HEADER, *ROWS])
    assert not run.validate and run.notes == {"why": f"a{sign}# role: validate{sign}role: validate"}


def test_an_effect_s_number_keeps_its_range_with_what_was_added(log) -> None:
    rig = parse_rig(
        'kind = "platform"\ndrive.gain = 1\naxis.inertia = 1\nencoder.counts_per_rev = 256\n'
        '[effects."axis.coulomb"]\nM_c = 0.1'
    )
    with pytest.raises(
        LogError, match=re.escape("makes `axis.coulomb.M_c` -0.1 from 0.1; it has to be zero or positive")
    ):
        log(["# add axis.coulomb.M_c: -0.2", HEADER, *ROWS], rig)


def test_nothing_is_added_to_what_follows_from_others(log) -> None:
    rig = parse_rig(
        'kind = "platform"\ndrive.gain = 1\naxis.inertia = 1\nencoder.counts_per_rev = 256\n'
        '[fit.tied]\n"axis.friction.viscous" = "axis.inertia / 2"'
    )
    with pytest.raises(LogError, match=re.escape("`axis.friction.viscous` is axis.inertia / 2 by `fit.tied`; add to")):
        log(["# add axis.friction.viscous: 0.2", HEADER, *ROWS], rig)


def test_columns_that_a_note_says_to_ignore_are_not_looked_at(log):
    more = [f"{HEADER},temperature_C,state", *(f"{row},21.5,warm" for row in ROWS)]
    read, plain = log(["# ignore: temperature_C, state", *more]), log([HEADER, *ROWS])
    assert read.outputs.keys() == plain.outputs.keys()
    assert np.array_equal(read.outputs["yaw_rad"], plain.outputs["yaw_rad"])


def test_other_notes_may_begin_with_add(log):
    assert log(["# add: weights on both ends", "# add weight at: 12:30", HEADER, *ROWS]).added == {}


def test_what_a_run_had_more_is_read_by_name(log):
    for remark in ("# add grease: the red one", "# add: 5", "# add magnet: 2"):
        assert log([remark, HEADER, *ROWS]).added == {}
    assert log(["# add axis.inertia: 0.012", HEADER, *ROWS]).added == {"axis.inertia": 0.012}
    effect = parse_rig(
        'kind = "platform"\ndrive.gain = 1\naxis.inertia = 1\nencoder.counts_per_rev = 256\n'
        '[effects."axis.coulomb"]\nM_c = 0.1'
    )
    assert log(["# add axis.coulomb.M_c: -0.01", HEADER, *ROWS], effect).added == {"axis.coulomb.M_c": -0.01}


@pytest.mark.parametrize(
    ("note", "message"),
    [
        ("# add axis.inertia: -2", "makes `axis.inertia` -1 from 1"),
        (
            "# add axis.inertia: 1e300",
            "makes `axis.inertia` 1e+300 from 1; an inertia lies between 1e-12 and 1e+12 kg m2",
        ),
        ("# add axis.intertia: 1", "the rig file has no `axis.intertia`; the nearest is `axis.inertia`"),
        ("# add inertia: 0.01 kg m2", "the rig file has no `inertia`; the nearest is `axis.inertia`"),
        ("# add axis.inertia: much", "has to be one number, such as `# add axis.inertia: 0.012`"),
        ("# add axis.inertia: inf", "has to be one number"),
    ],
)
def test_a_difference_that_cannot_be_is_refused(log, note, message):
    with pytest.raises(LogError, match=re.escape(message)):
        log([note, HEADER, *ROWS])
