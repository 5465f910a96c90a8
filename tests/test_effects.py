"""Every effect by itself: in the library, absent at its null, with true derivatives, and with the motion it should have."""

import inspect
from collections.abc import Callable
from functools import cache, partial
from types import ModuleType
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.build import structure_of, theta_of
from rwjax.effects import BY_NAME, EFFECTS, axis, drive, motor, ports, sensor, wheel
from rwjax.effects.axis import Gravity, PolynomialFriction
from rwjax.effects.ports import AxisDry, AxisElastic, Coupling, Effect, Motion, WheelDry
from rwjax.fit.problem import pose
from rwjax.fit.scales import scales
from rwjax.param import parameters
from rwjax.plant import Structure, friction_level
from rwjax.rig import Rig
from rwjax.simulate import free_run
from tests.systems import platform, reaction, record, run
from tests.systems import wheel as wheel_rig

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
OF_THE_RIG_FILE = (
    PolynomialFriction,
    Gravity,
)  # terms that a rig models; nothing is diagnosed as missing of them
TIME = np.arange(1001) * 0.01
REST = np.zeros_like(TIME)
RIGS = {"wheel": wheel_rig(), "platform": platform(), "reaction": reaction("viscous = 0.003\ncoulomb = 0.002")}
LACKS = {"wheel": ("axis.",), "platform": ("wheel.", "motor."), "reaction": ()}
ALONE = [
    effect for effect in EFFECTS if issubclass(effect, AxisElastic | Coupling)
]  # no two of a port, none at its null
TOGETHER = {
    kind: [e.name for e in EFFECTS if e not in ALONE and not e.name.startswith(lacks)] for kind, lacks in LACKS.items()
}
KIND = {"axis": "platform", "wheel": "wheel", "motor": "wheel", "drive": "wheel", "sensor": "platform"}


def among(effect: str | None, kind: str) -> tuple[str, ...]:
    """Effects of the program in which an effect is tested: all that can stand side by side, or it alone."""
    return (effect,) if effect and BY_NAME[effect] in ALONE else tuple(TOGETHER[kind])


def go(rig: Rig, u: np.ndarray, start: dict[str, float], effects: dict[str, dict[str, float]]) -> dict[str, np.ndarray]:
    """Free run over `TIME` with effects, one program for all that can stand side by side."""
    alone = next((name for name in effects if BY_NAME[name] in ALONE), None)
    outputs = dict.fromkeys(structure_of(rig).outputs, np.zeros_like(u))
    return run(rig, record(TIME, u, outputs), start, effects={name: {} for name in among(alone, rig.kind)} | effects)


def motion(w: float = 0.0, Omega: float = 0.0) -> Motion:
    zero = jnp.zeros(())
    return Motion(
        t=zero,
        u=zero,
        psi=zero,
        w=jnp.asarray(w),
        theta=zero,
        Omega=jnp.asarray(Omega),
        i=zero,
        load=zero,
        sensed=zero,
        own={},
    )


def middle(effect: type[Effect]) -> Effect:
    """The effect with every parameter at its first search start."""
    return effect(**{name: jnp.asarray(p.starts[0]) for name, p in parameters(effect).items()})


@pytest.mark.parametrize("module", [axis, drive, motor, sensor, wheel], ids=lambda m: m.__name__)
def test_every_effect_is_in_the_library(module: ModuleType) -> None:
    here = [c for _, c in inspect.getmembers(module, inspect.isclass) if c.__module__ == module.__name__]
    assert {*here} <= {*EFFECTS, *OF_THE_RIG_FILE}


def test_names_are_unique_and_begin_with_the_place_of_their_port() -> None:
    assert len(BY_NAME) == len(EFFECTS) == len({effect.label for effect in EFFECTS})
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
    for share in ("axis.flexible_coupling.s", "axis.backlash.s", "sensor.missed_counts.s", "axis.load_friction.mu"):
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
    weak = axis.AsymmetricFriction(M_c=jnp.asarray(0.01), d=jnp.asarray(0.03))
    assert float(friction_level([weak], motion(), -1.0)) == 0.0  # 0.01 - 0.03 would drive the axis
    assert float(friction_level([weak], motion(), 1.0)) == pytest.approx(0.04, rel=1e-15)


