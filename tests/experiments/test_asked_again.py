"""The same question written down otherwise: what is read is the same, and what counts as the same answer."""

from pathlib import Path

import numpy as np
import pytest
import tomlkit

from experiments.asked_again.otherwise import FACTOR, LATER, WAYS, Question, Written, read_question, write_question
from experiments.asked_again.run import alike
from experiments.blind.cases import make_case, write_case
from rwjax import read_logs, read_rig
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

SIGN = {"counted the other way round": -1.0}


def readings(question: Question, folder: Path) -> tuple[Rig, list[Log]]:
    folder.mkdir()
    rig_file, paths = write_question(question, folder)
    rig = read_rig(rig_file)
    return rig, read_logs(paths, rig)


@pytest.fixture(scope="module")
def question(tmp_path_factory: pytest.TempPathFactory) -> Question:
    folder = tmp_path_factory.mktemp("case")
    write_case(make_case("reaction", "axis.coulomb", 4, 1.0, raw=False), folder)
    return read_question(folder / "rig.toml", sorted(folder.glob("*.csv")))


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_every_way_says_the_same(way: str, question: Question, tmp_path: Path) -> None:
    rig, logs = readings(question, tmp_path / "as it is")
    other_rig, others = readings(WAYS[way](question), tmp_path / "otherwise")
    if way == "logs in reverse order":
        others = others[::-1]
    sign = SIGN.get(way, 1.0)
    assert len({log.validate for log in logs}) == 2 and len(others) == len(logs)
    for log, other in zip(logs, others, strict=True):
        assert other.validate == log.validate
        assert np.allclose(other.time - other.time[0], log.time - log.time[0], atol=1e-9)
        assert np.allclose(other.command, sign * log.command) and {*other.outputs} == {*log.outputs}
        for name, values in log.outputs.items():
            assert np.allclose(other.outputs[name], sign * values, atol=1e-9, equal_nan=True), name
    held = {name: value for name, value in rig.numbers.items() if name not in rig.free}
    assert {name: other_rig.numbers[name] for name in held} == held and other_rig.free == rig.free
    guesses = [abs(other_rig.numbers[name] / rig.numbers[name]) for name in rig.free]
    assert all(1.0 / FACTOR <= g <= FACTOR for g in guesses) and (guesses != [1.0] * len(guesses)) == ("guesses" in way)


def test_an_angle_and_its_rate_are_each_in_their_own_unit() -> None:
    values = np.array([[0.5, 1.0, np.pi, 2.0 * np.pi]])
    log = Written([], ["time_s", "voltage_V", "yaw_rad", "yaw_rad_s"], values)
    other = WAYS["other units"](Question(tomlkit.document(), {"run.csv": log})).logs["run.csv"]
    assert other.values[0] == pytest.approx([500.0, 1.0, 180.0, 360.0])


@pytest.mark.slow
def test_a_way_that_changes_something_is_not_asked_for_nothing(question: Question) -> None:
    assert all(log.values[0, 0] == LATER for log in WAYS["a clock started earlier"](question).logs.values())
    for log in WAYS["other units"](question).logs.values():
        assert "my time_s" in log.columns
    counted = [log for log in question.logs.values() if "yaw_counts" in log.columns]
    finer = WAYS["twice the counts"](question)
    assert counted and finer.rig["encoder"]["counts_per_rev"] == 2 * question.rig["encoder"]["counts_per_rev"]


def test_what_counts_as_the_same_answer() -> None:
    one = {"verdict": "ambiguous", "effects": ["a", "b"], "alternatives": [["c"]]}
    assert alike(one, one | {"effects": ["c"], "alternatives": [["b", "a"]]})
    assert not alike(one, one | {"alternatives": []}) and not alike(one, one | {"verdict": "effect"})
    assert alike({**one, "verdict": "unknown"}, {"verdict": "unknown", "effects": [], "alternatives": []})
