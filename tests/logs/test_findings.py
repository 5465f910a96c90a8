"""What is odd about a log: each oddity is put into a log that has none, and found alone."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.logs.findings import MOST_NOTED, Finding, findings, gaps_in_time, holes, missing_rows
from rwjax.logs.log import Log

RNG = np.random.default_rng(3)
T = np.arange(2000) * 0.01
U = 4.0 * np.sin(1.3 * T) + 2.0 * np.sign(np.sin(0.7 * T))
ANGLE = np.cumsum(np.cumsum(U)) * 1e-4 + 0.001 * RNG.normal(size=2000)
RATE = np.cumsum(U) * 0.01 + 0.01 * RNG.normal(size=2000)
GOOD = Log("run", T, U, {"yaw_rad": ANGLE, "yaw_rad_s": RATE}, {"yaw_rad": 0.0, "yaw_rad_s": 0.0}, {}, False, None, 0.0)
COUNT = 2.0 * np.pi / 4096


def said(log: Log) -> list[tuple[str, str]]:
    return [(found.about, found.says) for found in findings(log)]


def at(y: np.ndarray, where: slice, value: float | np.ndarray) -> np.ndarray:
    out = y.copy()
    out[where] = value
    return out


def of(**outputs: np.ndarray) -> Log:
    return replace(GOOD, outputs=GOOD.outputs | outputs)


def loop() -> Log:
    """A position loop that reads the noise of its encoder."""
    y, rate, u, read = 0.0, 0.0, np.zeros(2000), np.zeros(2000)
    for k in range(2000):
        read[k] = y + 0.01 * RNG.normal()
        u[k] = 20.0 * (np.sin(0.9 * T[k]) - read[k]) - 5.0 * rate
        rate += 0.01 * (u[k] - rate)
        y += 0.01 * rate
    return replace(GOOD, command=u, outputs={"yaw_rad": read}, resolution={"yaw_rad": 0.0})


def test_a_log_as_it_should_be_has_no_findings() -> None:
    assert findings(GOOD) == []


wrapped = np.round(ANGLE / COUNT) * COUNT
ODD = [
    (
        replace(GOOD, time=np.where(np.arange(2000) > 700, T + 3.0, T)),
        "clock",
        "1 gap in time, the longest 3.01 s at 7 s",
    ),
    (replace(GOOD, time=T + 0.004 * RNG.uniform(-1, 1, 2000)), "clock", "ms apart, "),
    (replace(GOOD, time=T + 1e-3 * T**2), "clock", "does the clock drift?"),
    (replace(GOOD, command=np.full(2000, -0.0)), "command", "voltage_V is 0 throughout"),
    (replace(GOOD, command=np.abs(U)), "command", "voltage_V never goes below 0"),
    (replace(GOOD, command=np.clip(U, -4.0, 4.0)), "command", "voltage_V is at its largest, 4 V, in "),
    (
        of(yaw_rad=at(ANGLE, slice(100, 200), np.nan)),
        "readings",
        "yaw_rad: 100 of 2000 readings are missing, the first at 1 s",
    ),
    (
        replace(GOOD, left_out={"yaw_rad": np.array([3.0, 4.0])}),
        "readings",
        "yaw_rad: 2 outliers, the first at 3 s, not counted",
    ),
    (
        replace(GOOD, left_out={"yaw_rad": GOOD.time[-1:]}),
        "readings",
        f"yaw_rad: the last reading, at {GOOD.time[-1]:.6g} s, is an outlier and not counted: where the recording broke off within",
    ),
    (of(yaw_rad_s=at(RATE, slice(500, 560), RATE[500])), "readings", "yaw_rad_s stays the same for 0.59 s from 5 s on"),
    (of(yaw_rad_s=0.01 * RNG.normal(size=2000)), "readings", "yaw_rad_s hardly moves"),
    (
        replace(of(yaw_rad=np.mod(wrapped, 4096 * COUNT)), resolution={"yaw_rad": COUNT, "yaw_rad_s": 0.0}),
        "readings",
        "yaw_rad jumps by 4096 counts, a turn, ",
    ),
    (of(yaw_rad=np.mod(ANGLE + np.pi, 2.0 * np.pi)), "readings", "yaw_rad jumps by 6.283 rad, a turn, "),
    (
        of(yaw_rad=ANGLE + np.where(T < 9.0, 0.0, 5.0)),
        "readings",
        " rad at 9 s and goes on from there: was the counter set anew?",
    ),
    (loop(), "loop", "voltage_V answers yaw_rad (correlation "),
]


@pytest.mark.parametrize(("log", "about", "says"), ODD, ids=[says for *_, says in ODD])
def test_an_oddity_is_found(log: Log, about: str, says: str) -> None:
    found = [one for one in said(log) if one[0] == about and says in one[1]]
    assert len(found) == 1, said(log)


@pytest.mark.parametrize("log", [log for log, *_ in ODD], ids=[says for *_, says in ODD])
def test_an_oddity_is_not_taken_for_many(log: Log) -> None:
    assert len(findings(log)) <= 2


def test_a_square_wave_is_not_clipped() -> None:
    square = np.where(np.sin(T) > 0.0, 4.0, -4.0)
    mixed = np.where(T < 10.0, square, 3.0 * np.sin(2.0 * T))
    assert not any("largest" in says for u in (square, mixed) for _, says in said(replace(GOOD, command=u)))


def test_a_goal_that_rests_at_its_largest_is_not_clipped() -> None:
    raised = np.minimum(T, 3.0)
    assert any("largest" in says for _, says in said(replace(GOOD, command=raised)))
    assert not any("largest" in says for _, says in said(replace(GOOD, command=raised, input="goal_rad")))


def test_a_goal_is_no_loop_by_mistake() -> None:
    assert not any(about == "loop" for about, _ in said(replace(loop(), input="goal_rad")))


def test_a_finding_says_its_log() -> None:
    assert str(Finding("a.csv", "clock", "it is late", "gaps")) == "a.csv: it is late"
    assert str(Finding("", "units", "x", "question")) == "x"


def test_every_oddity_has_a_kind_of_its_own() -> None:
    kinds = [next(one.kind for one in findings(log) if says in one.says) for log, _, says in ODD]
    assert kinds == [
        *(
            "gaps",
            "uneven",
            "drift",
            "constant",
            "one_way",
            "clipped",
            "missing",
            "outliers",
            "outliers",
            "frozen",
            "still",
        ),
        *("wrap", "wrap", "leap", "loop"),
    ]


def test_regular_gaps_are_bursts_and_told_in_one_line() -> None:
    """Five readings every 0.2 s, of which the first and the last burst are cut short; then one gap is later than the others."""
    kept = (np.arange(2000) + 3) % 20 < 5
    bursts = replace(GOOD, time=T[kept], command=U[kept], outputs={"yaw_rad": ANGLE[kept]})
    (found,) = gaps_in_time(bursts)
    assert found.kind == "bursts" and found.says.startswith(
        "recorded in bursts of 5 readings every 0.2 s: the command counts as held between them; after "
    )
    assert "split the log" not in found.says and "\n" not in found.says
    (irregular,) = gaps_in_time(replace(bursts, time=np.where(np.arange(kept.sum()) > 201, T[kept] + 0.1, T[kept])))
    assert irregular.kind == "gaps" and "gaps in time, the longest" in irregular.says
    (few,) = gaps_in_time(bursts.cut(0, 18))
    assert few.kind == "gaps" and few.says.startswith("4 gaps in time") and "after 4 of 4 the command " in few.says
    kept[1000:1008] = True
    (longer,) = gaps_in_time(replace(bursts, time=T[kept], command=U[kept], outputs={"yaw_rad": ANGLE[kept]}))
    assert longer.kind == "gaps"


@pytest.mark.parametrize(
    ("gaps", "lasts", "longest"),
    [
        (slice(1000, 1100, 20), [0.2], "5 gaps in time, the longest 0.2 s at "),
        (slice(1000, 1005), [0.2], "5 gaps in time, the longest 0.2 s at "),
        (slice(199, None, 200), [0.06, 0.2, 0.06], "9 gaps in time, the longest 0.2 s at 4.04 s: "),
    ],
)
def test_regular_gaps_in_an_even_log_are_no_bursts(gaps: slice, lasts: list[float], longest: str) -> None:
    """Far more readings lie before and after them, or between them; or one is far longer than the others."""
    step = np.full(1999, 0.01)
    step[gaps] = np.resize(lasts, len(step[gaps]))
    (found,) = gaps_in_time(replace(GOOD, time=np.append(0.0, np.cumsum(step))))
    assert found.kind == "gaps" and found.says.startswith(longest)


STEP = 2.0 * np.pi / 4096.0


def steps_of(angle: np.ndarray) -> Log:
    """A log of an angle that a sensor reads in steps and a file holds in rad."""
    return replace(GOOD, outputs={"yaw_rad": STEP * np.round(angle / STEP)}, resolution={"yaw_rad": 0.0})


def test_an_arm_that_rests_with_its_torque_off_is_no_dropout() -> None:
    comes_to_rest = np.where(T < 12.0, np.sin(T), np.sin(12.0))
    log = steps_of(comes_to_rest)
    for on, many in ((T < 11.0, 0), (T < 15.0, 1)):
        found = findings(replace(log, enabled=on.astype(float)))
        assert sum("stays the same" in str(f) for f in found) == many


def test_a_rest_between_two_motions_is_no_dropout_and_a_leap_after_equal_readings_is_one() -> None:
    rest = np.where(T < 5.0, np.sin(T), np.where(T < 8.0, np.sin(5.0), np.sin(T - 3.0)))
    assert not [f for f in findings(steps_of(rest)) if "stays the same" in str(f)]
    for motion in (np.sin(T), rest):
        lost = at(motion, slice(1200, 1260), motion[1200])
        assert [
            "stays the same for 0.59 s from 12 s on" in str(f) for f in findings(steps_of(lost)) if "stays" in str(f)
        ] == [True]


def test_an_arm_that_rests_at_the_end_of_a_run_is_no_dropout() -> None:
    comes = np.where(T < 15.0, np.sin(T), np.sin(15.0) + np.cos(15.0) * (1.0 - np.exp(15.0 - T)))
    angle = np.where(T < 18.0, comes, comes[1800])
    creeps = angle + 1e-3 * np.exp(-T)  # a goal that has settled but for less than a hundredth of its range
    for command, many in ((angle, 0), (creeps, 0), (np.sin(T), 1)):
        log = replace(steps_of(angle), command=command, input="goal_rad")
        assert sum("stays the same" in str(f) for f in findings(log)) == many
        speed = np.gradient(angle, T)
        slow = replace(log, outputs=log.outputs | {"yaw_rad_s": np.where(T < 18.0, speed, 0.0)})
        assert not any("yaw_rad stays the same" in str(f) for f in findings(slow))
    hangs = np.where(T < 18.0, np.sin(T), np.sin(18.0))
    leaps = replace(
        steps_of(at(hangs, slice(1800, 2000), 0.2)), command=np.where(T < 17.0, np.sin(T), 0.0), input="goal_rad"
    )
    assert sum("stays the same" in str(f) for f in findings(leaps)) == 1


@pytest.mark.parametrize("digits", [15, 6])
def test_a_simulation_without_noise_that_rests_is_no_dropout_and_one_that_stands_still_amid_its_motion_is(
    digits: int,
) -> None:
    begins = 0.2 * np.maximum(T - 4.0, 0.0) ** 2  # a constant torque from 4 s on
    ends = -0.2 * np.maximum(12.0 - T, 0.0) ** 2  # dry friction stops it at 12 s
    waits = np.where(T < 8.0, -0.2 * np.maximum(6.0 - T, 0.0) ** 2, 0.2 * np.maximum(T - 8.0, 0.0) ** 2)
    creeps = np.where(T < 8.0, np.sin(T), np.sin(8.0) + np.cos(8.0) * (1.0 - np.exp(8.0 * (8.0 - T))))
    lost = at(T**2, slice(900, 960), 81.0)
    noise = np.random.default_rng(1).normal(0.0, 1e-4, len(T))
    dead = at(ends + noise, slice(1300, 2000), ends[1300])
    for angle, many in ((begins, 0), (ends, 0), (waits, 0), (creeps, 0), (lost, 1), (dead, 1)):
        log = replace(GOOD, outputs={"yaw_rad": np.round(angle, digits)}, resolution={})
        assert sum("stays the same" in str(f) for f in findings(log)) == many


@pytest.mark.parametrize(
    ("away", "dropouts"),
    [
        ([1.0, 1.25, 1.5, 1.75, 2.0], 0),
        ([1.0, 1.1, 1.2, 1.3, 1.4], 1),
        ([1.0, 1.5, 2.0, 1.5, 3.0], 1),
        ([1.0, 1.5, 2.0, 2.5, -3.0], 1),
    ],
    ids=["twofold in five steps", "hardly slower", "not slower at each step", "turns back"],
)
def test_a_motion_has_come_to_rest_where_it_slows_by_half_or_more_at_each_of_five_steps(
    away: list[float], dropouts: int
) -> None:
    steps = 1e-2 * np.sin(T)
    steps[700] = 1e-6  # fine readings, so that how they end says whether it is a rest
    steps[1495:1500] = 1e-3 * np.array(away)[::-1]
    steps[1500:] = 0.0
    log = replace(GOOD, outputs={"yaw_rad": np.cumsum(steps)}, resolution={})
    assert sum("stays the same" in str(f) for f in findings(log)) == dropouts


def test_a_speed_that_is_always_0_excuses_no_dropout() -> None:
    hangs = at(np.sin(T), slice(600, 800), float(np.sin(T[600])))
    for dead in ({}, {"yaw_rad_s": np.zeros(len(T))}):
        log = replace(GOOD, outputs={"yaw_rad": hangs, **dead}, resolution={})
        assert any("yaw_rad stays the same" in str(f) for f in findings(log))


def test_readings_that_stay_the_same_and_then_end_are_no_traceback() -> None:
    ends = np.where(np.arange(len(T)) < 300, 0.1, np.nan)
    assert not any("stays the same" in says for _, says in said(of(yaw_rad=ends)))


def test_no_loop_is_seen_across_a_gap_and_one_is_seen_beside_it() -> None:
    angle = COUNT * np.round(np.cumsum(np.cumsum(4.0 * np.sign(np.sin(0.7 * T)))) * 1e-4 / COUNT)
    steps = replace(
        GOOD, command=4.0 * np.sign(np.sin(0.7 * T)), outputs={"yaw_rad": angle}, resolution={"yaw_rad": COUNT}
    )
    kept = np.delete(np.arange(2000), slice(400, 500))  # in which the command changes
    for log, loops in ((steps, 0), (loop(), 1)):
        gap = replace(log, time=T[kept], command=log.command[kept], outputs={"yaw_rad": log.outputs["yaw_rad"][kept]})
        assert [about for about, _ in said(gap)] == ["clock"] + loops * ["loop"]


def test_a_loop_is_seen_beside_missing_readings() -> None:
    closed = loop()
    holey = replace(closed, outputs={"yaw_rad": at(closed.outputs["yaw_rad"], slice(400, 450), np.nan)})
    assert {about for about, _ in said(holey)} == {"readings", "loop"}


def test_a_turn_in_a_gap_is_no_wrapped_angle() -> None:
    angle = np.where(T > 7.0, ANGLE + 2.0 * np.pi, ANGLE)
    assert any("it wraps" in says for _, says in said(of(yaw_rad=angle)))
    later = np.where(T > 7.0, T + 3.0, T)
    assert not any("it wraps" in says for _, says in said(replace(of(yaw_rad=angle), time=later)))
    holey = of(yaw_rad=at(angle, slice(680, 701), np.nan))
    assert not any("it wraps" in says for _, says in said(holey))


def test_a_drop_out_is_named_and_is_nothing_else_besides() -> None:
    counts = COUNT * np.round((6.0 + 3.0 * np.sin(0.8 * T)) / COUNT)
    log = replace(GOOD, outputs={"yaw_rad": at(counts, slice(300, 400), 0.0)}, resolution={"yaw_rad": COUNT})
    (found,) = findings(log)
    assert found.about == "readings" and "yaw_rad is exactly 0 counts from 3 to 3.99 s, and jumps there" in found.says


@pytest.mark.parametrize(
    ("command", "rows", "told"),
    [
        (U, [700, 900, 901, 1400], True),
        (np.sign(U), [700, 900, 1400], False),
        (U, [*range(0, 2000, 3)], False),
        (U, [], False),
    ],
    ids=["a command that changes", "one that is held", "another rate", "none"],
)
def test_rows_that_are_lost_while_the_command_changes_are_told(
    command: np.ndarray, rows: list[int], told: bool
) -> None:
    kept = np.delete(np.arange(2000), rows)
    outputs = {name: y[kept] for name, y in GOOD.outputs.items()}
    log = replace(GOOD, time=T[kept], command=command[kept], outputs=outputs)
    expected = (
        "4 rows are missing, the first after 6.99 s: the command changes at most samples, and counts as held there; "
    )
    found = [finding for finding in findings(log) if "missing" in finding.says]
    assert [finding.says[: len(expected)] for finding in found] == told * [expected] and missing_rows(log) == found


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_log_of_no_interval_misses_no_rows(count: int) -> None:
    outputs = {name: y[:count] for name, y in GOOD.outputs.items()}
    assert missing_rows(replace(GOOD, time=T[:count], command=U[:count], outputs=outputs)) == []


def test_a_gap_is_five_intervals_and_a_drift_needs_a_run() -> None:
    for seconds, gaps in ((0.03, 0), (0.1, 1)):
        late = replace(GOOD, time=np.where(np.arange(2000) > 700, T + seconds, T))
        assert sum("gap in time" in says for _, says in said(late)) == gaps
    for count, drifts in ((60, 0), (400, 1)):  # a quarter of 60 samples is too few for the mean interval
        t = T[:count] + 0.02 * T[:count] ** 2 / T[count]
        short = replace(GOOD.cut(0, count), time=t)
        assert sum("does the clock drift?" in says for _, says in said(short)) == drifts


def test_a_wheel_that_turns_as_fast_as_a_wrap_leaps_wraps_nothing() -> None:
    speeds_up = 0.5 * 330.0 * T[:400] ** 2  # up to 13 rad from sample to sample
    log = replace(GOOD.cut(0, 400), outputs={"wheel_rad": speeds_up}, resolution={})
    assert not any("it wraps" in says for _, says in said(log))


def test_chance_is_no_loop_nor_is_a_rate_that_moves_with_its_command() -> None:
    asked = 0
    for seed in range(300):
        rng = np.random.default_rng(seed)
        few = replace(GOOD.cut(0, 125), command=rng.normal(size=125), outputs={"yaw_rad": rng.normal(size=125)})
        asked += any(about == "loop" for about, _ in said(few))
    assert asked <= 3  # four lags, each beyond 4 standard deviations
    u = np.random.default_rng(0).normal(size=2000)
    moved = replace(GOOD, command=u, outputs={"yaw_rad_s": 0.01 * np.cumsum(u)}, resolution={})
    assert not [says for about, says in said(moved) if about == "loop"]


def test_a_sensor_that_often_gives_a_reading_again_is_not_frozen_by_three_times_as_many() -> None:
    again = np.resize([4, 1, 1, 1], 1200)
    again[400] = 12
    readings = np.repeat(np.random.default_rng(4).normal(size=1200), again)[:2000]
    log = replace(GOOD, outputs={"yaw_rad": readings}, resolution={})
    assert not any("stays the same" in says for _, says in said(log))
    again[400] = 30
    readings = np.repeat(np.random.default_rng(4).normal(size=1200), again)[:2000]
    found = said(replace(log, outputs={"yaw_rad": readings}))
    assert sum("stays the same" in says for _, says in found) == 1


def test_a_reading_in_a_hundred_may_be_missing_without_a_word() -> None:
    for count, many in ((20, 0), (21, 1)):
        lost = of(yaw_rad=at(ANGLE, slice(100, 100 + count), np.nan))
        assert sum("readings are missing" in says for _, says in said(lost)) == many


def without_rows(command: np.ndarray, rows: slice | list[int], name: str = "run") -> Log:
    """A log that lacks rows, as where a serial link dropped them."""
    kept = np.delete(np.arange(2000), rows)
    outputs = {output: y[kept] for output, y in GOOD.outputs.items()}
    return replace(GOOD, name=name, time=T[kept], command=command[kept], outputs=outputs)


def test_many_missing_rows_are_a_note_beside_a_result_whatever_the_command_did() -> None:
    square = np.where(T < 7.2, 4.0, -4.0)
    flips, held = without_rows(square, slice(700, 750)), without_rows(square, slice(1000, 1050))
    (note,) = holes([flips])
    assert note.startswith("run: 1 gap in time, the longest 0.51 s at 6.99 s: the command counts as held there; ")
    assert "after it the command is another one, and when it changed is not known" in note
    assert "whether it changed and came back is not known" in holes([held])[0]
    assert [finding.says for finding in gaps_in_time(flips)] == [one for _, one in said(flips) if "gap" in one]
    assert holes([GOOD]) == [] == gaps_in_time(GOOD)


def test_a_log_that_lacks_rows_has_one_note_and_many_such_logs_have_one_together() -> None:
    few = without_rows(U, [300, *range(700, 750)])
    (said_of_one,) = holes([GOOD, few])
    assert "1 row is missing, the first after 2.99 s" in said_of_one and "1 gap in time" in said_of_one
    logs = [replace(few, name=f"{k}.csv") for k in range(MOST_NOTED + 1)]
    assert len(holes(logs[:-1])) == MOST_NOTED
    assert holes([replace(few, name="")]) == [said_of_one.removeprefix("run: ")]
    (said_of_all,) = holes([GOOD, *logs])
    assert said_of_all.startswith("4 of 5 logs lack rows, 0.csv first: ") and "`rwjax check` says where" in said_of_all


def test_a_log_that_begins_with_a_step_from_rest_is_told_how_to_say_so() -> None:
    turns = 40.0 * (1.0 - np.exp(-3.0 * T)) + 0.01 * np.random.default_rng(5).normal(size=2000)
    angle = 40.0 * (T + np.exp(-3.0 * T) / 3.0)
    step = np.where(T < 10.0, 6.0, 5.0)

    def begins(command: np.ndarray, **outputs: np.ndarray) -> bool:
        log = replace(GOOD, command=command, outputs=outputs, resolution=dict.fromkeys(outputs, 0.0))
        return any("begins at rest" in says and "write a row with 0" in says for _, says in said(log))

    assert begins(step, yaw_rad_s=turns) and begins(-step, yaw_rad=-angle)
    assert not begins(step, yaw_rad_s=turns + 20.0)  # it turned before
    assert not begins(np.where(T > 0.0, step, 0.0), yaw_rad_s=turns)  # the log tells the step
    assert not begins(step, yaw_rad_s=np.roll(turns, 500) * (T > 5.0))  # friction holds it
    assert not begins(np.where(T > 0.0, step, 0.5), yaw_rad_s=turns)  # hardly a command
    log = replace(GOOD, command=step, outputs={"yaw_rad_s": turns}, resolution={"yaw_rad_s": 0.0})
    for other in (replace(log, input="goal_rad"), replace(log, enabled=T > 0.0)):
        assert not any("begins at rest" in says for _, says in said(other))


@pytest.mark.parametrize("count", [COUNT, 0.0])
def test_a_freeze_that_ends_as_the_command_changes_is_told_and_is_no_loop(count: float) -> None:
    command = 4.0 * np.sign(np.sin(0.7 * T))
    angle = np.cumsum(np.cumsum(command)) * 1e-4
    angle = count * np.round(angle / count) if count else angle
    ends = int(np.flatnonzero(np.diff(command))[2])
    log = replace(
        GOOD,
        command=command,
        outputs={"yaw_rad": at(angle, slice(ends - 300, ends), float(angle[ends - 300]))},
        resolution={"yaw_rad": count},
    )
    found = said(log)
    changes = replace(log, command=command + 0.5 * np.sin(5.0 * T))
    assert not [says for about, says in [*found, *said(changes)] if about == "loop"]
    (told,) = [says for about, says in said(changes) if about == "readings"]
    stays = f"yaw_rad stands still from {T[ends - 300]:.6g} to {T[ends - 1]:.6g} s while the command changes, then jumps by "
    assert told.startswith(stays if count else "yaw_rad stays the same for 2.99 s")