def test_breakaway_lies_above_sliding_friction() -> None:
    friction = axis.Stribeck(M_c=jnp.asarray(0.05), M_e=jnp.asarray(0.04), v_s=jnp.asarray(0.2), n=jnp.asarray(2.0))
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


FRICTION = [e for e in EFFECTS if issubclass(e, AxisDry | axis.Viscous | axis.QuadraticDrag | AxisElastic)]


@pytest.mark.parametrize("effect", FRICTION, ids=lambda effect: effect.name)
def test_friction_slows_a_coasting_axis_and_never_drives_it(effect: type[Effect]) -> None:
    rig = platform("viscous = 0.0\ncoulomb = 0.05")
    given = {name: abs(p.starts[0]) * (1.0 if p.scale == "one" else 0.2) for name, p in parameters(effect).items()}
    plain, y = (go(rig, REST, {"w": 2.0}, effects) for effects in ({}, {effect.name: given}))
    back = 0.3 if issubclass(effect, AxisElastic) else 0.0  # what is bent springs back
    assert back or np.all(np.diff(y["yaw_rad_s"]) <= 1e-15)
    assert np.min(y["yaw_rad_s"]) >= -back
    unloaded = effect in (axis.LoadFriction, axis.AngleFriction)  # no load here; as often less as more
    assert unloaded or y["yaw_rad"][-1] < plain["yaw_rad"][-1]


FREE = platform("viscous = 0.0\ncoulomb = 0.0")  # 0.1 kg m2, 0.4 N m/V
DRY = platform("viscous = 0.0\ncoulomb = 0.05")
OPEN = wheel_rig().with_values({"motor.torque_constant": 1e-9, "motor.friction": 0.0})  # as if open: no damping
LOCKED = wheel_rig().with_values({"wheel.inertia": 1e6})
I, J, R, K = 0.1, 1.24e-4, 0.83, 0.0182
PUSH = np.where(TIME < 1.0, 0.0, 1.0)
AFTER = np.maximum(TIME - 1.0, 0.0)  # s since the push of 4 rad/s2
SETTLED = TIME > 8.0


class Known(NamedTuple):
    """A motion in closed form: `exact(readings)` of one output, to a tolerance, where `when` says."""

    effect: str
    given: dict[str, float]
    rig: Rig
    u: np.ndarray
    start: dict[str, float]
    output: str
    exact: Callable[[dict[str, np.ndarray]], np.ndarray]
    within: float
    when: np.ndarray = TIME >= 0.0


def _lag(T: float) -> np.ndarray:
    return 4.0 * (AFTER - T * (1.0 - np.exp(-AFTER / T)))


def _stop(t: np.ndarray) -> np.ndarray:
    return np.where(t < 1.0 + np.pi / 20.0, 1.0 + np.sin(20.0 * (t - 1.0)) / 20.0, 1.0 - (t - 1.0 - np.pi / 20.0))


def _well(x: np.ndarray) -> np.ndarray:
    return 2.0 * x**2 + 4.0 * x**4


def _angle(y: dict[str, np.ndarray]) -> np.ndarray:
    psi = y["yaw_rad"]
    return np.sqrt(np.maximum(9.0 - 2.0 / I * (0.05 * psi + 0.02 * (1.0 - np.cos(psi))), 0.0))


def _warm(c: float, tau: float, V: float) -> float:
    return 0.5 * (np.sqrt(1.0 + 4.0 * c * tau * (V / R) ** 2) - 1.0)  # q (1 + q) = c tau (V/R)^2


