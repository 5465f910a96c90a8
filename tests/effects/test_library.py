"""Every effect: its place in the library, its null, its bounds, its derivatives, and which way friction acts."""

from collections.abc import Callable
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.effects import axis, axis_friction, ports
from rwjax.effects.effect import Effect
from rwjax.effects.library import BY_NAME, EFFECTS, ON_TWO_AXES
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import AxisDry, AxisElastic, WheelDry
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import scales
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import Structure, friction_level
from rwjax.simulation.shooting import free_run
from tests.effects.rigs import ALONE, KIND, REST, RIGS, TIME, among, go, motion
from tests.systems import platform, record, run

PORTS = {
    ports.AxisTorque: "axis",
    ports.AxisDry: "axis",
    ports.AxisElastic: "axis",
    ports.Coupling: "axis",
    ports.WheelTorque: "wheel",
    ports.WheelDry: "wheel",
    ports.MotorTorque: "motor",
    ports.CurrentLimit: "motor",
    ports.Winding: "motor",
    ports.CommandMap: "drive",
    ports.CommandDelay: "drive",
    ports.CommandFilter: "drive",
    ports.Supply: "drive",
    ports.Encoder: "sensor",
    ports.EncoderDelay: "sensor",
    ports.Clock: "sensor",
}
ORDER = """
axis.viscous axis.coulomb axis.stribeck axis.quadratic_drag axis.asymmetric_friction axis.presliding axis.angle_friction
axis.load_friction axis.friction_drift axis.imbalance axis.spring axis.bias_torque axis.backlash axis.flexible_coupling
axis.end_stop axis.periodic_torque wheel.coulomb wheel.drag wheel.cogging motor.heating motor.saturation
motor.current_limit drive.deadzone drive.delay drive.lag drive.rate_limit drive.saturation drive.bias
drive.asymmetric_gain drive.supply_sag drive.curvature sensor.scale sensor.eccentricity sensor.delay
sensor.missed_counts sensor.clock
""".split()


def middle(effect: type[Effect]) -> Effect:
    """The effect with every parameter at its first search start."""
    return effect(**{name: jnp.asarray(p.starts[0]) for name, p in parameters(effect).items()})


def test_tables_and_ties_keep_their_order() -> None:
    """An effect that is added takes its place among these, which keep theirs: ties are broken by this order."""
    assert [effect.name for effect in EFFECTS if effect.name in ORDER] == ORDER


def test_names_are_unique_and_begin_with_the_place_of_their_port() -> None:
    every = (*EFFECTS, *ON_TWO_AXES)
    assert len(BY_NAME) == len(every) == len({effect.label for effect in every})
    for effect in EFFECTS:
        ports = [place for port, place in PORTS.items() if issubclass(effect, port)]
        assert len(ports) == 1 and effect.name.split(".")[0] == ports[0], effect.name


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_null_and_starts_lie_within_bounds(effect: type[Effect]) -> None:
    for name, p in parameters(effect).items():
        low, high = p.bounds
        assert low <= p.null <= high, name
        assert p.starts and (
            p.scale != "one" or all(low <= start <= high for start in p.starts if start is not None)
        ), name
        assert p.unit and p.tex, name


def test_shares_and_lengths_stay_physical() -> None:
    bounds = {f"{e.name}.{name}": p.bounds for e in EFFECTS for name, p in parameters(e).items()}
    missed = ("sensor.missed_counts.s", "sensor.missed_counts.j")
    for share in ("axis.flexible_coupling.s", "axis.backlash.s", "axis.load_friction.mu", *missed):
        assert bounds[share][0] >= 0.0 and bounds[share][1] <= 1.0, share
    for name, (low, _) in bounds.items():
        length = name.endswith((".tau", ".T", ".M_c", ".M_e", ".k", ".g", ".x_s")) and name != "axis.bias_torque.T"
        assert not length or low >= 0.0, name
    assert bounds["drive.asymmetric_gain.a"][0] > -1.0 < bounds["sensor.scale.s"][0]  # neither changes a sign


