"""Rivals of the diagnosis: each finds a known term in a made-up torque and nothing in noise; scores worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")
pytest.importorskip("sklearn", reason="the lasso needs the extra `rivals`")
pytest.importorskip("pysindy", reason="sparse regression needs the extra `rivals`")

from experiments.rivals import score
from experiments.rivals.dictionary import BEYOND, forms
from experiments.rivals.equations import Motion, motion_of
from experiments.rivals.friction_list import friction_list
from experiments.rivals.problem import Problem, pose
from experiments.rivals.run import BY_REGRESSION, split, surest
from experiments.rivals.selection import independent
from rwjax import Log, Rig, fit, parse_rig, simulate
from rwjax.effects.library import EFFECTS

RIG = """
kind = "platform"
[drive]
gain = 0.4
[axis]
inertia = 0.2
[axis.friction]
viscous = 0.05
[fit]
free = ["axis.inertia", "axis.friction.viscous"]
"""
H = 0.01  # s
DRAG = 0.02  # N m s2/rad2
AMONG = ("axis.coulomb", "axis.quadratic_drag", "axis.bias_torque", "axis.imbalance", "drive.delay", "drive.curvature")


def run(rng: np.random.Generator, drag: float, noise: float) -> Motion:
    """One made-up run whose readings lack a drag, with white noise on the acceleration."""
    t = np.arange(0.0, 12.0, H)
    w = sum(a * np.sin(f * t + rng.uniform(0, 6)) for a, f in ((1.5, 0.9), (1.0, 2.3), (0.7, 4.1)))
    V = np.interp(t, np.arange(0.0, 13.0, 0.5), rng.uniform(-5, 5, 26))
    psi = np.cumsum(w) * H
    model = {"w": (0.4 * V - 0.05 * w) / 0.2}
    rate = model["w"] - drag * w * np.abs(w) / 0.2 + noise * rng.normal(size=len(t))
    speed = cumulative_trapezoid(rate, dx=H, initial=0.0)
    numbers = {"axis.inertia": 0.2, "drive.gain": 0.4, "axis.friction.viscous": 0.05}
    by_number = {"axis.inertia": {"w": -model["w"] / 0.2}, "axis.friction.viscous": {"w": -w / 0.2}}
    still, states = {"w": np.zeros(len(t), bool)}, {"psi": psi, "w": w}
    scaled = {"w": model["w"] + 0.05 * w / 0.2}
    return Motion(t, V, V, states, numbers, "platform", still, {"w": ("rate", speed)}, model, by_number, scaled, H)


def problem(drag: float, noise: float = 0.05, seed: int = 0) -> Problem:
    rng = np.random.default_rng(seed)
    runs = [replace(run(rng, drag, noise), length=0.8) for _ in range(4)]
    return pose(runs, [False, False, False, True], ("axis.inertia", "axis.friction.viscous"), AMONG)


@pytest.mark.parametrize("name", BY_REGRESSION)
def test_a_known_term_is_found_and_removes_the_held_out_error(name: str) -> None:
    names, sure = surest(name, [problem(DRAG)])
    assert names == ["axis.quadratic_drag"]
    assert sure > 0.9


@pytest.mark.parametrize("name", BY_REGRESSION)
def test_where_nothing_lacks_nothing_reaches_the_threshold(name: str) -> None:
    for seed in range(3):
        names, sure = surest(name, [problem(0.0, seed=seed)])
        assert not names or sure < score.OWN


@pytest.mark.parametrize("name", BY_REGRESSION)
def test_a_rival_without_rows_names_nothing(name: str) -> None:
    runs = [run(np.random.default_rng(0), DRAG, 0.0) for _ in range(2)]
    resting = [replace(m, rests={"w": np.ones(len(m.t), bool)}) for m in runs]
    assert surest(name, [pose(resting, [False, True], ("axis.inertia",), AMONG)]) == ([], 0.0)


def test_every_effect_of_one_axis_has_a_form_or_a_reason() -> None:
    rng = np.random.default_rng(0)
    platform = run(rng, 0.0, 0.0)
    wheel = replace(
        platform,
        kind="reaction",
        states=platform.states | {"Omega": platform.states["w"], "theta": platform.states["psi"]},
    )
    known = {*forms([platform]), *forms([wheel])} | {*BEYOND}
    by_voltage = {e.name for e in EFFECTS if not e.needs_servo}
    assert by_voltage - known <= {"drive.one_sided", "drive.square_law"}


def test_correlated_rows_count_as_few() -> None:
    rng = np.random.default_rng(0)
    white, one = rng.normal(size=4000), np.zeros(4000, int)
    assert independent(white, one) == pytest.approx(4000, rel=0.1)
    assert independent(np.convolve(white, np.ones(10), "same"), one) == pytest.approx(400, rel=0.3)


def logs(rig: Rig, seed: int, level: float) -> list[Log]:
    """Three logs of a platform with so much dry friction and the noise of a gyroscope."""
    rng, found = np.random.default_rng(seed), []
    true = RIG.replace("viscous = 0.05", f"viscous = 0.05\ncoulomb = {level}")
    for k in range(3):
        t = np.arange(0.0, 8.0, H)
        V = 3.0 * np.sign(np.sin((0.8 + 0.3 * k) * t + 0.1))
        w = np.asarray(simulate(parse_rig(true), t, V)["yaw_rad_s"]) + 0.01 * rng.normal(size=len(t))
        notes = {"role": "validate"} if k == 2 else {}
        found.append(Log.from_arrays(rig, time=t, name=f"run {k}", notes=notes, voltage_V=V, yaw_rad_s=w))
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("level", "named"), [(0.2, True), (0.0, False)])
def test_the_friction_list_and_the_equations_find_dry_friction_where_it_lacks(level: float, named: bool) -> None:
    rig = parse_rig(RIG)
    train, held_out = split(logs(rig, 0, level))
    fitted = fit(rig, train).rig
    names, sure = friction_list(fitted, train, held_out)
    assert (sure > 0.5) == named
    assert not named or "axis.coulomb" in names or "axis.stribeck" in names
    motions = [motion_of(fitted, log) for log in (*train, *held_out)]
    assert motions[0].kind == "platform"
    found = pose(motions, [False, False, True], rig.free, AMONG)
    assert (found.removed(["axis.coulomb"]) > 0.5) == named


def line(group: str, effect: str, names: list[str], confidence: float, rival: str = "lasso") -> dict:
    return {"group": group, "effect": effect, "names": names, "confidence": confidence, "same_as": {}, "rival": rival}


LINES = [
    line("single", "axis.coulomb", ["axis.coulomb"], 0.9),
    line("single", "axis.spring", ["axis.spring", "drive.bias"], 0.7),
    line("single", "drive.lag", ["drive.delay"], 0.5),
    line("single", "axis.backlash", ["axis.spring"], 0.3),
    line("single", "drive.bias", [], 0.0),
    line("none", "none", ["drive.delay"], 0.4),
    line("none", "none", ["drive.lag"], 0.6),
    line("none", "none", [], 0.0),
]


@pytest.mark.parametrize(
    ("count", "least", "right", "wider", "wrong", "false"),
    [(1, 0.9, 1, 0, 0, 0), (3, 0.5, 1, 1, 1, 1), (5, 0.3, 1, 1, 2, 2)],
)
def test_scores_at_equal_coverage(count: int, least: float, right: int, wider: int, wrong: int, false: int) -> None:
    assert score.threshold(LINES, count) == least
    found = score.scored(LINES, least)
    assert (found.cases, found.answered) == (5, min(count, 4))
    assert (found.right, found.wider, found.wrong) == (right, wider, wrong)
    assert (found.nones, found.false) == (3, false)
    assert found.unsayable == 1


def test_nothing_is_answered_at_no_coverage() -> None:
    assert score.scored(LINES, score.threshold(LINES, 0)).answered == 0


@pytest.mark.parametrize(
    ("rival", "effect", "said"),
    [
        ("lasso", "axis.backlash", False),
        ("friction_list", "drive.lag", False),
        ("friction_list", "axis.stribeck", True),
    ],
)
def test_what_a_rival_has_no_word_for_is_told(rival: str, effect: str, said: bool) -> None:
    assert score.sayable(line("single", effect, [], 0.0, rival)) == said


def test_the_same_thing_under_another_name_is_right() -> None:
    case = line("single", "axis.asymmetric_friction", ["drive.bias"], 0.9)
    case["same_as"] = {"axis.asymmetric_friction": ["axis.bias_torque", "drive.bias"]}
    assert score.judge(case) == "right"
    assert score.sayable(case)


def test_the_library_is_judged_as_in_its_own_scores() -> None:
    both = {"kind": "platform", "same_as": {}, "alternatives": []}
    answers = [
        both | {"index": 0, "group": "single", "effect": "drive.lag", "verdict": "effect", "effects": ["drive.lag"]},
        both | {"index": 1, "group": "single", "effect": "drive.lag", "verdict": "effect", "effects": ["drive.bias"]},
        both | {"index": 2, "group": "single", "effect": "drive.lag", "verdict": "unknown", "effects": []},
        both | {"index": 3, "group": "none", "effect": "none", "verdict": "none", "effects": []},
    ]
    found = score.of_library(answers, {})
    assert (found.cases, found.answered, found.right, found.wrong, found.nones, found.false) == (3, 2, 1, 1, 1, 0)