W0 = {"w": 2.0}
ON = np.ones_like(TIME)
PSI, RATE, SPIN, AMPERE = "yaw_rad", "yaw_rad_s", "wheel_rad_s", "current_A"
MOTIONS = [
    Known("axis.viscous", {"b": 0.05}, FREE, REST, W0, RATE, lambda y: 2.0 * np.exp(-0.5 * TIME), 1e-10),
    Known("axis.coulomb", {"M_c": 0.03}, FREE, REST, W0, RATE, lambda y: np.maximum(2.0 - 0.3 * TIME, 0.0), 1e-10),
    Known(
        "axis.stribeck", {"M_c": 0.03, "M_e": 0.0}, FREE, REST, W0, RATE, lambda y: np.maximum(2 - 0.3 * TIME, 0), 1e-10
    ),
    Known("axis.asymmetric_friction", {"d": 0.02}, DRY, REST, W0, RATE, lambda y: np.maximum(2 - 0.7 * TIME, 0), 1e-10),
    Known("axis.quadratic_drag", {"c": 0.05}, FREE, REST, W0, RATE, lambda y: 2.0 / (1.0 + TIME), 1e-5),
    Known("axis.angle_friction", {"s_1": 0.4}, DRY, REST, {"w": 3.0}, RATE, _angle, 1e-5, TIME < 5.0),
    Known("axis.load_friction", {"mu": 0.1}, FREE, PUSH, {}, RATE, lambda y: 3.6 * AFTER, 1e-9),
    Known(
        "axis.friction_drift",
        {"d": 2.0, "tau": 1.0},
        DRY,
        REST,
        W0,
        RATE,
        lambda y: 1.0 + np.exp(-TIME) - 0.5 * TIME,
        1e-5,
        TIME < 2.0,
    ),
    Known(
        "axis.friction_drift",
        {"d": 0.0, "B": 0.1, "tau": 1.0},
        FREE,
        REST,
        W0,
        RATE,
        lambda y: 2.0 * np.exp(np.exp(-TIME) - 1.0),
        1e-4,
    ),
    Known(
        "axis.friction_drift",
        {"d": 2.0, "tau": 1.5, "s": 1.0},
        DRY,
        REST,
        W0,
        RATE,
        lambda y: 2.0 - 0.5 * TIME - np.where(TIME < 1.5, TIME - TIME**2 / 3.0, 0.75),
        1e-4,
        TIME < 2.4,
    ),
    Known("axis.imbalance", {"s": 0.4}, FREE, REST, {"psi": 1e-3}, PSI, lambda y: 1e-3 * np.cos(2.0 * TIME), 1e-7),
    Known("axis.spring", {"k": 0.4, "T_0": 0.2}, FREE, REST, {}, PSI, lambda y: 0.5 - 0.5 * np.cos(2.0 * TIME), 1e-9),
    Known(
        "axis.spring",
        {"k": 0.4, "T_0": 0.2, "k_3": 1.6},
        FREE,
        REST,
        {},
        PSI,  # off by what its energy is off
        lambda y: y[PSI] + 0.5 * y[RATE] ** 2 + _well(y[PSI] - 0.5) - 0.75,
        1e-4,
    ),
    Known("axis.bias_torque", {"T": -0.08}, FREE, REST, {}, RATE, lambda y: -0.8 * TIME, 1e-10),
    Known(
        "axis.end_stop",
        {"high": 1.0, "k": 40.0, "d": 0.0},
        FREE,
        REST,
        {"w": 1.0},
        PSI,
        lambda y: np.where(TIME < 1.0, TIME, _stop(TIME)),
        1e-2,
        TIME < 3.0,
    ),
    Known(
        "axis.periodic_torque",
        {"s": 0.1, "omega": 4.0},
        FREE,
        REST,
        {},
        RATE,
        lambda y: 0.25 * (1.0 - np.cos(4.0 * TIME)),
        1e-4,
    ),
    Known(
        "axis.periodic_torque",
        {"s": 0.1, "omega": 4.0, "p": 0.4, "q": 0.2},
        FREE,
        REST,
        {},
        RATE,
        lambda y: 0.25 * (1.0 - np.cos(4.0 * TIME)) + 0.05 * (1.0 - np.cos(8.0 * TIME)) + 0.025 * np.sin(8.0 * TIME),
        1e-4,
    ),
    Known("wheel.drag", {"c": 1e-5}, OPEN, REST, {"Omega": 30.0}, SPIN, lambda y: 30.0 / (1.0 + 3e-4 / J * TIME), 1e-3),
    Known(
        "wheel.cogging",
        {"s": -1e-3, "n": 6.0},
        OPEN,
        REST,
        {"theta": 1e-3},
        "wheel_rad",
        lambda y: 1e-3 * np.cos(np.sqrt(6e-3 / J) * TIME),
        2e-6,
    ),
    Known(
        "wheel.cogging",
        {"s": -1e-3, "n": 6.0, "p": 0.5},
        OPEN,
        REST,
        {"theta": 1e-3},
        "wheel_rad",
        lambda y: 1e-3 * np.cos(np.sqrt(12e-3 / J) * TIME),
        2e-6,
    ),
    Known(
        "motor.heating",
        {"c": 0.5, "tau": 0.5},
        LOCKED,
        ON,
        {},
        AMPERE,
        lambda y: ON / R / (1.0 + _warm(0.5, 0.5, 1.0)),
        1e-6,
        SETTLED,
    ),
    Known(
        "motor.saturation",
        {"a": 0.5},
        LOCKED,
        ON,
        {},
        SPIN,
        lambda y: K / R / (1 + 0.5 / R**2) / 1e6 * (TIME - 8) + y[SPIN][800],
        1e-12,
        SETTLED,
    ),
    Known("motor.current_limit", {"i_m": 0.9}, LOCKED, ON, {}, AMPERE, lambda y: 0.9 * ON, 1e-12, SETTLED),
    Known("drive.lag", {"T": 0.2}, FREE, PUSH, {}, RATE, lambda y: _lag(0.2), 1e-9),
    Known(
        "drive.rate_limit",
        {"r": 2.0},
        FREE,
        PUSH,
        {},
        RATE,
        lambda y: np.where(AFTER < 0.5, 4.0 * AFTER**2, 4.0 * AFTER - 1.0),
        1e-9,
    ),
    Known("drive.delay", {"tau": 0.043}, FREE, PUSH, {}, RATE, lambda y: 4.0 * np.maximum(AFTER - 0.043, 0.0), 1e-9),
    Known("drive.saturation", {"u_m": 0.5}, FREE, PUSH, {}, RATE, lambda y: 2.0 * AFTER, 1e-9),
    Known(
        "drive.saturation", {"u_m": 2.0, "n": 2.0}, FREE, PUSH, {}, RATE, lambda y: 4.0 / np.sqrt(1.25) * AFTER, 1e-9
    ),
    Known("drive.bias", {"u_b": -0.2}, FREE, REST, {}, RATE, lambda y: -0.8 * TIME, 1e-9),
    Known("drive.deadzone", {"u_0": 0.3}, FREE, -PUSH, {}, RATE, lambda y: -2.8 * AFTER, 1e-9),
    Known("drive.deadzone", {"u_0": 0.0, "j": 0.3}, FREE, -PUSH, {}, RATE, lambda y: -4.0 * AFTER, 1e-9),
    Known("drive.asymmetric_gain", {"a": 0.1}, FREE, -PUSH, {}, RATE, lambda y: -3.6 * AFTER, 1e-9),
    Known("drive.curvature", {"c": 0.25}, FREE, -PUSH, {}, RATE, lambda y: -5.0 * AFTER, 1e-9),
    Known("drive.curvature", {"c": -0.25}, FREE, PUSH, {}, RATE, lambda y: 3.2 * AFTER, 1e-9),
    Known("drive.supply_sag", {"rho": 0.2}, LOCKED, ON, {}, AMPERE, lambda y: ON / (R + 0.2), 1e-8, SETTLED),
    Known("sensor.scale", {"s": 0.1}, FREE, REST, W0, PSI, lambda y: 2.2 * TIME, 1e-9),
    Known(
        "sensor.eccentricity",
        {"s": 0.1, "c": 0.05},
        FREE,
        REST,
        W0,
        PSI,
        lambda y: 2 * TIME + 0.1 * np.sin(2 * TIME) + 0.05 * np.cos(2 * TIME),
        1e-9,
    ),
    Known(
        "sensor.eccentricity",
        {"s_2": 0.1, "c_2": 0.05},
        FREE,
        REST,
        W0,
        PSI,
        lambda y: 2 * TIME + 0.1 * np.sin(4 * TIME) + 0.05 * np.cos(4 * TIME),
        1e-9,
    ),
    Known("sensor.delay", {"tau": 0.037}, FREE, REST, W0, PSI, lambda y: 2.0 * (TIME - 0.037), 1e-9),
    Known(
        "sensor.delay", {"tau": 0.037}, FREE, PUSH, {}, PSI, lambda y: 2.0 * np.maximum(AFTER - 0.037, 0.0) ** 2, 1e-9
    ),
    Known(
        "sensor.missed_counts",
        {"s": 0.3, "w_m": 1.5},
        FREE,
        REST,
        {"w": -2.0},
        PSI,
        lambda y: -(2.0 - 0.15) * TIME,
        1e-9,
    ),
    Known("sensor.clock", {"e": 0.1}, FREE, REST, W0, PSI, lambda y: 1.8 * TIME, 1e-9),
    Known("sensor.clock", {"e": -0.1}, FREE, ON, {}, RATE, lambda y: 4.4 * TIME, 1e-9),
    Known(
        "axis.flexible_coupling",
        {"s": 0.4, "k": 2.4, "c": 0.0},
        FREE,
        REST,
        {"axis.flexible_coupling:twist": 0.1},
        PSI,
        lambda y: 0.04 * (1.0 - np.cos(10.0 * TIME)),
        1e-9,
    ),
    Known(
        "axis.backlash",
        {"g": 0.2, "s": 0.25, "k": 1e3, "c": 1.0},
        FREE,
        ON,
        {},
        PSI,
        lambda y: 0.0 * TIME,
        1e-12,
        np.sqrt(0.2 * 0.025 / 0.4) - 0.01 > TIME,
    ),
    Known(
        "axis.backlash",
        {"g": 0.2, "s": 0.25, "k": 1e3, "c": 5.0},
        FREE,
        ON,
        {},
        PSI,
        lambda y: 2.0 * TIME**2 - 0.25 * 0.1,
        5e-3,
        TIME > 2.0,
    ),
]
ELSEWHERE = {"axis.presliding", "wheel.coulomb"}


