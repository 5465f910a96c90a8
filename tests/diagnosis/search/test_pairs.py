"""Pairs of names: what two probes explain together, and two causes of which neither alone brings the rig closer."""

from collections import Counter
from dataclasses import replace
from itertools import combinations, count

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from rwjax import parse_rig
from rwjax.diagnosis.budget import Budget, Stopped
from rwjax.diagnosis.headway import Headway
from rwjax.diagnosis.hypothesis import Hypothesis, chosen_names, free_names
from rwjax.diagnosis.score_screen import Candidate, Probe
from rwjax.diagnosis.search.forward_backward import Search
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.diagnosis.search.pairs import foremost, joint_gains, promising_pairs
from rwjax.diagnosis.settings import PairSettings
from rwjax.diagnosis.starting_points import candidate_of
from rwjax.fitting.batched_runs import Simulating, together
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.secant import search_point, with_derivatives, with_residual
from tests.diagnosis.simulated import COMMAND, TIME, fits_of, true_log
from tests.systems import platform, record, run

NOTHING = Hypothesis()
LIMITS = PairSettings()
PROBLEM = fits_of(platform(), true_log(platform())).problem


def probe(name: str, change: np.ndarray, *, one_sided: bool) -> Probe:
    """A probe of one amplitude that begins at 0."""
    zero, yes, bounds = np.zeros(1), np.array([True]), np.array([[0.0 if one_sided else -1.0, 1.0]])
    candidate = Candidate(PROBLEM, zero, zero, [np.ones(1)], [], yes, yes, bounds)
    return Probe(Hypothesis((name,)), candidate, np.ones(1), change, change)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), sided=st.lists(st.booleans(), min_size=4, max_size=4))
def test_what_two_probes_leave_is_the_bounded_least_squares_of_both(seed: int, sided: list[bool]) -> None:
    rng = np.random.default_rng(seed)
    left = rng.standard_normal(30)
    changes = rng.standard_normal((4, 30)) * rng.uniform(0.01, 3.0, (4, 1))
    probes = [probe(f"{k}", c, one_sided=s) for k, (c, s) in enumerate(zip(changes, sided, strict=True))]
    found = {pair.names: pair for pair in joint_gains(left, probes, LIMITS)}
    assert len(found) == 6
    for i, j in combinations(range(4), 2):
        low = [0.0 if sided[k] else -LIMITS.largest for k in (i, j)]
        best = lsq_linear(changes[[i, j]].T, -left, (low, LIMITS.largest), tol=1e-12)
        pair = found[Hypothesis((f"{i}", f"{j}"))]
        assert pair.predicted == pytest.approx(best.cost, rel=1e-6)
        assert pair.shares == pytest.approx(best.x, abs=1e-4)


def test_probes_of_one_name_and_probes_that_change_the_same_are_no_pair() -> None:
    rng = np.random.default_rng(0)
    left, a, b = rng.standard_normal((3, 50))
    same = [probe("a", a, one_sided=False), probe("a", b, one_sided=False)]
    alike = [probe("a", a, one_sided=False), probe("b", 3.0 * a + 1e-3 * b, one_sided=False)]
    for probes in (same, alike, same[:1]):
        assert not [*joint_gains(left, probes, LIMITS)]


def test_a_name_that_explains_much_beside_any_other_leaves_room_for_two_that_explain_all() -> None:
    rng = np.random.default_rng(1)
    changes = rng.standard_normal((12, 400))
    decoy = probe("decoy", -changes[0] - changes[1] + 0.3 * changes[2], one_sided=False)
    probes = [decoy, *(probe(f"{k}", c, one_sided=False) for k, c in enumerate(changes))]
    left = -(changes[0] + changes[1]) + 0.5 * rng.standard_normal(400)
    pairs = sorted(joint_gains(left, probes, LIMITS), key=lambda p: "decoy" not in p.names.names)
    assert pairs[LIMITS.fitted].names.names[0] == "decoy"
    chosen = foremost(pairs, LIMITS)
    assert Hypothesis(("0", "1")) in chosen and len(chosen) == LIMITS.fitted
    assert max(Counter(name for e in chosen for name in e.names).values()) <= LIMITS.of_a_name


PENDULUM = """
kind = "platform"
[drive]
gain = 0.4
[axis]
inertia = {inertia}
[axis.friction]
viscous = 0.05
[axis.gravity]
torque = {torque}
"""
PAYLOAD = Hypothesis(("parameter.axis.inertia", "parameter.axis.gravity.torque"))
NAMES = (
    *("axis.coulomb", "axis.spring", "axis.bias_torque", "drive.deadzone"),
    *(
        "parameter.axis.inertia",
        "parameter.axis.gravity.torque",
        "parameter.drive.gain",
        "parameter.axis.friction.viscous",
    ),
)


def with_another_payload(times: float, also: str = ""):
    """Fits of a pendulum whose file holds another payload than the one that swung."""
    true, believed = (parse_rig(PENDULUM.format(inertia=0.02 * m, torque=0.6 * m) + also) for m in (times, 1.0))
    y = run(true, record(TIME, COMMAND), {})["yaw_rad"]
    log = record(TIME, COMMAND, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, 1e-3, len(y))})
    fits = fits_of(believed, log)
    fits(NOTHING)
    fits.start_from_first_readings()
    return fits


