"""Numbers of a fleet pooled, against one least-squares problem of all rigs, and against fleets whose numbers are known."""

import numpy as np
import pytest

from rwjax.fleet.changes import compared
from rwjax.fleet.pooled import alike, pooled
from rwjax.fleet.sessions import MISFIT, Estimates
from tests.fleet.test_changes import CORRELATED, ERROR, NAMES, SPREAD, TRUE, covariance


def estimates(value: np.ndarray, left: np.ndarray, names: tuple[str, ...] = NAMES) -> Estimates:
    """Estimates of rigs whose logs leave the same covariance."""
    rigs, count = value.shape
    whole, none = np.broadcast_to(left, (rigs, count, count)), np.zeros((rigs, count))
    named = tuple(f"r{k}" for k in range(rigs))
    return Estimates(names, named, ("",) * rigs, value, whole, np.ones((rigs, count)), none)


def drawn(rigs: int, rng: np.random.Generator, spread: np.ndarray) -> tuple[np.ndarray, Estimates]:
    """True numbers of rigs, and their estimates."""
    true = TRUE + spread * rng.normal(size=(rigs, 2))
    return true, estimates(true + rng.multivariate_normal([0.0, 0.0], covariance(), rigs), covariance())


def least_squares(of: Estimates, spread: np.ndarray, share: int | None) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of all rigs and then of the fleet with their variances, by one linear problem: readings of each rig, and its siblings as a prior.

    A shared number is one unknown for all rigs.
    """
    rigs, count = of.value.shape
    size = rigs * count + count
    H, g = np.zeros((size, size)), np.zeros(size)
    for r in range(rigs):
        at = [rigs * count + k if k == share else r * count + k for k in range(count)]
        told = np.isfinite(of.value[r])
        W = np.linalg.inv(of.covariance[r][np.ix_(told, told)])
        own = np.array(at)[told]
        H[np.ix_(own, own)] += W
        g[own] += W @ of.value[r][told]
        for k in (k for k in range(count) if k != share):
            one, mean = at[k], rigs * count + k
            H[one, one] += spread[k] ** -2
            H[mean, mean] += spread[k] ** -2
            H[one, mean] -= spread[k] ** -2
            H[mean, one] -= spread[k] ** -2
    used = np.diag(H) > 0.0
    scale = 1.0 / np.sqrt(np.diag(H)[used])
    inverse = np.linalg.inv(H[np.ix_(used, used)] * np.outer(scale, scale)) * np.outer(scale, scale)
    value, variance = np.full(size, np.nan), np.full(size, np.nan)
    value[used], variance[used] = inverse @ g[used], np.diag(inverse)
    return value, variance


@pytest.mark.parametrize("share", [None, 0])
def test_pooled_numbers_are_those_of_one_problem_of_all_rigs(share: int | None) -> None:
    _, of = drawn(30, np.random.default_rng(0), SPREAD * (np.arange(2) != share))
    of.value[3, 1] = np.nan  # what one rig does not tell comes from its siblings
    shared = () if share is None else (NAMES[share],)
    found = pooled(of, shared)
    value, variance = least_squares(of, compared(of, shared).spread, share)
    for k, name in enumerate(NAMES):
        own = found.own.filter(number=name)
        if k == share:
            assert own["value"].to_numpy() == pytest.approx(np.full(30, value[60 + k]), rel=1e-9)
        else:
            assert own["value"].to_numpy() == pytest.approx(value[k:60:2], rel=1e-9)
            assert own["standard_error"].to_numpy() == pytest.approx(np.sqrt(variance[k:60:2]), rel=1e-6)
        (one,) = found.fleet.filter(number=name).to_dicts()
        assert (one["mean"], one["standard_error"]) == pytest.approx(
            (value[60 + k], np.sqrt(variance[60 + k])), rel=1e-6
        )
        assert one["shared"] == (k == share) and one["rigs"] == (29 if k == 1 else 30)
    assert found.own.filter(rig="r3", number=NAMES[1])["alone"].to_list() == [None]


def test_numbers_beside_siblings_are_nearer_to_the_truth_and_their_intervals_hold() -> None:
    rng, hits, off, alone = np.random.default_rng(1), [], [], []
    for _ in range(40):
        true, of = drawn(50, rng, np.array([0.0, SPREAD[1]]))
        own = pooled(of, NAMES[:1]).own
        for k, name in enumerate(NAMES):
            one = own.filter(number=name)
            miss = one["value"].to_numpy() - true[:, k]
            hits.append(np.mean(np.abs(miss) < 1.96 * one["standard_error"].to_numpy()))
            off.append(np.mean(miss**2) / ERROR[k] ** 2)
            alone.append(np.mean((one["alone"].to_numpy() - true[:, k]) ** 2) / ERROR[k] ** 2)
    assert 0.92 < np.mean(hits) < 0.97
    assert np.mean(alone) == pytest.approx(1.0, abs=0.1)
    known = 1.0 - CORRELATED**2  # a number that is known takes the rest of the other's variance along
    assert np.mean(off[1::2]) < 1.1 * known
    assert np.mean(off[::2]) < 0.1


def test_a_rig_that_differs_does_not_count_and_keeps_what_its_logs_tell() -> None:
    _, of = drawn(20, np.random.default_rng(2), SPREAD)
    of.value[5] += 100.0 * SPREAD
    found, without = (
        pooled(of, apart={"r5"}),
        pooled(of._replace(value=np.where(np.arange(20)[:, None] == 5, np.nan, of.value))),
    )
    own = found.own.filter(rig="r5")
    assert own["value"].to_list() == own["alone"].to_list() == of.value[5].tolist()
    assert own["standard_error"].to_numpy() == pytest.approx(ERROR)
    assert found.fleet["mean"].to_numpy() == pytest.approx(without.fleet["mean"].to_numpy(), rel=1e-2)


def test_where_nothing_can_be_pooled_there_is_nothing() -> None:
    _, of = drawn(20, np.random.default_rng(3), SPREAD)
    assert pooled(of, apart={*of.rigs}).fleet.is_empty()
    alone = estimates(np.zeros((20, 1)), np.zeros((1, 1)), (MISFIT,))
    assert pooled(alone).own.is_empty()


def test_a_shared_number_has_no_spread_and_a_rig_whose_own_differs_is_seen() -> None:
    _, of = drawn(40, np.random.default_rng(5), np.array([0.0, SPREAD[1]]))
    of.value[4, 0] += 8.0 * ERROR[0]
    found = compared(of, NAMES[:1])
    assert found.spread[0] == 0.0 and found.spread[1] == pytest.approx(SPREAD[1], rel=0.5)
    assert np.argmax(np.abs(found.z[:, 0])) == 4
    (change,), (deviation,) = found.change(4, [0])
    assert abs(change - 8.0 * ERROR[0]) < 3.0 * deviation and deviation < 1.1 * ERROR[0]


def test_a_number_in_which_sound_rigs_differ_is_not_taken_as_shared() -> None:
    _, of = drawn(12, np.random.default_rng(6), np.array([0.0, 100.0 * ERROR[1]]))
    of.value[3, 0] += 30.0 * ERROR[0]  # one rig that is worn says nothing against the others
    same, (note, other) = alike(of, (*NAMES, "axis.friction.viscous"))
    assert same == NAMES[:1] and "differ by" in note and NAMES[1] in note and "too few rigs" in other
    assert alike(of, ()) == ((), [])


def test_a_number_that_none_of_the_rigs_among_them_tells_is_left_out() -> None:
    _, of = drawn(20, np.random.default_rng(7), SPREAD)
    of.value[:10, 0] = np.nan
    found = pooled(of, apart={f"r{k}" for k in range(10, 20)})
    assert found.fleet["number"].to_list() == [NAMES[1]]
