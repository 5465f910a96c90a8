"""Motion of one body: smoothed readings and draws of them."""

from rwjax.diagnosis.localise.body_motion import Own, read_body
from rwjax.diagnosis.settings import LocalisationSettings
from rwjax.fitting.prediction import every_output
from tests.diagnosis.localise.measured import as_given
from tests.diagnosis.simulated import true_log
from tests.systems import platform

SETTINGS = LocalisationSettings()


def test_draws_stand_beside_the_readings_of_a_body() -> None:
    rig = platform("viscous = 0.02")
    fitted = as_given(rig, true_log(rig))
    read = read_body(fitted, 0, "yaw", SETTINGS, Own(every_output(fitted.problem, fitted.theta, fitted.start)[0], 3))
    assert read is not None and read.readings.shape[1] == 4 and read.rate.shape == read.readings.shape
    assert read_body(fitted, 0, "wheel", SETTINGS) is None
