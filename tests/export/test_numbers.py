"""A rig as JSON."""

import json
from dataclasses import replace
from math import inf
from pathlib import Path

import pytest

from rwjax import InputError
from rwjax.export.numbers import numbers
from tests.systems import platform


def test_every_number_stands_there_with_its_unit_and_its_standard_error() -> None:
    rig = replace(
        platform("viscous = 0.02"),
        effects={"axis.coulomb": {"M_c": 0.03}},
        standard_error={"axis.inertia": 0.001, "axis.coulomb.M_c": inf},
    )
    found = json.loads(numbers(rig).text)
    assert found["numbers"]["axis.inertia"] == {"value": 0.1, "unit": "kg m2", "standard_error": 0.001}
    assert found["numbers"]["drive.gain"] == {"value": 0.4, "unit": "N m/V"}
    assert found["effects"]["axis.coulomb"]["numbers"]["M_c"] == {"value": 0.03, "unit": "N m", "standard_error": None}
    assert found["effects"]["axis.coulomb"]["equation"] == "M_c sgn w" and found["kind"] == "platform"


def answer_of(folder: Path, **besides: object) -> Path:
    """What `rwjax fit --json` prints of a platform, or a diagnosis with more."""
    found = {
        "rig": platform("viscous = 0.02").name,
        "numbers": {"axis.inertia": {"value": 0.11}},
        "covariance_of": ["axis.inertia"],
        "covariance": [[1e-6]],
    }
    (folder / "answer.json").write_text(json.dumps(found | besides))
    return folder / "answer.json"


def test_with_an_answer_come_its_covariance_and_the_torque_that_is_left(tmp_path: Path) -> None:
    rig, left = platform("viscous = 0.02"), {"rms_Nm": 0.01, "correlation_time_s": 0.2, "spectrum": []}
    found = json.loads(numbers(rig, answer_of(tmp_path, left_torque=left)).text)["estimate"]
    assert found == {"names": ["axis.inertia"], "mean": [0.11], "covariance": [[1e-6]], "left_torque": left}
    assert json.loads(numbers(rig, answer_of(tmp_path)).text)["estimate"]["left_torque"] is None
    assert "estimate" not in json.loads(numbers(rig).text)


def test_an_answer_of_another_rig_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"answer\.json: is a fit of rig `another`"):
        numbers(platform("viscous = 0.02"), answer_of(tmp_path, rig="another"))


def test_an_answer_with_numbers_that_the_rig_lacks_is_refused(tmp_path: Path) -> None:
    more = {"numbers": {"axis.coulomb.M_c": {"value": 0.1}}, "covariance_of": ["axis.coulomb.M_c"]}
    with pytest.raises(InputError, match=r"`axis\.coulomb\.M_c`, which this rig lacks"):
        numbers(platform("viscous = 0.02"), answer_of(tmp_path, **more))


@pytest.mark.parametrize("wrong", ["NaN", "Infinity"])
def test_an_answer_that_is_not_finite_is_refused(wrong: str, tmp_path: Path) -> None:
    path = answer_of(tmp_path)
    path.write_text(path.read_text().replace("1e-06", wrong))
    with pytest.raises(InputError, match="not finite"):
        numbers(platform("viscous = 0.02"), path)
