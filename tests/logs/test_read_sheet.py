"""Files of every form: the same measurements give the same log to the last bit, and what is no table is refused in one line."""

import gzip
import io
import re
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from rwjax.errors import LogError
from rwjax.logs.log import Log
from rwjax.logs.read import read_log
from rwjax.logs.read_sheet import read_sheet
from rwjax.rig.read import parse_rig
from rwjax.rig.write import write_rig
from tests.logs.forms import FORMS, MEASURED, RIG, SI
from tests.logs.texts import HEADER, PLATFORM, ROWS


def bits(log: Log) -> list[bytes]:
    return [log.time.tobytes(), log.command.tobytes(), *(log.outputs[name].tobytes() for name in sorted(log.outputs))]


@pytest.mark.parametrize("name", FORMS)
def test_every_form_of_the_same_measurements_is_the_same_log(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(FORMS[name])
    log = read_log(tmp_path / name, RIG)
    assert bits(log) == bits(Log.from_arrays(RIG, time=SI["time_s"], **{n: v for n, v in SI.items() if n != "time_s"}))
    assert log.name == name and log.origin == 0.0


def test_a_column_of_a_structure_goes_by_either_name(tmp_path: Path) -> None:
    (tmp_path / "run.mat").write_bytes(FORMS["struct.mat"])
    assert {*read_sheet(tmp_path / "run.mat").names} == {*MEASURED, *(f"data.{name}" for name in MEASURED)}


def archive(**files: bytes) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as packed:
        for name, content in files.items():
            packed.writestr(name, content)
    return file.getvalue()


def objects() -> bytes:
    file = io.BytesIO()
    np.savez(file, x=np.array([{}], dtype=object))
    return file.getvalue()


def scalars() -> bytes:
    file = io.BytesIO()
    savemat(file, {"Ts": 0.01})
    return file.getvalue()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\x89HDF\r\n\x1a\n", 'is HDF5, as MATLAB\'s -v7.3; save it there with save("run.mat", "-v7")'),
        (b"MATLAB 7.3 MAT-file, Platform", "is HDF5"),
        (b"MATLAB 5.0 MAT-file" + b"\0" * 200, "the MAT file is damaged or of a kind that is not read"),
        (FORMS["run.mat"][:300], "the MAT file is damaged"),
        (scalars(), "holds no column of numbers"),
        (FORMS["run.parquet"][:200], "the Parquet file is cut off or damaged"),
        (FORMS["run.npz"][:200], "the NPZ file is damaged or holds objects"),
        (objects(), "the NPZ file is damaged or holds objects"),
        (archive(**{"xl/workbook.xml": b""}), "is an Excel workbook; save its sheet as CSV"),
        (archive(**{"run.csv": b""}), "is an archive of files; unpack it"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1", "is an old Excel workbook"),
        (gzip.compress(b"x" * 1000)[:20], "the gz file is cut off or damaged"),
        (b"\xff\xfea", "begins as UTF-16 and is none"),
        (b"a\0b\0c", "is no text; a log is CSV, Parquet, MAT or NPZ"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "is no text; a log is CSV"),
        (b"\x89MCAP0\r\n\x01\x08\0\0", "is no text; a log is CSV"),
        (b"#ROSBAG V2.0\nE\0\0\0\n", "is no text; a log is CSV"),
        (b"\x01,\x02\n\0\0\n", "is no text; a log is CSV"),
        (b"# role: train\n\nt\tu\n\0\0\n0.1\t2\n", ":4: holds NUL bytes"),
        (b"t,u\r\n0,1\r\n0.1,\0\0\0", ":3: holds NUL bytes, as a loss of power leaves them; delete this line"),
        (b"t,u\n\0\0\n0.1,2\n", ":2: holds NUL bytes"),
    ],
    ids=range(21),
)
def test_what_is_no_table_is_refused_in_one_line(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "run.x").write_bytes(content)
    with pytest.raises(LogError) as error:
        read_sheet(tmp_path / "run.x")
    assert message in str(error.value) and str(error.value).startswith(f"{tmp_path / 'run.x'}:")
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("end", [".xlsx", ".xlsm", ".ods"])
def test_a_damaged_workbook_is_called_one(tmp_path: Path, end: str) -> None:
    (tmp_path / f"run{end}").write_bytes(archive(**{"xl/workbook.xml": b"x" * 99})[:60])
    with pytest.raises(LogError, match=rf"run\{end}: is a damaged workbook; save its sheet as CSV$"):
        read_sheet(tmp_path / f"run{end}")


def test_a_folder_is_refused_with_what_to_name_in_its_place(tmp_path: Path) -> None:
    with pytest.raises(
        LogError, match=re.escape(f"{tmp_path}: is a folder; name its files, such as `{tmp_path / '*.csv'}`")
    ):
        read_sheet(tmp_path)


def test_a_log_of_rwjaxs_own_layout_needs_no_library_that_takes_time_to_import(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("polars", "pandas", "pint", "scipy.io"):
        monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / "run.csv").write_text("\n".join([HEADER, *ROWS]))
    assert len(read_log(tmp_path / "run.csv", parse_rig(write_rig(PLATFORM))).time) == len(ROWS)
