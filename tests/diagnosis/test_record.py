"""A diagnosis in a file: what comes back is what was written, but for the draws."""

from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rwjax import InputError, read_diagnosis
from rwjax.diagnosis.localise.left_torque import LeftTorque
from rwjax.diagnosis.record import RECORD, record
from rwjax.diagnosis.result import Left
from rwjax.planning.experiment import Experiment
from rwjax.planning.files import Plan, Run
from tests.diagnosis.test_result import DIAGNOSIS
from tests.report.diagnosed import diagnosed

RUN = Run(
    "go", Experiment("sine", 3.0, 0.0, 1.0, 10.0), "train", "why", ("axis.spring",), {"yaw_rad": 1.0}, (-1.0, 1.0)
)
FULL = {
    "left": Left(0.1, None, ()),
    "left_torque": LeftTorque(0.02, None, np.array([0.0, 2.0]), np.array([1e-4])),
    "proposal": Plan("bench", {"voltage_V": 6.0}, (RUN,)),
}
DRAWS = {"own", "still", "speed"}


def same(a: Any, b: Any) -> bool:
    """Whether two values are of the same types and equal to the last bit, NaN included, draws apart."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a) if f.name not in DRAWS)
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[k], b[k]) for k in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return a == b or (a != a and b != b)


@pytest.mark.parametrize("d", [DIAGNOSIS, diagnosed(), diagnosed(**FULL)], ids=["plain", "drawn", "full"])
def test_a_diagnosis_comes_back_as_it_was(d: Any, tmp_path: Path) -> None:
    (tmp_path / RECORD).write_bytes(record(d))
    back = read_diagnosis(tmp_path)
    assert same(d, back)
    assert str(back) == str(d) and back.json() == d.json()


def test_the_same_diagnosis_gives_the_same_bytes() -> None:
    assert record(diagnosed()) == record(diagnosed())


def test_a_folder_without_one_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"diagnosis\.npz: cannot be read: No such file.*give the folder of a diagnosis"
    ):
        read_diagnosis(tmp_path)


@pytest.mark.parametrize("cut", [0, 10, 500, -200, -1])
def test_a_file_cut_short_is_refused_in_one_line(cut: int, tmp_path: Path) -> None:
    (tmp_path / RECORD).write_bytes(record(diagnosed())[:cut])
    with pytest.raises(InputError, match=r"is no whole diagnosis of this version; `rwjax diagnose` writes it anew$"):
        read_diagnosis(tmp_path)


def test_a_damaged_file_is_refused_or_read_and_nothing_else(tmp_path: Path) -> None:
    whole, rng = record(diagnosed()), np.random.default_rng(0)
    for _ in range(80):
        data = bytearray(whole)
        for at in rng.integers(len(data), size=3):
            data[at] ^= 1 << int(rng.integers(8))
        (tmp_path / RECORD).write_bytes(data)
        try:
            read_diagnosis(tmp_path)
        except InputError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize(
    "tree",
    ['["rwjax.record/0", {}]', '["rwjax.record/1", {"rig": 3}]', "[]", "{", "[" * 100_000, '["rwjax.record/1", []]'],
)
def test_what_is_no_diagnosis_of_this_version_is_refused(tree: str, tmp_path: Path) -> None:
    np.savez(tmp_path / RECORD, tree=np.frombuffer(tree.encode(), np.uint8))
    with pytest.raises(
        InputError, match=r"diagnosis\.npz: is (of layout rwjax\.record/0|no whole).*`rwjax diagnose` writes it anew$"
    ):
        read_diagnosis(tmp_path)


def test_objects_that_would_run_when_read_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / RECORD, tree=np.array([print], object))
    with pytest.raises(InputError, match="is no whole diagnosis"):
        read_diagnosis(tmp_path)