@pytest.mark.parametrize("effect", [e for e in EFFECTS if issubclass(e, AxisDry | WheelDry)], ids=lambda e: e.name)
@given(speed=st.floats(-30.0, 30.0))
def test_dry_friction_never_adds_energy(effect: type, speed: float) -> None:
    m = motion(w=speed, Omega=speed)._replace(psi=jnp.asarray(speed), load=jnp.asarray(speed))
    sign = 1.0 if speed >= 0.0 else -1.0
    assert sign * float(friction_level([middle(effect)], m, sign)) * speed >= 0.0


def test_a_negative_level_is_no_friction() -> None:
    weak = axis_friction.AsymmetricFriction(M_c=jnp.asarray(0.01), d=jnp.asarray(0.03))
    assert float(friction_level([weak], motion(), -1.0)) == 0.0  # 0.01 - 0.03 would drive the axis
    assert float(friction_level([weak], motion(), 1.0)) == pytest.approx(0.04, rel=1e-15)


def test_a_share_raises_all_other_dry_friction_and_no_share_of_its_own() -> None:
    stribeck = axis_friction.Stribeck(
        M_c=jnp.asarray(0.1), M_e=jnp.asarray(0.3), v_s=jnp.asarray(0.2), n=jnp.asarray(2.0)
    )
    warm = axis_friction.FrictionDrift(d=jnp.asarray(0.5), B=jnp.asarray(2.0), tau=jnp.asarray(1.0), s=jnp.asarray(0.0))
    spot = axis_friction.AngleFriction(*(jnp.asarray(share) for share in (0.0, 0.25, 0.0, 0.0)))
    for w in (0.0, 0.2):
        m, sliding = (
            motion(w=w),
            0.1 + 0.3 * np.exp(-((w / 0.2) ** 2)),
        )  # cold, and at the angle where the spot is worst
        assert np.isclose(float(friction_level([stribeck, warm], m, 1.0)), 1.5 * sliding + 2.0 * w, rtol=1e-12)
        assert np.isclose(float(friction_level([stribeck, spot], m, 1.0)), 1.25 * sliding, rtol=1e-12)


def test_starts_are_counted_from_their_origin_and_none_is_the_null() -> None:
    high, low = (parameters(axis.EndStop)[name] for name in ("high", "low"))
    sizes = {"span": 2.0, "highest": 1.5, "lowest": -0.5}
    found = list(zip(high.begin(sizes), low.begin(sizes), strict=True))
    assert found[:3] == [(1.494, -1e6), (1e6, -0.494), (1.494, -0.494)]


