"""What is still a guess of a servo is said, and no longer once its comment is gone or a fit estimates it."""

from rwjax import parse_rig
from rwjax.fitting.questions.guesses import about_guesses

TEXT = """kind = "joint"
[drive.servo]
acts_on = "torque"   # a guess: or "voltage"
kp = 10.0   # N m/rad: a guess
kd = 0.0   # given
[axis]
inertia = 0.1   # a guess
[fit]
free = [{}]
"""


def test_what_is_a_guess_by_its_comment_is_named_and_what_the_file_does_not_say() -> None:
    (said,) = about_guesses(parse_rig(TEXT.format("")))
    assert said.startswith("of [drive.servo] acts_on and kp are guesses") and "axis" not in said
    assert "no limit and a period of 0.001 s count besides" in said
    limited = TEXT.format("").replace("kd = 0.0", "limit = 2.0\nperiod = 0.004\nkd = 0.0")
    assert "besides" not in about_guesses(parse_rig(limited))[0]


def test_what_a_fit_estimates_or_somebody_wrote_is_no_guess() -> None:
    known = TEXT.replace("   # a guess: or", "   # or")
    assert "acts_on" in about_guesses(parse_rig(TEXT.format('"drive.servo.kp"')))[0]
    assert about_guesses(parse_rig(known.format('"drive.servo.kp"'))) == []
    assert about_guesses(parse_rig(known.replace("   # N m/rad: a guess", "").format(""))) == []
