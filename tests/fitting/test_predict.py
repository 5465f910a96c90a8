"""The free run of a rig on a log."""

import numpy as np
import pytest

from rwjax import RigError, parse_rig
from rwjax.fitting.predict import predict
from tests.systems import platform, reaction, record, run

TIME = np.arange(601) * 0.01


PUSH = 0.8 * np.sign(np.sin(2.0 * TIME + 0.1))


def test_nothing_after_the_first_half_second_is_looked_at() -> None:
    rig = reaction()
    u = 8.0 * PUSH
    asked = record(TIME, u, {"yaw_rad": np.zeros_like(TIME), "current_A": np.zeros_like(TIME)})
    y = run(rig, asked, {"w": 0.3, "i": 1.0})
    rng = np.random.default_rng(0)
    noisy = {name: y[name] + rng.normal(0.0, 1e-3, len(TIME)) for name in asked.outputs}
    plain = predict(rig, record(TIME, u, noisy))
    late = TIME > 0.5
    changed = {name: value + np.where(late, rng.normal(0.0, 0.5, len(TIME)), 0.0) for name, value in noisy.items()}
    again = predict(rig, record(TIME, u, changed))
    for name in ("yaw_rad", "current_A"):
        assert again[name] == pytest.approx(plain[name], abs=1e-9)


def test_gravity_acts_on_an_angle_that_was_not_logged() -> None:
    rig = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02\n'
        "[axis.gravity]\ntorque = 0.5\nangle = 0.0"
    )
    still = np.zeros_like(TIME)
    asked = record(TIME, still, {"yaw_rad_s": still})
    y = run(rig, asked, {"psi": 1.0})["yaw_rad_s"]
    found = predict(rig, record(TIME, still, {"yaw_rad_s": y}))["yaw_rad_s"]
    assert found == pytest.approx(y, abs=1e-4)


def test_what_was_logged_is_predicted_and_everything_where_nothing_was() -> None:
    some = {"current_A": np.zeros_like(TIME), "yaw_rad": np.zeros_like(TIME)}
    assert {*predict(reaction(), record(TIME, PUSH, some))} == {*some}
    every = predict(reaction(), record(TIME, PUSH, {}))
    assert {*every} == {"yaw_rad", "yaw_rad_s", "wheel_rad", "wheel_rad_s", "current_A"}
    y = run(reaction(), record(TIME, PUSH, dict.fromkeys(every, np.zeros_like(TIME))), {})
    for name, value in every.items():
        assert value == pytest.approx(y[name], abs=1e-12), name


@pytest.mark.parametrize(
    "numbers",
    [
        "inertia = 1\naxis.friction.viscous = -9",
        "inertia = 1e-10",
        'inertia = 1\neffects."axis.imbalance" = { s = 1e12, c = 1 }',
    ],
    ids=["growing", "light", "not finite"],
)
def test_a_free_run_that_goes_further_than_any_rig_is_refused(numbers: str) -> None:
    rig = parse_rig(f'kind = "platform"\nname = "mine"\ndrive.gain = 1\naxis.{numbers}')
    said = r"^rig `mine`: its free run on test.csv goes beyond 1e\+0[69] rad(/s)? of yaw_rad(_s)? .* s after the start"
    with pytest.raises(RigError, match=said):
        predict(rig, record(TIME, np.ones_like(TIME), {}))


def test_a_free_run_prints_its_length_and_the_range_of_each_output() -> None:
    rig = platform()
    found = predict(rig, record(TIME, PUSH, {}))
    assert np.array_equal(found.time, TIME)
    head, *lines = str(found).splitlines()
    assert head.endswith(": 6 s, 601 samples") and len(lines) == len(found)
    angle = found["yaw_rad"]
    assert any(line.split() == ["yaw_rad", f"{angle.min():.4g}", "to", f"{angle.max():.4g}", "rad"] for line in lines)
