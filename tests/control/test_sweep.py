"""A sweep is many closed loops: each lane against the loop run by itself."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control import sweep as module
from rwjax.control.breakaway import breakaway
from rwjax.control.closed_loop import ClosedLoopRun, run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.response import step_response
from rwjax.control.sweep import step_responses
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, reaction

CLOCK = LoopTiming(period=0.02, steps=2, delay_steps=1, counts=2048)
CONTROLLERS = [Controller(kp, 0.5, kd, 0.02, voltage_limit=3.0) for kp in (2.0, 6.0, 12.0) for kd in (0.5, 3.0)]


@pytest.mark.parametrize("lanes", [5, 400])  # several blocks, the last one padded; and one
def test_every_lane_is_the_loop_run_by_itself(lanes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LANES", lanes)
    rig = platform()
    structure = structure_of(rig)
    light = rig.with_values({"axis.inertia": 0.07})
    thetas = np.stack([theta_of(rig, structure), theta_of(light, structure)])
    references = np.array([[0.2] * 150, [0.5] * 30 + [-0.1] * 120])
    found = step_responses(rig, CONTROLLERS, references, CLOCK, thetas, since=30)
    assert found.overshoot.shape == (6, 2, 2)
    for g, controller in enumerate(CONTROLLERS):
        for r, reference in enumerate(references):
            for k, plant in enumerate((rig, light)):
                run = run_rig(plant, controller, reference, CLOCK)
                late = ClosedLoopRun(*(x[30:] for x in run))
                alone = step_response(late, reference[-1], CLOCK.period, controller.voltage_limit)
                for whole, one in zip(found, alone, strict=True):
                    assert float(whole[g, r, k]) == pytest.approx(float(one), rel=1e-9, abs=1e-12)


def test_a_reference_that_goes_on_changing_is_refused() -> None:
    with pytest.raises(ValueError, match="from sample 10 on"):
        step_responses(platform(), CONTROLLERS, np.linspace(0.0, 1.0, 50)[None], CLOCK, since=10)


def test_the_wheel_s_fastest_rate_is_seen() -> None:
    run = run_rig(reaction(), Controller(40.0, kd=10.0, voltage_limit=10.0), np.full(300, 0.3))
    assert float(step_response(run, 0.3, 0.01).fastest) == pytest.approx(float(jnp.max(jnp.abs(run.wheel))))


WITH = {
    "with a dead zone": {"drive.deadzone": {"u_0": 0.3, "j": 0.0}},
    "with friction that grows with the load": {"axis.load_friction": {"mu": 0.4}},
    "with a load": {"axis.bias_torque": {"T": -0.007}},
}


@pytest.mark.parametrize("share, moves", [(0.999, False), (1.001, True)])
@pytest.mark.parametrize("kind", ["platform", "reaction", *WITH])
def test_breakaway_is_where_the_axis_lets_go(kind: str, share: float, moves: bool) -> None:
    friction = "coulomb = 0.01\nstatic = 0.015\nstribeck_velocity = 0.1"
    rig = reaction(friction) if kind == "reaction" else platform(friction)
    rig = replace(rig, effects=WITH.get(kind, {}))
    push = Controller(0.0, feedforward=share * breakaway(rig))
    # the wheel of a reaction rig speeds up and takes the torque away: the first instants decide, and need no inductance
    rig = parse_rig(_without_inductance(rig)) if kind == "reaction" else rig
    run = run_rig(rig, push, np.full(4, 1.0), LoopTiming(1e-3, 1))
    assert bool(np.any(np.asarray(run.angle) != 0.0)) == moves


def _without_inductance(rig) -> str:
    from rwjax.rig.write import write_rig

    return "\n".join(line for line in write_rig(rig).splitlines() if not line.startswith("inductance"))
