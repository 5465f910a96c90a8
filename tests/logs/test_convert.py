"""Files of any layout written in rwjax's: the same log either way, with the same rig file."""

from pathlib import Path

import numpy as np

from rwjax.logs.convert import converted
from rwjax.logs.read import read_log
from rwjax.logs.write import write_log
from tests.logs.forms import FORMS, RIG


def test_an_imported_log_is_the_files_own(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_bytes(b"# role: validate\n" + FORMS["semicolons.csv"])
    columns, notes = converted(tmp_path / "run.csv", RIG)
    write_log(tmp_path / "imported.csv", columns, notes)
    before, after = read_log(tmp_path / "run.csv", RIG), read_log(tmp_path / "imported.csv", RIG)
    assert [*columns] == ["time_s", "voltage_V", "yaw_rad", "yaw_rad_s"] and after.validate
    assert np.array_equal(before.time, after.time) and np.array_equal(before.command, after.command)
    assert all(np.array_equal(before.outputs[name], after.outputs[name]) for name in before.outputs)
    assert after.notes == {"role": "validate", "layout": "rwjax", "from": "run.csv"}


def test_what_was_left_out_is_not_left_out_once_more(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_bytes(b"# ignore: state\n" + FORMS["semicolons.csv"])
    write_log(tmp_path / "imported.csv", *converted(tmp_path / "run.csv", RIG))
    assert "ignore" not in read_log(tmp_path / "imported.csv", RIG).notes
