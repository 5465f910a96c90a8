"""Limit speeds: eq. 3.3 solved either way, separate with a current, dry friction, honest errors, and what is refused."""

import numpy as np
import pytest

from experiments.methods.limit_speeds import CASES, draw, held, rig_of
from rwjax import InputError, Log, Rig, parse_rig
from rwjax.methods.limit_speeds import limit_speeds
from tests.systems import platform, record, wheel

K, B, DRY = "motor.torque_constant", "motor.friction", "wheel.coulomb.M_c"
R, SLOPE = 0.83, 54.39  # ohm, rad/s per volt (Table 3.1, listing A.3)
LEVELS = (2.0, 4.0, 6.0, 8.0, 10.0)
DEAD = '[effects."drive.deadzone"]\nu_0 = 0.4'


def rig(*free: str, more: str = "", kind: str = "wheel") -> Rig:
    """The thesis's motor with its wheel, and what is free."""
    return parse_rig(
        f'kind = "{kind}"\n[motor]\ntorque_constant = 0.0182\nresistance = {R}\nfriction = 1e-6\n[wheel]\ninertia = 1.24e-4\n'
        f"{more}\n[fit]\nfree = {[*free]}".replace("'", '"')
    )


def steady(
    slope: float = SLOPE, *, lost: float = 0.0, current: float | None = None, dry: float = 0.0, levels=LEVELS
) -> Log:
    """Speeds over levels of voltage of which some is lost, with little noise; currents of a friction and a dry torque over K."""
    u = np.repeat(np.array(levels), 200)
    rng = np.random.default_rng(0)
    speed = slope * np.sign(u) * np.maximum(np.abs(u) - lost, 0.0)
    outputs = {"wheel_rad_s": speed + np.where(speed, 1e-3, 0.0) * rng.normal(size=len(u))}
    if current is not None:
        outputs["current_A"] = current * speed + dry * np.sign(speed) + 1e-5 * rng.normal(size=len(u))
    return record(np.arange(len(u)) * 0.01, u, outputs)


def test_the_thesis_s_slope_gives_the_thesis_s_friction() -> None:
    found = limit_speeds(rig(B), [steady()])
    assert found.rig.values[B] == pytest.approx(4.07e-6, abs=0.005e-6)  # Table 3.1
    assert found.rig.values[B] == pytest.approx((0.0182 / SLOPE - 0.0182**2) / R, rel=1e-4)
    assert found.rig.values[K] == 0.0182 and list(found.interval) == [B]
    changed = ((1.0 / SLOPE - 1.01 * 0.0182) * 1.01 * 0.0182 / R) / found.rig.values[B] - 1.0
    assert f"{B} rests on {K}: 1 % more of that changes it by {100.0 * changed:+.2g} %" in found.notes


@pytest.mark.parametrize("b", [4.07e-6, 8e-5])
def test_the_torque_constant_is_the_larger_root(b: float) -> None:
    believed = rig(K).with_values({B: b})
    found = limit_speeds(believed, [steady()]).rig.values[K]
    assert R * b / found + found == pytest.approx(1.0 / SLOPE, rel=1e-5)
    assert found > 0.5 / SLOPE  # the roots lie on either side of it


@pytest.mark.parametrize(("b", "said"), [(9e-5, False), (1e-4, True)])  # near the latter the two roots meet
def test_what_the_torque_constant_rests_on_is_said_from_2_percent_on(b: float, said: bool) -> None:
    found = limit_speeds(rig(K).with_values({B: b}), [steady()])
    changed = 100.0 * (max(np.roots([1.0, -1.0 / SLOPE, R * 1.01 * b])) / found.rig.values[K] - 1.0)
    assert (abs(changed) > 2.0) == said
    assert (f"{K} rests on {B}: 1 % more of that changes it by {changed:+.2g} %" in found.notes) == said