@pytest.mark.slow
def test_another_payload_is_among_the_promising_pairs_and_begins_near_it() -> None:
    fits = with_another_payload(1.1)
    pairs = promising_pairs(fits, NAMES)
    assert PAYLOAD in [*pairs][:3] and len(pairs) <= LIMITS.fitted
    names = pairs[PAYLOAD][0].problem.structure.names
    at = dict(zip(names, pairs[PAYLOAD][0].theta, strict=True))
    assert at["axis.gravity.torque"] == pytest.approx(0.66, rel=0.03)
    assert at["axis.inertia"] == pytest.approx(0.022, rel=0.1)


def begun_at(factor: float, first: Fit) -> Simulating[Fit]:
    """A fit whose free numbers are so many times as large, and where no step was taken."""
    theta = first.theta.copy()
    theta[first.coordinates.index] *= factor
    here = yield from with_residual(search_point(first.problem, first.coordinates, theta, first.start))
    return (yield from with_derivatives(here))


def test_a_pair_is_also_looked_for_around_the_first_fit_of_the_rig() -> None:
    fits = with_another_payload(1.1, also='[fit]\nfree = ["axis.friction.viscous"]\n')
    (later,) = together([begun_at(3.0, fits(NOTHING))])  # friction has taken up what it can
    fits.put(NOTHING, later, ended=True)
    fits.by_start_rule = False  # as where a search goes on
    assert PAYLOAD not in promising_pairs(fits, NAMES)
    FurtherSearch(fits, NAMES).fit_pairs_around_the_first_fit()
    assert not any(fits.known(e).problem.initial_state_from_start.any() for e in fits if len(e.names) == 2)
    found = fits(PAYLOAD).numbers()
    assert found["axis.inertia"] == pytest.approx(0.022, rel=0.02)
    assert found["axis.gravity.torque"] == pytest.approx(0.66, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("times", [1.5, 2.2])
def test_another_payload_is_found_and_what_scales_the_same_beside_it(times: float) -> None:
    fits = with_another_payload(times)
    first = Search(fits, NAMES).run().best
    choice = FurtherSearch(fits, NAMES).go_on(first)
    # a payload of half as much again is a drive and a friction of two thirds: the motion is the same
    scaled = Hypothesis(("parameter.drive.gain", "parameter.axis.friction.viscous"))
    assert len(first.names) == 1
    assert PAYLOAD in (found := {choice.best, *choice.alternatives}) and found <= {PAYLOAD, scaled}
    assert len(found) == 2 or times > 2.0  # so far from the file, the other pair is not reached
    found = fits(PAYLOAD).numbers()
    assert found["axis.inertia"] == pytest.approx(0.02 * times, rel=0.05)
    assert found["axis.gravity.torque"] == pytest.approx(0.6 * times, rel=0.02)


@pytest.mark.slow
def test_no_pair_is_looked_for_where_one_name_explains_the_logs() -> None:
    rig = platform("viscous = 0.02")
    log = record(TIME, COMMAND, run(rig, record(TIME, COMMAND), {}, effects={"axis.bias_torque": {"T": 0.03}}))
    fits = fits_of(
        rig,
        replace(
            log, outputs={"yaw_rad": log.outputs["yaw_rad"] + np.random.default_rng(0).normal(0.0, 2e-4, len(TIME))}
        ),
    )
    fits(NOTHING)
    fits.start_from_first_readings()
    names = ("axis.bias_torque", "drive.deadzone", "axis.spring")
    best = Search(fits, names).run().best
    assert best.names == ("axis.bias_torque",) and FurtherSearch(fits, names).go_on(best).best == best
    assert all(len(e.names) < 2 for e in fits)


def test_a_pair_sets_no_number_that_it_does_not_fit() -> None:
    rig = platform("viscous = 0.02")
    fits = fits_of(rig, true_log(rig, noise=1e-3, **{"axis.coulomb": {"M_c": 0.05}}))
    fits(NOTHING)
    fits.start_from_first_readings()
    pairs = promising_pairs(fits, ("axis.stribeck", "axis.asymmetric_friction", "axis.presliding"))
    assert (
        Hypothesis(("axis.stribeck", "axis.asymmetric_friction")) in pairs
    )  # both hold dry friction, and one of them brings it
    for pair, places in pairs.items():
        own = {*free_names(rig, pair, fits.outputs), *chosen_names(pair)}
        off = candidate_of(fits, pair, NOTHING).off
        for place in places:
            moved = {place.problem.structure.names[k] for k in np.flatnonzero(place.theta != off)}
            assert moved <= own


@pytest.mark.parametrize(
    "checks", [pytest.param(3, marks=pytest.mark.slow), 30, 60, pytest.param(90, marks=pytest.mark.slow)]
)
def test_a_search_that_is_ended_among_the_pairs_keeps_their_fits_at_their_end(checks: int) -> None:
    fits = with_another_payload(1.5)
    known = Search(fits, NAMES).pairs()
    ended = [e for e in known if fits.ended(e)]
    cost = {e: fits.known(e).cost for e in known}
    ticks = count()
    fits.headway = Headway(Budget(float(checks), lambda: next(ticks)))
    with pytest.raises(Stopped), fits.headway.budget.searching():
        Search(fits, NAMES).pairs()
    assert ended and all(fits.ended(e) for e in ended)
    assert all(fits.known(e).cost <= cost[e] for e in known)