@pytest.mark.parametrize("known", MOTIONS, ids=lambda known: known.effect)
def test_the_motion_is_that_of_the_closed_form(known: Known) -> None:
    y = go(known.rig, known.u, known.start, {known.effect: known.given})
    error = np.abs(y[known.output] - known.exact(y))[known.when]
    assert np.max(error) < known.within * max(1.0, float(np.max(np.abs(y[known.output]))))


def test_every_effect_has_a_known_motion() -> None:
    assert {known.effect for known in MOTIONS} | ELSEWHERE == {effect.name for effect in EFFECTS}


@pytest.mark.parametrize("tau", [0.04, 0.0373])
def test_a_late_reading_is_a_late_command_where_there_is_one_encoder(tau: float) -> None:
    u = np.where(TIME < 0.3, 0.0, 0.6 * np.sign(np.sin(2.3 * TIME)) + 0.2 * np.sin(9.0 * TIME))
    for rig, within in ((DRY, 1e-12 if tau == 0.04 else 5e-3), (FREE, 1e-5)):
        late = go(rig, u, {}, {"sensor.delay": {"tau": tau}})["yaw_rad"]
        command = go(rig, u, {}, {"drive.delay": {"tau": tau}})["yaw_rad"]
        # a late command within a step enters it by its mean, which stick and slip feel
        assert np.max(np.abs(late - command)) < within * np.max(np.abs(command))


