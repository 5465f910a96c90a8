"""What an effect says of others and of itself: it names only what there is."""

import math

import jax.numpy as jnp
import pytest

from rwjax.effects.effect import COORDINATES, Effect, FittedRig
from rwjax.effects.library import BY_NAME, EFFECTS
from rwjax.effects.motor import Heating
from rwjax.effects.parameter import parameters
from rwjax.effects.shown import RUNS
from rwjax.kinds import KINDS, NUMBERS
from tests.effects.rigs import motion

EVERY = pytest.mark.parametrize("effect", BY_NAME.values(), ids=BY_NAME)


@EVERY
def test_it_names_only_what_there_is(effect: type[Effect]) -> None:
    said = {
        *effect.limits,
        *([effect.includes] if effect.includes else []),
        *([effect.linear_as] if effect.linear_as else []),
    }
    on_a_half = effect.linear_as == "axis.flexible_coupling"  # which no half has, nor what it stands for
    assert {*said} <= {*BY_NAME} and (not on_a_half or effect in EFFECTS)
    assert effect.name not in said
    assert effect not in EFFECTS or {*effect.modelled_by, *effect.like_larger, *effect.covers} <= {*NUMBERS}
    assert {*effect.shown_by} <= {*RUNS} and effect.coordinate in COORDINATES
    own = {*parameters(effect)}
    assert {*effect.linear_numbers, *([effect.threshold] if effect.threshold else [])} <= own


@EVERY
def test_it_shares_a_number_with_what_it_includes(effect: type[Effect]) -> None:
    assert not effect.includes or {*parameters(effect)} & {*parameters(BY_NAME[effect.includes])}


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
@pytest.mark.parametrize("kind", KINDS)
def test_what_it_is_the_same_as_is_an_effect(effect: type[Effect], kind: str) -> None:
    numbers = {f"{effect.name}.{name}": p.null for name, p in parameters(effect).items()}
    for names in (frozenset({effect.name}), frozenset()):
        same = effect.same_as(FittedRig(kind, names, numbers))
        assert {*same} <= {*BY_NAME} and effect.name not in same


@EVERY
def test_its_row_fits_into_a_table(effect: type[Effect]) -> None:
    assert effect.equation and effect.label
    assert not {"|", "\n"} & {*effect.equation, *effect.meaning, *effect.label}


def test_an_effect_knows_its_own_states() -> None:
    heating = Heating(c=jnp.asarray(0.5), tau=jnp.asarray(4.0))
    warm = motion()._replace(i=jnp.asarray(2.0), own={"motor.heating:q": jnp.asarray(0.2), "other:q": jnp.asarray(9.0)})
    assert float(heating.mine(warm)[0]) == 0.2
    (rate,) = heating.drift(warm)
    assert float(rate) == pytest.approx(0.5 * 4.0 * 1.2 - 0.2 / 4.0, rel=1e-15)


@pytest.mark.parametrize(
    ("name", "given", "volts", "travel"),
    [
        ("drive.saturation", {"u_m": 7.0, "n": 5000.0}, 7.0, math.inf),
        ("axis.end_stop", {"high": 0.7, "low": -0.5, "k": 1.0, "d": 1.0}, math.inf, 0.5),
        ("axis.end_stop", {"high": 0.7, "low": 0.1, "k": 1.0, "d": 1.0}, math.inf, 0.0),  # begins beyond a stop
        ("axis.viscous", {"b": 0.1}, math.inf, math.inf),
    ],
)
def test_limits_of_command_and_travel(name: str, given: dict[str, float], volts: float, travel: float) -> None:
    assert BY_NAME[name].largest_command(given) == volts
    assert BY_NAME[name].travel(given) == travel
    assert BY_NAME[name].ends_travel == math.isfinite(travel)
