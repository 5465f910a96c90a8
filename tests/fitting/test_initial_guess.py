"""What the first readings say of the initial state."""

from dataclasses import replace

import numpy as np

from rwjax.fitting.initial_guess import guess_initial_state, starts_at_rest
from rwjax.plant.from_rig import structure_of
from rwjax.rig.columns_section import Source
from tests.systems import record, wheel

TIME = np.arange(601) * 0.01


def test_an_offset_of_the_current_does_not_set_a_run_in_motion() -> None:
    u = np.where(TIME > 0.6, 3.0, 0.0)
    log = record(TIME, u, {"yaw_rad": np.zeros_like(TIME), "current_A": np.full_like(TIME, 0.02)})
    assert starts_at_rest(log)
    assert not starts_at_rest(record(TIME, u + 0.004, log.outputs))


def test_a_command_that_begins_with_the_last_of_the_first_readings_acts_after_them() -> None:
    """At 100 Hz the sample of 0.50 s belongs to the first half second, and what is commanded there does not."""

    def begins(sample: int) -> bool:
        return starts_at_rest(record(TIME, np.where(np.arange(601) >= sample, 3.0, 0.0), {"yaw_rad": np.zeros(601)}))

    assert begins(50) and not begins(49)
    rare = TIME[::40]  # two samples in the first half second: what is commanded there is all that there is to ask
    assert not starts_at_rest(record(rare, np.full_like(rare, 3.0), {"yaw_rad": np.zeros_like(rare)}))


def test_a_rate_without_its_sign_begins_with_that_of_the_angle_or_of_the_command() -> None:
    unsigned = replace(wheel(), sources={name: Source(name, unsigned=True) for name in ("wheel_rad_s", "current_A")})
    structure = structure_of(unsigned)
    speed, rate = np.full_like(TIME, 5.0), structure.states.index("Omega")
    for volts, sign in ((-3.0, -1.0), (3.0, 1.0)):
        log = record(TIME, np.full_like(TIME, volts), {"wheel_rad_s": speed, "current_A": speed})
        guess = guess_initial_state(structure, log, rest=False)[0]
        assert np.allclose([guess[rate], guess[structure.states.index("i")]], sign * 5.0)
        turning = record(TIME, np.full_like(TIME, volts), {"wheel_rad_s": speed, "wheel_rad": -5.0 * TIME})
        assert abs(guess_initial_state(structure, turning, rest=False)[0][rate] + 5.0) < 1e-9