def test_other_sensors_than_the_encoder_are_not_late() -> None:
    u = 2.0 * np.sin(3.0 * TIME)
    plain, late = (go(RIGS["reaction"], u, {}, {"sensor.delay": {"tau": tau}}) for tau in (0.0, 0.05))
    assert np.array_equal(late["wheel_rad_s"], plain["wheel_rad_s"]) and np.array_equal(
        late["current_A"], plain["current_A"]
    )
    assert np.max(np.abs(late["yaw_rad"][5:] - plain["yaw_rad"][:-5])) < 1e-12


@given(angle=st.floats(-10.0, 10.0), rate=st.floats(-5.0, 5.0))
def test_an_eccentric_encoder_reads_the_rate_of_the_angle_that_it_reads(angle: float, rate: float) -> None:
    read = partial(sensor.Eccentricity(*map(jnp.asarray, (0.1, -0.05, 0.04, 0.03))).read, motion=motion())
    psi, w = jnp.asarray(angle), jnp.asarray(rate)
    slope = jax.grad(lambda psi: read(psi, w)[0])(psi)
    assert float(read(psi, w)[1]) == pytest.approx(rate * float(slope), abs=1e-12)


def test_an_end_stop_takes_energy_and_never_pulls() -> None:
    stop = {"axis.end_stop": {"high": 1.0, "low": -1.0, "k": 40.0, "d": 1.0}}
    y = go(FREE, REST, {"w": 1.0}, stop)
    assert (
        -1.0 < y["yaw_rad_s"][TIME > 1.5][0] < -0.3 and np.min(y["yaw_rad"]) > -1.05
    )  # back, and off the other stop too
    away = (np.abs(y["yaw_rad"]) < 0.98)[1:] & (np.abs(y["yaw_rad"]) < 0.98)[:-1]
    assert np.max(np.abs(np.diff(y["yaw_rad_s"])[away])) < 1e-12


