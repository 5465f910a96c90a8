"""Every effect: its null, its bounds and its derivatives, from the class alone."""

from collections.abc import Callable
from functools import cache

import jax
import numpy as np
import pytest

from rwjax.effects.effect import Effect
from rwjax.effects.library import EFFECTS
from rwjax.effects.parameter import parameters
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import scales
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.simulation.free_run import free_run
from tests.effects.rigs import ALONE, HERE, KIND, RIGS, TIME, among, go
from tests.systems import record, run


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


@pytest.mark.parametrize(
    "effect",
    [pytest.param(e, marks=[] if e is ALONE[0] else [pytest.mark.slow]) for e in HERE],
    ids=lambda effect: effect.name,
)
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
