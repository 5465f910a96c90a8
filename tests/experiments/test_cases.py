"""Labelled cases of the separate simulator: every effect in every kind of rig, amplitudes, labels, the oracle."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

import experiments.blind
from experiments.blind.cases import KINDS, amplitude_for, kinds_of, make_case, prepare, settled, write_case
from experiments.blind.draws import EFFECTS, put
from experiments.blind.oracle import at_rest, by_rule, judge, parse, refit, rests
from experiments.blind.outside import OUTSIDE
from experiments.blind.rigs import FIELD
from experiments.blind.sensors import readings
from experiments.blind.simulator import STEP
from experiments.blind.truth import PSI, Truth
from rwjax import read_logs, read_rig

WRONG = tuple(f"parameter.{name}" for name in FIELD)
EVERY = (*EFFECTS, *OUTSIDE, *WRONG)
FIRST = {name.partition(".")[0]: name for name in reversed(EVERY)}.values()
"""Of each subsystem, of the causes outside the list and of the wrong numbers."""


def of_kind(kind: str, names: tuple[str, ...] = EVERY) -> list[str]:
    return [name for name in names if kind in kinds_of(name)]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_effect_makes_a_case_that_shows_it(kind: str) -> None:
    sizes = {}
    for name in of_kind(kind):
        case = make_case(kind, name, 0)
        assert not any("nan" in text or "inf" in text for text in case.logs.values()), name
        assert 4 <= len(case.logs) <= 6
        assert case.truth["effects"] + case.truth["outside"] == [name]
        sizes[name] = case.truth["raw_size"]
    hidden = {name: size for name, size in sizes.items() if size <= 3.0}
    assert len(hidden) <= 0.15 * len(sizes), hidden
    assert all(size > 0.3 for size in sizes.values()), hidden


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_half_the_step_changes_less_than_the_noise(kind: str) -> None:
    for name in of_kind(kind, (*EFFECTS, *OUTSIDE)):
        if name == "wheel.cogging":  # which detent a wheel falls into depends on everything
            continue
        case = prepare(kind, name, 1)
        truth = put(case.rig.truth, case.numbers[name], 1.0)
        record = next(record for file, (record, _) in case.runs.items() if not file.startswith("mixed"))
        record = replace(record, start=settled(truth, record.start))
        whole, half = (readings(truth, record, case.scene.floor, step) for step in (STEP, 0.5 * STEP))
        for column, noise in case.scene.floor.items():
            assert np.sqrt(np.mean((whole[column] - half[column]) ** 2)) < 0.3 * noise, (name, column)


@pytest.mark.parametrize(
    "name", [name if name in FIRST else pytest.param(name, marks=pytest.mark.slow) for name in EVERY]
)
def test_without_amplitude_there_is_no_effect(name: str) -> None:
    kind = kinds_of(name)[0]
    case = make_case(kind, name, 2, amplitude=0.0)
    assert case.truth["raw_size"] == 0.0
    assert case.truth["verdict"] == "none"
    assert case.truth["effects"] == case.truth["outside"] == []


@pytest.mark.parametrize("name", ["axis.end_stop", "axis.flexible_coupling", "drive.rate_limit", "sensor.scale"])
def test_the_amplitude_scales_the_effect_and_nothing_else(name: str) -> None:
    small, large = (make_case("platform", name, 3, a) for a in (0.2, 1.0))
    assert small.truth["raw_size"] < large.truth["raw_size"]
    assert list(small.logs) == list(large.logs)
    for one, other in zip(small.logs.values(), large.logs.values(), strict=True):
        inputs = [[line.split(",")[:2] for line in text.splitlines()] for text in (one, other)]
        assert inputs[0] == inputs[1]
    if name != "sensor.scale":
        assert small.rig == large.rig


@pytest.mark.slow
def test_an_amplitude_is_found_for_a_size() -> None:
    amplitude = amplitude_for(10.0, "wheel", "drive.delay", 0)
    assert make_case("wheel", "drive.delay", 0, amplitude).truth["raw_size"] == pytest.approx(10.0, rel=0.02)


@pytest.mark.parametrize("kind", [KINDS[0], *(pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS[1:])])
def test_a_case_is_reproducible_and_has_runs_to_fit_and_to_judge(kind: str) -> None:
    marks = []
    for seed in range(6):
        case = make_case(kind, "drive.delay", seed)
        marks.append(sum(text.startswith("# role: validate") for text in case.logs.values()))
        assert 4 <= len(case.logs) <= 6
    assert case == make_case(kind, "drive.delay", 5)
    assert set(marks) <= {0, 1, 2}
    assert max(marks) > 0


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *(("wheel", e) for e in (None, "sensor.eccentricity", "parameter.motor.resistance", "outside.gain_hysteresis")),
        *(("platform", e) for e in ("axis.viscous", "sensor.scale", "axis.stribeck+drive.delay")),
        *(("reaction", e) for e in ("axis.coulomb", "parameter.axis.gravity.angle", "motor.heating")),
    ],
)
def test_the_files_are_what_the_library_reads(kind: str, name: str | None, seed: int, tmp_path: Path) -> None:
    case = make_case(kind, name, seed)
    write_case(case, tmp_path)
    rig = read_rig(tmp_path / "rig.toml")
    logs = read_logs(sorted(tmp_path.glob("*.csv")), rig)
    assert set(case.truth["true_numbers"]) == set(rig.free)
    assert len(logs) == len(case.logs)


def test_labels_say_what_the_answer_is() -> None:
    assert make_case("platform", None, 0).truth["verdict"] == "none"
    pair = make_case("platform", "axis.stribeck+drive.delay", 0).truth
    assert (pair["verdict"], pair["effects"]) == ("effect", ["axis.stribeck", "drive.delay"])
    assert pair["changed"]["drive.delay"]["delay"] == pair["parameters"]["delay"] > 0.0
    odd = make_case("wheel", "outside.torque_bursts", 0).truth
    assert (odd["verdict"], odd["effects"], odd["outside"]) == ("unknown", [], ["outside.torque_bursts"])
    assert make_case("platform", "drive.delay", 0).truth["same_as"] == {"drive.delay": ["sensor.delay"]}
    wrong = make_case("reaction", "parameter.wheel.inertia", 0).truth
    assert wrong["wrong_numbers"]["wheel.inertia"] != wrong["parameters"]["J"]


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(ValueError, match="no sense in a rig of kind wheel"):
        make_case("wheel", "axis.stribeck", 0)
    with pytest.raises(ValueError, match="no such effect"):
        make_case("wheel", "axis.magic", 0)
    with pytest.raises(ValueError, match="no such number"):
        make_case("wheel", "parameter.magic", 0)


@pytest.mark.slow
def test_the_oracle_closes_the_gap_with_the_truth_and_not_with_another_effect() -> None:
    case = make_case("reaction", "drive.delay", 1)
    found = judge(case)
    assert found["size"] > 10.0
    assert found["left"] < 1.0
    assert found["misfit_with"] == pytest.approx(1.0, abs=0.1)
    assert found["relative_error"]["delay"] < 0.01
    assert found["repeatable"] < 0.1
    assert refit(case, "drive.bias").misfit > 3.0 * found["misfit_with"]


@pytest.mark.slow
def test_a_scaled_encoder_does_not_shift_where_the_oracle_starts() -> None:
    case = make_case("platform", "sensor.scale", 3, 4.0, raw=False)
    truth = Truth(**case.truth["parameters"])
    assert abs(truth.scale) > 0.1
    for run, start in zip(
        parse(case, prepare("platform", "sensor.scale", 3)), case.truth["starts"].values(), strict=True
    ):
        assert at_rest(truth, run, STEP)[PSI] == pytest.approx(start[PSI], abs=2e-3)


def test_the_start_rule_takes_rest_as_it_is_and_motion_from_the_first_half_second() -> None:
    case = make_case("platform", "none", 1, raw=False)
    truth = Truth(**case.truth["parameters"])
    (run, *_) = parse(case, prepare("platform", "none", 1))
    assert rests(run) and np.array_equal(by_rule(truth, run, STEP), at_rest(truth, run, STEP))
    time, w = run.record.time - run.record.time[0], 0.4
    free = replace(truth, coulomb=0.0, excess=0.0, viscous=0.0, gravity=0.0)
    angle = {name: 0.2 + w * time for name in run.read if name in ("yaw_rad", "yaw_counts")}
    rate = {name: np.full_like(time, w) for name in run.read if name == "yaw_rad_s"}
    moving = replace(run, read=angle | rate)
    assert not rests(moving)
    assert by_rule(free, moving, STEP)[:2] == pytest.approx([0.2, w], abs=1e-6)


def test_the_simulator_shares_no_code_with_the_library() -> None:
    for path in Path(experiments.blind.__file__).parent.glob("*.py"):
        if path.name not in ("campaign.py", "score.py", "calibrate.py"):  # that put the library to the test
            assert "import rwjax" not in path.read_text() and "from rwjax" not in path.read_text(), path