def test_where_plateaus_scatter_every_one_counts_the_same() -> None:
    u = np.repeat(np.array(LEVELS), 300)
    rng = np.random.default_rng(0)
    off, noise = np.repeat([3.0, -2.0, -3.0, 2.0, 1.0], 300), np.repeat([0.01, 1.0, 0.01, 1.0, 0.01], 300)
    log = record(np.arange(len(u)) * 0.01, u, {"wheel_rad_s": 50.0 * u + off + noise * rng.normal(size=len(u))})
    found = limit_speeds(rig(B), [log])
    level, mean = np.array(LEVELS), 50.0 * np.array(LEVELS) + off[::300]
    slope = level @ mean / (level @ level)  # ordinary least squares through the origin
    assert found.rig.values[B] == pytest.approx((0.0182 / slope - 0.0182**2) / R, rel=0.002)
    scatter = np.sqrt(np.sum((mean - slope * level) ** 2) / 4.0 / (level @ level))
    error = 2.776 / 1.96 * scatter * 0.0182 / R / slope**2  # Student's factor of 4 degrees of freedom
    assert found.rig.standard_error[B] == pytest.approx(error, rel=0.02)
    assert any("scatter about the line by more than their noise" in note for note in found.notes)


def test_with_a_current_both_separate() -> None:
    k, b = 0.0175, 9e-6
    log = steady(1.0 / (R * b / k + k), current=b / k)
    found = limit_speeds(rig(K, B), [log]).rig
    for name, truth in ((K, k), (B, b)):
        assert abs(found.values[name] - truth) < 4.0 * found.standard_error[name] < 0.01 * truth


def test_dry_friction_is_the_shift_of_the_line() -> None:
    k, b, dry = 0.0182, 9e-6, 2e-3
    log = steady(1.0 / (R * b / k + k), lost=R * dry / k)
    found = limit_speeds(rig(B, DRY, more='[effects."wheel.coulomb"]\nM_c = 1e-3'), [log])
    assert found.rig.values[B] == pytest.approx(b, rel=1e-3) and found.rig.values[DRY] == pytest.approx(dry, rel=1e-3)
    assert not any("goes into" in note for note in found.notes)
    known = limit_speeds(rig(B, more=f'[effects."wheel.coulomb"]\nM_c = {dry}'), [log])
    assert known.rig.values[B] == pytest.approx(b, rel=1e-3) and not any("goes into" in n for n in known.notes)


def test_a_shift_that_the_rig_lacks_is_said_with_its_size() -> None:
    log = steady(lost=0.4, levels=(0.3, *LEVELS, *(-u for u in LEVELS)))
    found = limit_speeds(rig(B), [log])
    (said,) = (note for note in found.notes if "goes into" in note)
    assert said.startswith("the wheel lacks 0.4 ± ") and f"dry friction of {0.4 * 0.0182 / R:.3g} N m" in said
    assert "the wheel stands at up to 0.3 V, which is left out: dry friction or a dead zone holds it" in found.notes
    assert found.rig.values[B] > 2.0 * 4.07e-6  # it goes there indeed
    with_zone = limit_speeds(rig(B, more=DEAD), [log])
    assert with_zone.rig.values[B] == pytest.approx(4.07e-6, rel=0.01)
    assert not any("goes into" in note or "stands" in note for note in with_zone.notes)


def test_an_offset_of_the_drive_is_told_from_a_shift() -> None:
    u = np.repeat(np.array([*LEVELS, *(-u for u in LEVELS)]), 200)
    y = SLOPE * (u - 0.2) + 1e-3 * np.random.default_rng(0).normal(size=len(u))
    notes = limit_speeds(rig(B), [record(np.arange(len(u)) * 0.01, u, {"wheel_rad_s": y})]).notes
    (said,) = (note for note in notes if "goes into" in note)
    assert said.startswith("forward and back differ by an offset of -0.2 ± ")


def test_what_is_not_used_is_said() -> None:
    with_prior = parse_rig(
        f'kind = "wheel"\n[motor]\ntorque_constant = 0.0182\nresistance = {R}\nfriction = 1e-6\n[wheel]\ninertia = 1.24e-4\n'
        f'[fit]\nfree = ["wheel.inertia", "{B}"]\n[fit.prior]\n"{B}" = [1e-6, 1e-7]'
    )
    held_out = record(np.arange(300) * 0.01, np.full(300, 5.0), {"wheel_rad_s": np.full(300, 1.0)}, validate=True)
    found = limit_speeds(with_prior, [steady(), held_out])
    assert found.rig.values[B] == pytest.approx(4.07e-6, abs=0.005e-6)
    assert found.notes[:2] == (
        "does not know fit.prior of the rig file",
        "wheel.inertia is not estimated by the limit-speed method",
    )