def test_breakaway_lies_above_sliding_friction() -> None:
    friction = axis_friction.Stribeck(
        M_c=jnp.asarray(0.05), M_e=jnp.asarray(0.04), v_s=jnp.asarray(0.2), n=jnp.asarray(2.0)
    )
    levels = [float(friction.level(motion(w=w), 1.0)) for w in (0.0, 0.2, 4.0)]
    assert levels == pytest.approx([0.09, 0.05 + 0.04 / np.e, 0.05], rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_asymmetric_friction_holds_one_way_and_slips_the_other(sign: float) -> None:
    # levels 0.05 +- 0.02 N m against 0.05 N m: forward 0.07 holds, backward 0.03 slips
    friction = {"axis.asymmetric_friction": {"M_c": 0.0, "d": 0.02}}
    y = run(platform(), record(TIME, np.full_like(TIME, sign * 0.05 / 0.4)), {}, effects=friction)
    assert (np.ptp(y["yaw_rad"]) == 0.0) if sign > 0.0 else (y["yaw_rad"][-1] < -0.1)


@pytest.mark.parametrize("kind", ["wheel", "platform", pytest.param("reaction", marks=pytest.mark.slow)])
def test_effects_at_their_null_are_the_base_plant(kind: str) -> None:
    u = 2.0 * np.sin(3.0 * TIME)
    outputs = dict.fromkeys(structure_of(RIGS[kind]).outputs, np.zeros_like(u))
    plain, same = run(RIGS[kind], record(TIME, u, outputs), {}), go(RIGS[kind], u, {}, {})
    for name, value in plain.items():  # the same but for the order in which a compiler adds
        assert np.max(np.abs(same[name] - value)) <= 1e-12 * np.max(np.abs(value)), name


@pytest.mark.parametrize("effect", ALONE, ids=lambda effect: effect.name)
def test_an_elastic_effect_at_its_null_is_almost_rigid(effect: type[Effect]) -> None:
    u = 2.0 * np.sin(3.0 * TIME)
    plain, same = go(RIGS["platform"], u, {}, {}), go(RIGS["platform"], u, {}, {effect.name: {}})
    assert np.max(np.abs(same["yaw_rad"] - plain["yaw_rad"])) < 5e-3 * np.max(np.abs(plain["yaw_rad"]))


@cache
def differentiated(structure: Structure) -> Callable:
    """Derivative of a free run's readings along a change of the numbers."""

    def along(theta, start, batch, d):
        return jax.jvp(lambda theta: free_run(structure, theta, start, batch)[0], (theta,), (d,))[1]

    return jax.jit(along)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_sensitivities_match_differences_of_the_free_run(effect: type[Effect]) -> None:
    rig = RIGS[KIND[effect.name.partition(".")[0]]]
    structure = structure_of(rig).with_effects(*among(effect.name, rig.kind))
    t = TIME[:201]
    u = 3.0 + np.sin(4.0 * t)  # one direction of motion
    begin = {"psi": 0.5, "w": 1.0, "theta": 0.5, "Omega": 20.0}
    plain = run(rig, record(t, u, dict.fromkeys(structure.outputs, np.zeros_like(t))), begin)
    log = record(t, u, plain)
    theta, typical = theta_of(rig, structure), scales(rig, [log])
    index, step = [], []
    for name, p in parameters(effect).items():
        k = structure.names.index(f"{effect.name}.{name}")
        # starts, a little off: at whole steps a delay has a derivative on either side
        small = (0.003 if name in ("s_2", "c_2") else 0.1) * typical[p.scale]
        theta[k] = np.clip(0.93 * next(filter(None, p.begin(typical)[::-1]), small), *p.bounds)
        index.append(k)
        step.append(1e-4 * max(abs(theta[k]), 1e-3 * abs(typical[p.scale])))
    problem = pose(structure, (log,), dict.fromkeys(structure.outputs, 1.0))
    start = np.array([[begin.get(name, 0.0) for name in structure.states]])

    derivative = differentiated(structure)
    y, _ = free_run(structure, theta, start, problem.batch)
    largest = 0.0
    for k, h in zip(index, step, strict=True):
        d = np.eye(len(theta))[k]
        found, differs = np.asarray(derivative(theta, start, problem.batch, d)), []
        for span in (h, 1e-2 * h, 1e-3 * h):  # the wider have less rounding, the others less curvature
            up, down = (np.asarray(free_run(structure, theta + x * d, start, problem.batch)[0]) for x in (span, -span))
            differs.append(np.max(np.abs(found - (up - down) / (2.0 * span))))
        size = np.max(np.abs(found))
        assert min(differs) <= 5e-4 * size + 1e-12 * np.max(np.abs(y)) / h, structure.names[k]
        largest = max(largest, float(size) * abs(theta[k]))
    assert largest > 1e-4 * np.max(np.abs(y))  # it does something here


FRICTION = [
    e for e in EFFECTS if issubclass(e, AxisDry | axis_friction.Viscous | axis_friction.QuadraticDrag | AxisElastic)
]


@pytest.mark.parametrize("effect", FRICTION, ids=lambda effect: effect.name)
def test_friction_slows_a_coasting_axis_and_never_drives_it(effect: type[Effect]) -> None:
    rig = platform("viscous = 0.0\ncoulomb = 0.05")
    given = {name: abs(p.starts[0]) * (1.0 if p.scale == "one" else 0.2) for name, p in parameters(effect).items()}
    plain, y = (go(rig, REST, {"w": 2.0}, effects) for effects in ({}, {effect.name: given}))
    back = 0.3 if issubclass(effect, AxisElastic) else 0.0  # what is bent springs back
    assert back or np.all(np.diff(y["yaw_rad_s"]) <= 1e-15)
    assert np.min(y["yaw_rad_s"]) >= -back
    unloaded = effect in (
        axis_friction.LoadFriction,
        axis_friction.AngleFriction,
    )  # no load here; as often less as more
    assert unloaded or y["yaw_rad"][-1] < plain["yaw_rad"][-1]
