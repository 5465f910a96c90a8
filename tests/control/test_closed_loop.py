"""The nonlinear loop: exact where it is linear, and what friction, counts and limits do to it."""

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.response import step_response
from rwjax.errors import InputError
from tests.control.loop_rigs import FREE_TEXT, TESTBED_TEXT

FREE = parse_rig(FREE_TEXT)
DRY = parse_rig('kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\ncoulomb = 0.05')
TESTBED = parse_rig(TESTBED_TEXT)
STEP = np.full(800, 0.3)


def delayed(command: float, reading: float = 0.0) -> str:
    return f'\n[effects."drive.delay"]\ntau = {command}\n[effects."sensor.delay"]\ntau = {reading}'


# steps that the controller takes and times of the rig; 0.003 s is the testbed's, 0.0375 s are three periods and three of four steps
@pytest.mark.parametrize(
    ("late", "own"),
    [
        (0.0, ""),
        (1.0, ""),
        (1.5, ""),
        (4.0, ""),
        (0.5, delayed(0.003)),
        (1.0, delayed(0.01, 0.025)),
        (2.0, delayed(0.005)),
        (0.0, delayed(0.1, 0.05)),
    ],
)
def test_without_friction_the_loop_is_its_recursion(late: float, own: str) -> None:
    clock, kp, kd, ki, smooth = LoopTiming(delay_steps=late), 3.0, 2.0, 0.5, 0.02
    run = run_rig(parse_rig(FREE_TEXT + own), Controller(kp=kp, ki=ki, kd=kd, filter_time=smooth), STEP, clock)
    h, x, v, before, slope, integral, given = 0.01, 0.0, 0.0, 0.3, 0.0, 0.0, []
    wait = (
        late * h / 4.0
        + {
            "": 0.0,
            delayed(0.003): 0.003,
            delayed(0.01, 0.025): 0.035,
            delayed(0.005): 0.005,
            delayed(0.1, 0.05): 0.15,
        }[own]
    )
    for k in range(len(STEP)):
        assert run.angle[k] == pytest.approx(x, abs=1e-10)
        error = 0.3 - x
        slope = (smooth * slope + error - before) / (smooth + h)
        u = kp * error + ki * integral + kd * slope
        integral, before = integral + h * error, error
        given.append(u)
        for step in range(4):  # the mean command of each: what was given `wait` before
            begin, time = h * k + h / 4.0 * step, h / 4.0
            change = h * np.floor((begin - wait) / h + 1.0 + 1e-9) + wait  # the next one comes then
            share = np.clip((change - begin) / time, 0.0, 1.0)
            last = round((change - wait) / h)
            old, new = (given[i] if 0 <= i < len(given) else 0.0 for i in (last - 1, last))
            command = share * old + (1.0 - share) * new
            x, v = x + v * time + 2.0 * command * time**2, v + 4.0 * command * time


def test_the_wheel_takes_the_momentum_that_the_axis_gets() -> None:
    run = run_rig(TESTBED, Controller(kp=40.0, kd=10.0, voltage_limit=10.0), STEP)
    total = 0.0495 * np.asarray(run.rate) + 1.24e-4 * np.asarray(run.wheel)
    assert np.max(np.abs(total)) < 1e-12 and np.max(np.abs(run.wheel)) > 50.0
    assert run.angle[-1] == pytest.approx(0.3, abs=1e-3)  # positive gains restore, though a command turns it backwards


@pytest.mark.slow
def test_friction_leaves_an_error_that_an_integral_or_a_feed_forward_removes() -> None:
    def left(**gains: float) -> float:
        run = run_rig(DRY, Controller(kp=2.0, kd=1.5, **gains), np.full(3000, 0.3))
        return abs(float(step_response(run, 0.3, 0.01).error))

    plain = left()
    assert 0.005 < plain <= 0.05 / 0.4 / 2.0  # what the dry friction holds against the proportional part
    assert left(ki=1.0) < 0.2 * plain
    assert left(feedforward=0.9 * 0.05 / 0.4, deadband=1e-3) < 0.2 * plain


def test_a_limited_command_saturates_and_its_integral_does_not_wind_up() -> None:
    run = run_rig(FREE, Controller(kp=5.0, ki=5.0, kd=5.0, voltage_limit=0.3), np.full(3000, 2.0))
    assert np.max(np.abs(run.command)) == 0.3
    found = step_response(run, 2.0, 0.01, voltage_limit=0.3)
    # an integral that went on while the command is clipped would swing from limit to limit for ever
    assert found.saturated > 0.02 and found.overshoot < 0.3 and np.isfinite(found.settling)


def test_the_wheel_is_not_driven_beyond_its_limit() -> None:
    free, held = (
        run_rig(TESTBED, Controller(kp=40.0, kd=10.0, voltage_limit=10.0, wheel_rate_limit=spin), np.full(400, 2.0))
        for spin in (np.inf, 60.0)
    )
    assert np.max(np.abs(free.wheel)) > 100.0
    assert np.max(np.abs(held.wheel)) < np.max(np.abs(free.wheel))
    assert np.max(np.abs(held.wheel[-100:])) < 60.5  # beyond it only while the inductance keeps the current going


def test_counts_make_a_cycle_no_larger_than_a_few_of_them() -> None:
    count = 2.0 * np.pi / 512
    run = run_rig(FREE, Controller(kp=3.0, kd=2.0, filter_time=0.02), STEP, LoopTiming(counts=512))
    found = step_response(run, 0.3, 0.01)
    assert found.cycle < 3.0 * count and abs(found.error) < 3.0 * count


def test_the_integral_stands_still_while_the_wheel_is_held() -> None:
    # momentum is missing: the axis turns on at what the wheel's limit leaves, and the error shrinks slowly
    law = Controller(kp=40.0, ki=40.0, kd=10.0, voltage_limit=10.0, wheel_rate_limit=60.0)
    target = 2.0
    run = run_rig(TESTBED, law, np.full(2500, target))
    held = np.flatnonzero(np.abs(run.wheel) >= 59.0)
    assert len(held) > 300
    plain = run_rig(TESTBED, law._replace(ki=0.0), np.full(2500, target))
    overshoot = np.max(run.angle) - target
    assert overshoot < 0.02 * target + max(np.max(plain.angle) - target, 0.0)


def test_what_the_loop_does_not_have_is_refused() -> None:
    lag = FREE_TEXT + '\n[effects."drive.lag"]\nT = 0.1'
    with pytest.raises(InputError, match=r"`drive\.lag`: .* leave it out$"):
        run_rig(parse_rig(lag), Controller(kp=1.0), STEP)
    late = TESTBED_TEXT + delayed(0.0, 0.02)
    run_rig(parse_rig(late), Controller(kp=1.0), STEP)
    with pytest.raises(InputError, match=r"^the wheel's rate is read at once and the angle 0\.02 s late"):
        run_rig(parse_rig(late), Controller(kp=1.0, wheel_rate_limit=100.0), STEP)
    with pytest.raises(InputError, match="no state `Omega`; this rig has psi, w"):
        run_rig(FREE, Controller(kp=1.0), STEP, Omega=3.0)
