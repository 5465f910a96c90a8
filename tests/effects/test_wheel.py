"""Effects between wheel and body beside their closed forms."""

import numpy as np

from tests.effects.rigs import TIME
from tests.systems import record, run
from tests.systems import wheel as wheel_rig


def test_a_braked_wheel_stops_when_the_closed_form_says() -> None:
    # open circuit is not in the plant: at V = 0 back-EMF brakes too, b_e = b + K^2/R
    K, R, b, J, M_c, Omega0 = 0.0182, 0.83, 4.07e-6, 1.24e-4, 2e-3, 30.0
    t = TIME[:301]
    log = record(t, np.zeros_like(t), {"wheel_rad_s": np.zeros_like(t)})
    y = run(wheel_rig(0.0), log, {"Omega": Omega0}, effects={"wheel.coulomb": {"M_c": M_c}})
    braking = b + K**2 / R
    stop = J / braking * np.log1p(braking * Omega0 / M_c)
    exact = np.where(t < stop, (Omega0 + M_c / braking) * np.exp(-braking / J * t) - M_c / braking, 0.0)
    assert 0.2 < stop < 2.5
    assert np.max(np.abs(y["wheel_rad_s"] - exact)) < 1e-10 * Omega0  # samples beside the stop are exact too
    assert np.all(y["wheel_rad_s"][t > stop + 0.01] == 0.0)