LAG, HEAT = '[effects."drive.lag"]\nT = 0.1', '[effects."motor.heating"]\nc = 1e-4\ntau = 60.0'
DRY_TOO = '[effects."wheel.coulomb"]\nM_c = 1e-3'


@pytest.mark.parametrize(
    ("of", "log", "message"),
    [
        (platform(), steady(), "kind `platform` has no motor with one wheel"),
        (rig("wheel.inertia"), steady(), r"\[fit\] free names none of motor.torque_constant, motor.friction; the limit"),
        (rig(B, more=HEAT), steady(), "has motor.heating, which the limit-speed method does not know"),
        (rig(K, B), steady(), "tells R b/K \\+ K alone; take motor.torque_constant or motor.friction out of"),
        (rig(K, B), steady(current=1.0), "the currents times motor.resistance exceed the voltages"),
        (rig(B), record(np.arange(200) * 0.01, np.ones(200)), "no `wheel_rad_s`, `wheel_rad` or `wheel_counts`"),
        (rig(B), steady(levels=(0.0, 0.0)), r"turns steadily \(it stands on all\)"),
        (rig(B), record(np.arange(200) * 0.01, np.arange(200.0), {"wheel_rad_s": np.ones(200)}), "same voltage over 96"),
        (rig(B), record(np.arange(200) * 0.01, np.ones(200), {"wheel_rad_s": np.arange(200.0)}), "settles on none"),
        (rig(B), steady(1.0 / 0.0181), "`motor.friction` comes out as -2.*below 0: the wheel is faster than motor.torque"),
        (rig(K).with_values({B: 2e-4}), steady(), "no motor.torque_constant gives 54.39 rad/s per volt .* at most 0.000102"),
        (rig(B, DRY, more=DRY_TOO), steady(levels=(5.0, -5.0)), "need plateaus at two sizes of voltage at least"),
        (rig(B, more=f"[fit.bounds]\n'{B}' = [1e-7, 2e-6]"), steady(), r"outside its `fit.bounds` \[1e-07, 2e-06\]"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_said_in_one_line(of: Rig, log: Log, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        limit_speeds(of, [log])
    assert "\n" not in str(refused.value)


def test_a_run_with_another_motor_is_refused_and_one_with_another_axis_is_not() -> None:
    log = steady()
    log.added["motor.resistance"] = 0.1
    with pytest.raises(InputError, match="has `# add motor.resistance`"):
        limit_speeds(rig(B), [log])
    other = steady()
    other.added["axis.inertia"] = 0.012
    of = rig(B, more=f"[axis]\ninertia = 0.05\n{LAG}", kind="reaction")
    assert limit_speeds(of, [other]).rig.values[B] == pytest.approx(4.07e-6, abs=0.005e-6)


def test_friction_below_zero_by_its_error_alone_is_zero() -> None:
    u = np.repeat(np.array(LEVELS), 200)
    y = u / 0.0182 + 3.0 * np.random.default_rng(4).normal(size=len(u))
    logs = [record(np.arange(len(u)) * 0.01, u, {"wheel_rad_s": y + shift}) for shift in (0.1,)]
    found = limit_speeds(rig(B), logs)
    assert found.rig.values[B] == 0.0 and any("below 0 by no more than its error: 0 is taken" in n for n in found.notes)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_numbers_of_simulated_staircases_lie_within_their_errors(case) -> None:
    motor, logs = draw(np.random.default_rng(3), case)
    found = limit_speeds(rig_of(motor, case), logs).rig
    for name, truth in ((K, motor.K), (B, motor.b), (DRY, motor.dry)):
        if name in case.free:
            assert abs(found.values[name] - truth) < 4.0 * found.standard_error[name] < 0.3 * truth


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_intervals_hold_the_truth_as_often_as_they_say(case) -> None:
    each = [hold for seed in range(60) for hold in held(case, 500 + seed) or ()]
    assert 0.88 <= np.mean(each) and len(each) >= 50


def test_a_rig_s_other_numbers_stay() -> None:
    before = wheel()
    after = limit_speeds(before.with_values({B: 1e-6}), [steady()]).rig
    assert {n for n in before.numbers if after.numbers[n] != before.numbers[n]} == {B}
