"""The plan of a campaign as a table."""

from rwjax.planning.experiment import Experiment
from rwjax.planning.files import Plan, Run
from rwjax.report.plan import WIDTH, table, volts


def test_a_command_about_an_offset_is_told_with_its_sign() -> None:
    assert volts(Experiment("square", 3.566, -0.535, 6.0, 12.0)) == "±3.57 about -0.535"
    assert volts(Experiment("multisine", 2.0, 0.0, 4.0, 12.0)) == "±2"
    assert volts(Experiment("coast-down", -2.0, 0.0, 4.0, 12.0)) == "-2"


def test_repeats_share_a_row_and_peaks_have_their_units() -> None:
    square, stair = Experiment("square", 2.0, 0.0, 4.0, 12.0), Experiment("staircase", 3.0, 0.0, 8.0, 16.0)
    peaks = {"yaw_rad": 1.234, "wheel_rad_s": 104.71976}
    runs = (
        Run("square_1", square, "train", "reverses", (), peaks),
        Run("square_2", square, "train", "reverses", (), peaks),
        Run("stair", stair, "validate", "creeps", (), peaks | {"current_A": 1.0}),
    )
    lines = table(Plan("bench", {}, runs)).splitlines()
    assert max(map(len, lines)) <= WIDTH and not any(line.endswith(" ") for line in lines)
    rows = [line.split() for line in lines[-2:]]
    assert rows == [
        ["square_1", "…", "2", "±2", "4", "12", "1.23", "1000", "reverses"],  # 104.7 rad/s are 1000 turns a minute
        ["stair", "±3", "8", "16", "1.23", "1000", "creeps"],  # not every run has a current
    ]
