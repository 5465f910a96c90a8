"""Races, the yardstick and what a benchmark makes of its figures, against what was worked out by hand."""

import json
import subprocess
import sys
import time
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.speed import causes, free_runs, lowering, same_bytes, shared, table
from experiments.speed.problem import log, posed, with_effects
from rwjax.fitting.batched_runs import BATCH
from rwjax.simulation.free_run import free_run


def test_rounds_are_interleaved_and_a_slow_contender_leaves_after_the_first_ones() -> None:
    heard: list[str] = []
    calls = {name: lambda name=name: heard.append(name) or name for name in ("a", "slow", "b")}
    raced = table.race(calls, rounds=5, slow=("slow",), repeats=2)
    whole, short = [*"aa", "slow", *"bb"], [*"aabb"]
    assert heard == [*"ab", *whole * table.OF_SLOW, *short * (5 - table.OF_SLOW)]
    assert {name: len(times) for name, times in raced.times.items()} == {"a": 5, "slow": table.OF_SLOW, "b": 5}
    assert raced.results == {name: name for name in calls}


def test_the_ratio_is_the_median_of_those_of_each_round() -> None:
    raced = table.Raced({"a": [1.0, 6.0, 30.0], "b": [1.0, 2.0, 10.0]}, {})
    assert raced.ratio("a", "b") == 3.0  # of 1, 3 and 3; the ratio of the medians is 3 too, that of the means 37/13
    assert raced.ratio("b", "a") == pytest.approx(1.0 / 3.0)
    assert raced.median("a") == 6.0


def test_the_yardstick_is_called_with_the_same_arguments() -> None:
    assert lowering.by_xla(divmod)(7, 3) == (2, 1)


@pytest.mark.slow
def test_a_batch_of_free_runs_is_the_runs_one_by_one() -> None:
    added = free_runs.FRICTIONS["Stribeck friction"]
    problem, theta = free_runs.lanes(3.0, added)
    together = free_runs.batched(problem, theta)()
    alone, moves, _ = posed(log(3.0), with_effects(*added)[0])
    assert np.ptp(theta[:, moves.index], axis=0).min() > 0.0
    for lane in (0, len(theta) - 1):
        y, _ = free_run(alone.structure, theta[lane], alone.start, alone.batch)
        assert together[lane] == pytest.approx(np.asarray(y)[0, : together.shape[1]], abs=1e-12)  # rad, rounding


def test_the_shared_program_is_timed_on_the_runs_of_a_rig_s_own() -> None:
    problem, runs = shared.calls("wheel, Coulomb friction")
    assert {shared.OWN, shared.SHARED} < {*runs} and not {*runs} & {*problem.structure.effects}
    own = runs[shared.OWN]()
    assert len(own) == BATCH and own.std() > 0.0
    assert runs[shared.SHARED]() == pytest.approx(own, rel=1e-9, abs=1e-12)


def test_a_minute_is_twelve_thousand_steps() -> None:
    problem, _ = free_runs.lanes(60.0, ())
    assert int(problem.batch.windows_of[0]) * len(problem.batch.step_index) == 12_000


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the figure is exact where the system keeps it")
def test_memory_is_the_process_s_own_and_not_its_parent_s(tmp_path: Path) -> None:
    (tmp_path / "held.py").write_text("import sys; held = bytearray(int(sys.argv[1]) << 20); del held")
    own = np.ones(400 << 17)  # 400 MiB that the child must not count
    found = []
    for size in (0, 100):
        command = [sys.executable, "-m", "experiments.speed.peak", str(tmp_path / "note"), "held", str(size)]
        paths = {"PYTHONPATH": f"{Path(__file__).parents[2]}:{tmp_path}"}
        subprocess.run(command, check=True, env=paths, cwd=tmp_path)
        found.append(float((tmp_path / "note").read_text()))
    assert found[0] < own.nbytes / 2**20 / 4.0
    assert found[1] - found[0] == pytest.approx(100.0, abs=5.0)  # MiB


