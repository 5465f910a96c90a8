"""Friction of the axis beside its closed forms: which way it acts, levels, hysteresis."""

import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.effects import axis_friction
from rwjax.effects.effect import Effect
from rwjax.effects.library import EFFECTS
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import AxisDry, AxisElastic
from rwjax.plant.dry_friction import friction_level
from rwjax.types import Scalar
from tests.effects.rigs import DRY, REST, TIME, go, motion
from tests.systems import platform, record, run


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


def bent(s: float, r: float) -> axis_friction.Presliding:
    """Friction of 0.05 N m that builds up over 0.02 rad in the mean."""
    return axis_friction.Presliding(*(jnp.asarray(value) for value in (0.05, 0.02, s, 0.0, r)))


def turned(effect: AxisElastic, *travels: float) -> tuple[Scalar, ...]:
    """What its elements have built up after travels [rad] from where nothing is bent."""
    shares = tuple(jnp.zeros(()) for _ in effect.states)
    for travel in travels:
        shares = effect.after(shares, jnp.asarray(travel))
    return shares


def share_after(effect: AxisElastic, *travels: float) -> float:
    return float(effect.built_up(turned(effect, *travels)))


@pytest.mark.parametrize(
    ("s", "there", "back"),
    [
        (0.0, 1.0 - np.exp(-1.5), -1.0 + (2.0 - np.exp(-1.5)) * np.exp(-2.5)),
        (0.5, 1.0 - 0.25**2, -1.0 + (np.sqrt(2.0 - 0.25**2) - 1.25) ** 2),
        (1.0, 1.0, -1.0),  # elastic up to x_s, then sliding
    ],
)
def test_bent_friction_follows_its_hysteresis_whatever_the_step(s: float, there: float, back: float) -> None:
    alike, forward, backward = bent(s, 0.0), [0.03 / 7.0] * 7, [-0.05 / 7.0] * 7
    assert share_after(alike, 0.03) == pytest.approx(there, rel=1e-8)
    assert share_after(alike, 0.03, -0.05) == pytest.approx(back, rel=1e-8)
    assert share_after(alike, *forward) == pytest.approx(there, rel=1e-8)
    assert share_after(alike, *forward, *backward) == pytest.approx(back, rel=1e-8)


WAYS = 0.02 * (1.0 + 0.8 * np.array([-0.75, -0.25, 0.25, 0.75]))  # rad, of the elements of `bent(s, 0.8)`


def virgin(way: float) -> float:
    """Share of the level after a first way [rad] against `bent(1.0, 0.8)`: the elements slide one after the other."""
    return float(np.mean(np.minimum(way / WAYS, 1.0)))


@pytest.mark.parametrize("way", [0.003, 0.01, 0.018, 0.026, 0.04])
def test_slip_elements_of_several_lengths_bend_piece_by_piece_and_unload_at_twice_the_scale(way: float) -> None:
    slip = bent(1.0, 0.8)
    assert share_after(slip, way) == pytest.approx(virgin(way), rel=1e-8)
    for back in (0.3 * way, way, 1.7 * way):  # Masing's rule, up to the loop's other end at -way
        assert share_after(slip, way, -back) == pytest.approx(
            virgin(way) - 2.0 * virgin(0.5 * back), rel=1e-8, abs=1e-9
        )


def test_slip_elements_of_several_lengths_remember_where_they_turned_and_one_that_bends_exponentially_does_not() -> (
    None
):
    loop = (0.022, -0.022)
    for slip, closes in ((bent(1.0, 0.8), True), (bent(0.0, 0.0), False)):
        before, after = share_after(slip, 0.024, -0.03), share_after(slip, 0.024, -0.03, *loop)
        assert (after == pytest.approx(before, rel=1e-8)) == closes
        outer, through = share_after(slip, 0.024, -0.03, 0.028), share_after(slip, 0.024, -0.03, *loop, 0.028)
        assert (through == pytest.approx(outer, rel=1e-8)) == closes


@pytest.mark.parametrize("s", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("z", [-0.8, 0.0, 0.6])
@pytest.mark.parametrize(("w", "r"), [(-0.7, 0.0), (2.0, 0.0), (-0.7, 0.8)])
def test_the_rate_of_bent_friction_is_the_slope_of_its_way(w: float, r: float, z: float, s: float) -> None:
    some, step = bent(s, r), 1e-6
    here = tuple(jnp.asarray(z) for _ in some.states)
    after = [np.array(some.after(here, jnp.asarray(k * w * step))) for k in (1.0, 2.0)]
    slopes = (4.0 * after[0] - after[1] - 3.0 * z) / (2.0 * step)  # one-sided, since `after` turns where the way does
    assert np.array(some.rates(here, jnp.asarray(w))) == pytest.approx(slopes, rel=1e-6)


def test_bent_friction_is_a_spring_at_first_and_dry_friction_in_the_end() -> None:
    given = {"axis.presliding": {"M_c": 0.0, "x_s": 0.05}}
    y = go(DRY, REST, {"w": 1e-4}, given)["yaw_rad"]
    assert (
        np.max(np.abs(y - 1e-5 * np.sin(np.sqrt(10.0) * TIME) * np.sqrt(10.0))[TIME < 2.0]) < 1e-6
    )  # k = M_c/x_s = 1 N m/rad
    far = go(DRY, REST, {"w": 3.0}, given)["yaw_rad_s"]
    slides = (TIME > 1.0) & (TIME < 5.0)
    assert np.max(np.abs(np.diff(far)[slides[1:]] + 0.005)) < 1e-6


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
