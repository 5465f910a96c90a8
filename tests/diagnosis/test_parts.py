"""The verdict's rules, the missing torque and the next experiment, each by itself."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.diagnosis.diagnosis import Rung, diagnose
from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.hypothesis import Hypothesis, candidates
from rwjax.diagnosis.localise.where import Where, missing_torque
from rwjax.diagnosis.model_fits import BEHIND, ModelFits, promise_of
from rwjax.diagnosis.remarks import moves, ran_away
from rwjax.diagnosis.score_screen import Screen
from rwjax.diagnosis.search.equivalents import equivalents
from rwjax.diagnosis.search.forward_backward import Choice, Search
from rwjax.diagnosis.verdict import judge
from rwjax.diagnosis.words import moved, numbers_of, verdict_sentence, where_words
from rwjax.fitting.batched_runs import together
from rwjax.fitting.fit import fit
from rwjax.fitting.secant import residuals, with_derivatives, with_residual
from tests.systems import platform, record, run, wheel

TIME = np.arange(2001) * 0.01
COMMAND = np.where(TIME > 0.6, 0.9 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME), 0.0)


def chosen(*names: str, alternatives: tuple[Hypothesis, ...] = ()) -> Choice:
    return Choice(Hypothesis(names), alternatives, (), {}, ())


@pytest.mark.parametrize(
    ("choice", "gap", "verdict"),
    [
        (chosen(), Gap(1.0, 1.0, 1.0, None, None), "none"),
        (chosen(), Gap(1.2, 1.2, 1.0, 0.0, (0.0, 0.0)), "none"),
        (chosen(), Gap(5.0, 5.0, 1.0, 0.0, (0.0, 0.0)), "unknown"),
        (chosen("axis.coulomb"), Gap(5.0, 1.1, 1.0, 0.97, (0.95, 1.0)), "effect"),
        (chosen("axis.coulomb"), Gap(5.0, 3.0, 1.0, 0.5, (0.4, 0.6)), "unknown"),
        (chosen("axis.coulomb"), Gap(21.0, 4.0, 1.0, 0.85, (0.8, 0.9)), "effect"),
        (chosen("axis.coulomb", "drive.lag"), Gap(21.0, 4.0, 1.0, 0.85, (0.8, 0.9)), "unknown"),
        (chosen("axis.coulomb", "drive.lag"), Gap(21.0, 1.2, 1.0, 0.93, (0.9, 0.95)), "effect"),
        # hardly anything is closed: no name, however wide the interval
        (chosen("axis.coulomb"), Gap(5.0, 4.6, 1.0, 0.1, (-1.0, 0.85)), "unknown"),
        (
            chosen("axis.coulomb", alternatives=(Hypothesis(("wheel.coulomb",)),)),
            Gap(5.0, 1.1, 1.0, 0.97, (0.95, 1.0)),
            "ambiguous",
        ),
    ],
)
def test_the_four_outcomes(choice: Choice, gap: Gap, verdict: str) -> None:
    assert judge(choice, gap) == verdict


def true_log(rig, noise: float = 2e-4, **effects):
    y = run(rig, record(TIME, COMMAND), {}, effects=effects or None)["yaw_rad"]
    return record(TIME, COMMAND, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, noise, len(y))})


def test_a_true_rig_misses_no_torque_whatever_it_models() -> None:
    rig = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02\ncoulomb = 0.05\n'
        'static = 0.12\nstribeck_velocity = 0.3\n[effects."axis.bias_torque"]\nT = 0.03\n[fit]\nfree = ["axis.inertia"]'
    )
    log = true_log(rig)
    found = missing_torque(fit(rig, [log]).fit, 0, log)
    assert found is not None
    bent = np.abs(found.torque) > 4.0 * found.deviation
    assert np.mean(bent) < 0.12  # the smoother cannot follow the instants of stick and slip
    rate = np.abs(found.coordinates["yaw_rate"])
    for low, high in ((0.1, 0.4), (0.4, 1.0), (1.0, 2.0)):
        assert abs(np.median(found.torque[(rate > low) & (rate < high)])) < 0.01  # bias and Stribeck are ten times that


def test_a_missing_bias_is_read_off_at_its_size() -> None:
    rig = platform()
    log = true_log(rig, **{"axis.bias_torque": {"T": 0.03}})
    structure_fit = fit(rig, [true_log(rig)]).fit
    found = missing_torque(structure_fit, 0, log)
    assert found is not None
    sliding = np.abs(found.coordinates["yaw_rate"]) > 0.3
    assert np.median(found.torque[sliding]) == pytest.approx(0.03, rel=0.15)


def test_declared_equivalents_of_a_bias_on_a_platform() -> None:
    rig = platform("viscous = 0.02")
    fits = ModelFits.of(rig, [true_log(rig)], [0], lambda text: None)
    same = equivalents(fits, candidates(rig), Hypothesis(("axis.bias_torque", "axis.coulomb")))
    assert {frozenset(e.names) for e in same} == {
        frozenset({"axis.asymmetric_friction"}),
        frozenset({"drive.bias", "axis.coulomb"}),
    }


@pytest.mark.parametrize(("c", "same"), [(-0.1, [("drive.supply_sag",)]), (0.1, [])])
def test_on_a_platform_a_gain_that_falls_may_be_a_supply_that_sags(c: float, same: list[tuple[str, ...]]) -> None:
    rig = platform("viscous = 0.02")
    fits, curved = (
        ModelFits.of(rig, [true_log(rig, **{"drive.curvature": {"c": c}})], [0], print),
        Hypothesis(("drive.curvature",)),
    )
    fits.race([curved], Hypothesis())
    assert [e.names for e in equivalents(fits, candidates(rig), curved)] == same


@pytest.mark.parametrize(("factor", "same"), [(1.2, [("drive.supply_sag",)]), (0.8, [])])
def test_a_winding_of_more_resistance_may_be_a_source_in_series_and_one_of_less_may_not(
    factor: float, same: list[tuple[str, ...]]
) -> None:
    rig, wrong = wheel(), Hypothesis(("parameter.motor.resistance",))
    true = replace(rig, numbers=rig.numbers | {"motor.resistance": factor * rig.numbers["motor.resistance"]})
    asked = record(TIME, 4.0 * COMMAND, {name: np.zeros_like(TIME) for name in ("wheel_rad_s", "current_A")})
    noise = np.random.default_rng(0)
    y = {name: v + noise.normal(0.0, 0.01, len(v)) for name, v in run(true, asked, {}).items() if name in asked.outputs}
    fits = ModelFits.of(rig, [record(TIME, 4.0 * COMMAND, y)], [0], lambda text: None)
    fits.race([wrong], Hypothesis())
    assert [e.names for e in equivalents(fits, candidates(rig), wrong)] == same


def test_a_rival_that_stands_at_a_wrong_place_begins_again_from_the_choice() -> None:
    rig = platform("viscous = 0.02")
    fits = ModelFits.of(rig, [true_log(rig, **{"drive.saturation": {"u_m": 4.0, "n": 2.0}})], [0], lambda text: None)
    choice, rival = Hypothesis(("drive.supply_sag",)), Hypothesis(("drive.saturation",))
    fits.race([choice, rival], Hypothesis())
    best = fits.known(rival)
    k = [best.problem.structure.names.index(f"drive.saturation.{name}") for name in ("u_m", "n")]
    theta = best.theta.copy()
    theta[k] = 1.25, 5000.0
    fits._done[rival] = together([with_residual(replace(best, theta=theta))])[0]
    fits._finished.add(rival)
    stuck = fits.known(rival).cost
    fits.race([rival], choice)
    assert fits.known(rival).cost == stuck  # a race leaves alone what has come to its end
    fits.again([rival], choice)
    assert fits.known(rival).cost < 1.1 * best.cost < 0.2 * stuck and fits.ended(rival)
    assert all(len(fits(e).evaluation.local) for e in (choice, rival))  # as a parent of others needs


def test_what_many_places_serve_is_searched_from_all_of_them_at_last() -> None:
    rig = platform("viscous = 0.02")
    stop = {"high": 0.3, "low": -1e6, "k": 3.0, "d": 0.5}
    fits = ModelFits.of(rig, [true_log(rig, noise=2e-3, **{"axis.end_stop": stop})], [0], lambda text: None)
    few, many = Hypothesis(("axis.bias_torque",)), Hypothesis(("axis.end_stop",))
    fits.race([few, many], Hypothesis())
    fitted, begun = fits.known(few), fits.known(many)
    names = begun.problem.structure.names
    lost = np.where([name == "axis.end_stop.high" for name in names], 1e6, begun.theta)
    fits._done[many] = together([with_residual(replace(begun, theta=lost))])[0]
    search = Search(fits)
    assert search.excess(many) > 100.0
    search._last_resort([few, many], [], enough=0.1)
    assert search.excess(many) < 0.1 and fits.known(few) is fitted  # of which there are two places alone


def test_a_play_of_nothing_is_the_coupling_that_it_hands_its_numbers_to() -> None:
    rig, true = platform("viscous = 0.02"), {"s": 0.6, "k": 60.0, "c": 0.1}
    fits = ModelFits.of(rig, [true_log(rig, **{"axis.flexible_coupling": true})], [0], lambda text: None)
    play, elastic = Hypothesis(("axis.backlash",)), Hypothesis(("axis.flexible_coupling",))
    fits.race([play], Hypothesis())
    begun = fits.known(play)
    theta = begun.theta.copy()
    for name, value in (true | {"g": 0.0}).items():
        theta[begun.problem.structure.names.index(f"axis.backlash.{name}")] = value
    fits._done[play] = together([with_derivatives(together([with_residual(replace(begun, theta=theta))])[0])])[0]
    fits.race([elastic], play)
    found = fits.known(elastic)
    assert {name: found.numbers()[f"axis.flexible_coupling.{name}"] for name in true} == pytest.approx(true, rel=0.1)
    assert Search(fits)._leader([play, elastic]) == elastic


def test_a_choice_gives_way_to_a_rival_with_more_evidence_and_not_the_other_way_round() -> None:
    rig = platform("viscous = 0.02")
    fits = ModelFits.of(rig, [true_log(rig, **{"drive.curvature": {"c": 0.2}})], [0], lambda text: None)
    search, wrong, right = Search(fits), Hypothesis(("drive.saturation",)), Hypothesis(("drive.curvature",))
    search.names = ("drive.saturation", "drive.curvature", "parameter.drive.gain")
    fits.race([wrong, right], Hypothesis())
    fits.race(search._exchanged(wrong), Hypothesis())
    assert search._surpassing(wrong, search._exchanged(wrong)) == right
    assert search._surpassing(right, search._rivals(right)) is None


@pytest.mark.parametrize("choice", ["drive.curvature", "parameter.drive.gain"])
def test_what_is_far_behind_begins_no_more_where_the_choice_reaches_the_noise(
    choice: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, best = platform("viscous = 0.02"), Hypothesis((choice,))
    fits = ModelFits.of(rig, [true_log(rig, noise=2e-3, **{"drive.curvature": {"c": 0.2}})], [0], lambda text: None)
    search = Search(fits)
    search.names = ("drive.saturation", "drive.curvature", "parameter.drive.gain", "parameter.axis.inertia")
    monkeypatch.setattr(
        "rwjax.diagnosis.search.forward_backward.HOPELESS", 0.0
    )  # rivals of a wrong choice are asked for, too
    fits.race([Hypothesis((name,)) for name in search.names], Hypothesis())
    begun: set[Hypothesis] = set()
    monkeypatch.setattr(fits, "again", lambda hypotheses, parent: begun.update(hypotheses))
    rivals = search._rivals(best)
    far = {e for e in rivals if fits.known(e).cost > BEHIND * fits.known(best).cost}
    assert far
    assert begun == {*rivals} - (far if choice == "drive.curvature" else set())


def test_a_fit_by_exact_derivatives_leaves_a_place_where_whole_runs_end() -> None:
    rig, named = platform("viscous = 0.02"), Hypothesis(("drive.saturation",))
    fits = ModelFits.of(rig, [true_log(rig, **{"drive.saturation": {"u_m": 0.9, "n": 2.0}})], [0], lambda text: None)
    fits.race([named], Hypothesis())
    raced = fits.known(named)
    k = [raced.problem.structure.names.index(f"drive.saturation.{name}") for name in ("u_m", "n")]
    theta = raced.theta.copy()
    theta[k] = 0.7, 300.0
    fits._done[named] = together([with_residual(replace(raced, theta=theta))])[0]
    fits.exactly([named])
    found = fits.known(named)
    assert 2.0 * found.cost < 1.2 * found.problem.batch.readings
    assert found.theta[k] == pytest.approx([0.9, 2.0], rel=0.1)


def test_exact_derivatives_take_several_and_leave_what_reaches_back_too_far() -> None:
    rig = platform("viscous = 0.02")
    several = [Hypothesis((name,)) for name in ("axis.coulomb", "sensor.delay", "axis.quadratic_drag")]
    log = true_log(rig, **{"axis.quadratic_drag": {"c": 0.01}})
    fits = ModelFits.of(rig, [log], [0], lambda text: None)
    fits.race(several, Hypothesis())
    late, before = several[1], [fits.known(e) for e in several]
    fits.exactly(several)
    after = [fits.known(e) for e in several]
    assert fits.known(late) is before[1]
    assert all(b.cost <= a.cost for a, b in zip(before, after, strict=True))
    fits.exactly(several)
    assert all(fits.known(e) is f for e, f in zip(several, after, strict=True))


def test_a_screen_also_begins_where_the_free_numbers_suit_the_start() -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    named = Hypothesis(("sensor.scale",))
    fits = ModelFits.of(rig, [true_log(rig)], [0], lambda text: None)
    candidate = fits._candidate(named, Hypothesis())
    off, first = candidate.off, candidate.starts[0]
    probed = together([residuals(candidate.problem, [off, first], [candidate.first] * 2)])[0]
    (moved,) = Screen(fits(Hypothesis()))._moved(replace(candidate, starts=[first]), probed)
    after = together([residuals(candidate.problem, [moved], [candidate.first])])[0]
    assert np.sum(after**2) < 0.2 * np.sum(probed[1] ** 2)  # what a wrong scale does, another inertia undoes
    assert {candidate.problem.structure.names[k] for k in np.flatnonzero(moved != first)} == {*rig.free}


def test_equal_sets_free_the_same_numbers_and_are_one_key() -> None:
    one, other = Hypothesis(("axis.stribeck", "axis.bias_torque")), Hypothesis(("axis.bias_torque", "axis.stribeck"))
    assert one == other and {one: 1}[other] == 1
    assert one != Hypothesis(("axis.stribeck",))


@pytest.mark.parametrize("noise", [0.0, 2e-4], ids=["exact", "noisy"])
@pytest.mark.filterwarnings("error")
def test_logs_in_which_nothing_moves_do_not_say_that_nothing_is_missing(noise: float) -> None:
    still = 0.3 + np.random.default_rng(0).normal(0.0, noise, len(TIME))
    found = diagnose(platform(), [record(TIME, np.zeros(len(TIME)), {"yaw_rad": still})])
    assert found.verdict == "unknown" and not found.effects
    assert "nothing moves in these logs" in verdict_sentence(found) and "turns" in found.next_experiment


SLOW = np.sin(0.5 * TIME)


@pytest.mark.parametrize(
    ("motion", "moved"),
    [
        (np.zeros(len(TIME)), False),
        (1e-3 * SLOW, False),
        (3e-3 * SLOW, True),
        (5e-3 * (np.abs(TIME - 8.0) < 0.25), True),
        (1.0 * TIME, True),
    ],
    ids=["rest", "one deviation", "three deviations", "a short pulse", "turning"],
)
def test_what_stands_above_the_noise_moves(motion: np.ndarray, moved: bool) -> None:
    noise = np.random.default_rng(2).normal(0.0, 1e-3, len(TIME))
    assert moves(record(TIME, COMMAND, {"yaw_rad": 0.3 + motion + noise})) is moved


def test_a_counter_between_two_counts_does_not_move() -> None:
    step = 2.0 * np.pi / 2048.0
    flicker = record(TIME, COMMAND, {"yaw_rad": step * (TIME % 0.5 < 0.26)})
    assert not moves(replace(flicker, resolution={"yaw_rad": step}))


def rung(numbers: dict[str, tuple[float, float]], own: dict[str, tuple[float, float]], drift=(np.nan, np.nan)) -> Rung:
    return Rung((), 1.0, numbers, dict.fromkeys(numbers, drift), own)


def test_numbers_are_told_with_their_errors_and_units() -> None:
    own = {"axis.stribeck.M_c": (0.45, 0.01), "axis.stribeck.n": (1.5, np.inf), "axis.inertia": (0.2, 0.003)}
    assert numbers_of(rung({}, own)) == [
        "axis.stribeck: M_c = 0.45 ± 0.01 N m, n = 1.5 (not told by these logs)",
        "axis.inertia = 0.2 ± 0.003 kg m2",
    ]


@pytest.mark.parametrize(
    ("before", "after", "drift", "told"),
    [
        ((1.0, 0.1), (1.04, 0.01), (0.4, 4.0), []),
        ((1.0, 0.01), (1.06, 0.01), (4.2, 6.0), ["J moves by +6.0 % (+4.2 sigma) when the effects are added"]),
        ((1.0, 5.0), (1.9, 0.01), (0.2, 90.0), ["J moves by +90.0 % (+0.2 sigma) when the effects are added"]),
        ((1.0, 5.0), (1.9, 4.0), (0.1, 90.0), []),
        ((1.0, np.inf), (2.0, 0.01), (np.nan, 100.0), ["J moves by +100.0 % when the effects are added"]),
        ((0.0, 5.0), (2.0, 0.01), (0.4, np.nan), ["J moves by +2 (+0.4 sigma) when the effects are added"]),
        ((1.0, 0.1), (9.0, np.inf), (np.nan, 800.0), []),
    ],
    ids=["hardly", "surely", "far", "far by chance", "not told before", "from none", "not told after"],
)
def test_base_numbers_that_move_are_told(before, after, drift, told: list[str]) -> None:
    assert moved(rung({"J": before}, {}), rung({"J": after}, {}, drift)) == told


def test_coordinates_in_which_a_law_removes_as_much_are_told() -> None:
    def words(**shares: float) -> str:
        return where_words(Where("yaw_rate", shares["yaw_rate"], None, None, shares, ()))

    assert words(yaw_rate=0.99, yaw=0.989, voltage=0.5) == "yaw rate (as one in yaw)"
    assert words(yaw_rate=0.4, voltage=1.0) == "yaw rate" == words(yaw_rate=0.0, yaw=0.0)


@pytest.mark.slow
def test_a_wheel_that_stands_still_is_remarked_on_and_a_turning_one_is_not() -> None:
    rig, rng = wheel(), np.random.default_rng(1)
    command = np.where(TIME > 1.0, 0.5, 0.0)
    held = {"wheel_rad_s": rng.normal(0.0, 0.01, len(TIME)), "current_A": command / 0.83}
    found = diagnose(rig, [record(TIME, command, held)])
    assert found.verdict == "unknown" and not found.effects
    assert "turns" in found.next_experiment and any("hardly moves" in remark for remark in found.remarks)
    turning = run(rig, record(TIME, command, held), {})
    assert ran_away(rig, fit(rig, [record(TIME, command, turning)]).fit) == ()


def test_a_race_moves_no_number_that_its_explanation_leaves_as_the_rig_file_says() -> None:
    rig = platform(free='"axis.friction.viscous"')
    heavy = true_log(rig.with_values({"axis.inertia": 1.1 * rig.numbers["axis.inertia"]}))
    fits, wrong = ModelFits.of(rig, [heavy], [0], lambda text: None), Hypothesis(("parameter.axis.inertia",))
    fits.race([wrong], Hypothesis())
    fits.race([Hypothesis(), Hypothesis(("axis.spring",))], wrong)
    for hypothesis in (Hypothesis(), Hypothesis(("axis.spring",))):
        assert fits(hypothesis).numbers()["axis.inertia"] == rig.numbers["axis.inertia"]
    assert fits(wrong).numbers()["axis.inertia"] == pytest.approx(1.1 * rig.numbers["axis.inertia"], rel=0.01)


@pytest.mark.parametrize(
    ("cost", "before", "promise"),
    [
        (50.0, 100.0, 12.5),  # halved, and so twice again
        (2000.0, 8000.0, 125.0),  # far above its parent's 100, on its way
        (100.5, 8000.0, 100.5),  # come down to its parent: it adds nothing and promises nothing
        (80.0, 8000.0, 51.2),  # below it: what it gained on the parent counts
        (90.0, 80.0, 90.0),
        (50.0, np.inf, 12.5),
        (2000.0, np.inf, 2000.0),
    ],
)
def test_what_an_explanation_promises_is_what_it_gains_on_its_parent(
    cost: float, before: float, promise: float
) -> None:
    assert promise_of(cost, before, 100.0) == pytest.approx(promise)


@pytest.mark.parametrize(
    ("effect", "numbers"),
    [("axis.stribeck", {"M_c": 0.05, "M_e": 0.03, "v_s": 0.3, "n": 1.5}), ("sensor.delay", {"tau": 0.03})],
)
def test_a_fit_by_exact_derivatives_holds_the_residual_of_its_free_runs(effect: str, numbers: dict[str, float]) -> None:
    rig, named = platform("viscous = 0.02"), Hypothesis((effect,))
    fits = ModelFits.of(rig, [true_log(rig, **{effect: numbers})], [0], lambda text: None)
    fits.race([named], Hypothesis())
    fits._done[named] = replace(fits.known(named), cost=np.inf)  # whatever is found now is taken
    fits.exactly([named])
    found = fits.known(named)
    free_run = together([residuals(found.problem, [found.theta], [found.start])])[0][0]
    assert found.evaluation.residual == pytest.approx(free_run, abs=1e-6)
    assert {name: found.numbers()[f"{effect}.{name}"] for name in numbers} == pytest.approx(numbers, rel=0.05)


def test_a_stop_is_searched_from_every_place_that_differs() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.03")
    stop = {"high": 0.8, "low": -1e6, "k": 40.0, "d": 1.5}
    log = true_log(rig, **{"axis.end_stop": stop})
    fits = ModelFits.of(rig, [log], [0], lambda text: None)
    nothing, stopped = Hypothesis(), Hypothesis(("axis.end_stop",))
    fits(nothing)
    fits.start_from_first_readings()
    screened, begun = fits._begun([stopped], nothing)
    costs = np.array([f.cost for f in begun[stopped]])
    assert len(costs) < len(screened[stopped].begin)  # what no run reaches may lie anywhere
    assert np.all(np.diff(costs) > 1e-9 * costs[:-1])
    fits._done[stopped] = begun[stopped][-1]  # as if a race had left all others behind
    fits.search(stopped, nothing)
    found = fits.known(stopped)
    assert found.cost < 0.05 * costs[0] and found.numbers()["axis.end_stop.high"] == pytest.approx(0.8, abs=0.05)