def test_bent_friction_follows_its_hysteresis_whatever_the_step() -> None:
    bent = axis.Presliding(M_c=jnp.asarray(0.05), x_s=jnp.asarray(0.02), d=jnp.zeros(()))
    z = jnp.zeros(())
    for travel, exact in ((0.03, 1.0 - np.exp(-1.5)), (-0.05, -1.0 + (2.0 - np.exp(-1.5)) * np.exp(-2.5))):
        whole, parts = bent.after(z, jnp.asarray(travel)), z
        for _ in range(7):
            parts = bent.after(parts, jnp.asarray(travel / 7.0))
        z = whole
        assert float(whole) == pytest.approx(exact, rel=1e-12) and float(parts) == pytest.approx(exact, rel=1e-12)


def test_bent_friction_is_a_spring_at_first_and_dry_friction_in_the_end() -> None:
    given = {"axis.presliding": {"M_c": 0.0, "x_s": 0.05}}
    y = go(DRY, REST, {"w": 1e-4}, given)["yaw_rad"]
    assert (
        np.max(np.abs(y - 1e-5 * np.sin(np.sqrt(10.0) * TIME) * np.sqrt(10.0))[TIME < 2.0]) < 1e-6
    )  # k = M_c/x_s = 1 N m/rad
    far = go(DRY, REST, {"w": 3.0}, given)["yaw_rad_s"]
    slides = (TIME > 1.0) & (TIME < 5.0)
    assert np.max(np.abs(np.diff(far)[slides[1:]] + 0.005)) < 1e-6


def test_a_constant_torque_below_breakaway_turns_nothing() -> None:
    y = run(platform(), record(TIME, REST), {}, effects={"axis.bias_torque": {"T": -0.049}})
    assert np.ptp(y["yaw_rad"]) == 0.0


def test_commands_within_the_dead_zone_do_nothing_and_others_lose_it() -> None:
    u = np.where(TIME < 5.0, -0.29, 1.3)
    dead = run(platform(), record(TIME, u), {}, effects={"drive.deadzone": {"u_0": 0.3}})
    plain = run(platform(), record(TIME, np.where(TIME < 5.0, 0.0, 1.0)), {})
    assert np.ptp(dead["yaw_rad"][TIME < 5.0]) == 0.0
    assert np.max(np.abs(dead["yaw_rad"] - plain["yaw_rad"])) < 1e-10


def test_an_offset_is_added_to_the_command() -> None:
    u = np.sin(TIME)
    offset = run(platform(), record(TIME, u), {}, effects={"drive.bias": {"u_b": 0.2}})
    assert np.max(np.abs(offset["yaw_rad"] - run(platform(), record(TIME, u + 0.2), {})["yaw_rad"])) < 1e-12


def test_the_dead_zone_comes_before_the_offset() -> None:
    # otherwise the offset could be hidden within the zone
    both = {"drive.deadzone": {"u_0": 0.3}, "drive.bias": {"u_b": 0.2}}
    y = run(platform(), record(TIME, REST), {}, effects=both)
    assert y["yaw_rad"][-1] == pytest.approx(run(platform(), record(TIME, REST + 0.2), {})["yaw_rad"][-1], rel=1e-12)


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