def test_the_interval_of_a_median_of_twenty_is_that_of_the_sign_test() -> None:
    values = np.random.default_rng(0).permutation(np.arange(1.0, 21.0))
    assert causes.quantile(values, 0.5) == (
        10.0,
        6.0,
        15.0,
    )  # order statistics 6 and 15, as in the tables of the sign test


def test_the_interval_of_a_high_quantile_of_few_is_open() -> None:
    # with 40 values the largest is below the quantile with probability 0.95**40 = 0.129, so no interval can end there
    middle, low, high = causes.quantile(np.arange(1.0, 41.0), 0.95)
    assert (middle, high) == (38.0, np.inf)
    assert low < middle


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_intervals_hold_the_quantile_as_often_as_they_say(share: float) -> None:
    rng, true, draws = np.random.default_rng(1), -np.log(1.0 - share), 4000
    held = sum(
        low <= true <= high for _, low, high in (causes.quantile(rng.exponential(size=40), share) for _ in range(draws))
    )
    spread = 3.0 * np.sqrt(0.95 * 0.05 * draws)
    assert held >= 0.95 * draws - spread


def rows(count: int) -> list[dict]:
    """Cases of all groups, of each the same number."""
    groups = ("single", "pair", "outside")
    return [
        {"index": 3 * k + j, "group": group, "kind": "wheel", "effect": "x"}
        for k in range(count)
        for j, group in enumerate(groups)
    ]


def test_fewer_cases_are_the_first_of_more_and_half_of_each_group() -> None:
    more = causes.chosen(rows(50), 40)
    assert causes.chosen(rows(50), 7) == more[:7]
    assert [row["group"] for row in more] == ["pair", "outside"] * 20
    assert len({row["index"] for row in more}) == 40


def test_times_go_on_where_they_stopped_and_are_those_of_the_second_diagnosis(tmp_path: Path) -> None:
    asked: list[int] = []

    def work(row: dict, within: AbstractContextManager) -> dict:
        asked.append(row["index"])
        return row | {"seconds": float(asked.count(row["index"]))}

    path = tmp_path / "causes.jsonl"
    causes.run(rows(3)[:2], path, None, work)
    causes.run(rows(3)[:4], path, None, work)
    assert asked == [0, 0, 1, 1, 2, 2, 3, 3]
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert [(line["index"], line["first"], line["seconds"]) for line in lines] == [(k, 1.0, 2.0) for k in range(4)]


def test_a_diagnosis_that_takes_too_long_is_broken_off_and_counts_as_longer_than_all(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def work(row: dict, within: AbstractContextManager) -> dict:
        try:
            with within:
                time.sleep(row["sleeps"])
        except causes.OutOfTime as error:
            return row | {"seconds": 0.3, "error": f"{type(error).__name__}: {error}"}
        return row | {"seconds": row["sleeps"]}

    cases = [{"index": k, "group": "pair", "sleeps": s} for k, s in enumerate((30.0, 0.0, 0.01))]  # s
    begin = time.monotonic()
    lines = [causes.diagnosed(row, 0.3, work) for row in cases]
    assert time.monotonic() - begin < 20.0
    assert causes.times(lines).tolist() == [np.inf, 0.0, 0.01]
    causes.report(lines)
    assert "| two causes | 3 | 0.0 | 0.0 (0.0 to ∞) | over 0.3 (0.0 to ∞) | 1 | 0 |" in capsys.readouterr().out


def test_only_times_of_the_work_may_differ() -> None:
    one = b'{\n "seconds": 12.5,\n "search_seconds": 1e-3,\n "from_s": 3.1,\n "verdict": "none"\n}\n'
    other = one.replace(b"12.5", b"9").replace(b"1e-3", b"2.25")
    assert same_bytes.first_difference(one, other) == ""
    assert same_bytes.first_difference(one, other.replace(b"3.1", b"3.2")) == 'line 4: "from_s": 3.1, | "from_s": 3.2,'
    assert same_bytes.first_difference(one, one + b"\n") != ""
    assert same_bytes.first_difference(one, one.rstrip()) != ""
