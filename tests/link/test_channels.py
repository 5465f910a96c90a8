"""Which channels of a board belong to a rig, and whether the two agree."""

from dataclasses import replace

import pytest

from rwjax.errors import RigError
from rwjax.link.channels import channels, check_board, pwm_of
from tests.link.ports import HELLO, LIKE_RIG, RIG


@pytest.mark.parametrize(
    ("kind", "named", "output", "encoders"),
    [
        ("reaction", {}, 0, {"axis": 0, "wheel": 1}),
        ("reaction", {"position": "pos2", "pulse": "pwm_2"}, 1, {"axis": 1, "wheel": 0}),
        ("wheel", {}, 0, {"wheel": 0}),
        ("wheel", {"position": "pos2"}, 0, {"wheel": 1}),
        ("platform", {"position": "pos2"}, 0, {"axis": 1}),
    ],
)
def test_every_kind_of_rig_has_its_channels(
    kind: str, named: dict[str, str], output: int, encoders: dict[str, int]
) -> None:
    assert channels(replace(RIG, kind=kind, columns=named)) == (output, encoders)


def test_a_recording_needs_pulses_and_counts() -> None:
    assert pwm_of(RIG) == RIG.pwm
    with pytest.raises(RigError, match=r"no `drive.pwm`; a recording needs `pwm = \{"):
        pwm_of(replace(RIG, pwm=None))
    with pytest.raises(
        RigError, match=r"no `counts_per_rev`; a recording needs one under \[encoder\] or \[wheel_encoder\]"
    ):
        pwm_of(replace(RIG, counts_per_rev={}))


def test_a_board_that_counts_otherwise_is_remarked_and_one_with_other_pulses_refused() -> None:
    assert check_board(LIKE_RIG, RIG) == []
    (remark,) = check_board(HELLO, RIG)
    assert remark == (
        "the firmware's config.h has 2048 counts a turn for the encoder of the wheel, the rig file 1024, which is used"
    )
    with pytest.raises(RigError, match="`neutral_us` is 1500, and the board's neutral pulse lasts 1000 us"):
        check_board(LIKE_RIG._replace(pulse_neutral=2000), RIG)
