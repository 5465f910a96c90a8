"""`rwjax report`, as a user calls it."""

from pathlib import Path

import pytest

from rwjax.diagnosis.record import RECORD, record
from rwjax.report.html import FIGURES, REPORT, write_report
from tests.cli.shell import Shell, program
from tests.report.diagnosed import diagnosed


@pytest.mark.slow
def test_the_page_comes_back_as_the_diagnosis_has_drawn_it(tmp_path: Path) -> None:
    d = diagnosed()
    (tmp_path / RECORD).write_bytes(record(d))
    write_report(d, tmp_path)
    drawn = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for path in tmp_path.iterdir():
        if path.name != RECORD:
            path.unlink()
    done = program("report", ".", "--quiet", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"report: {REPORT}\n", "")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == drawn
    assert {REPORT, "motion.png"} <= {*drawn} <= {REPORT, RECORD, *(f"{name}.png" for name in FIGURES)}


def test_a_file_that_is_no_page_is_refused_before_the_record_is_read(shell: Shell) -> None:
    (shell.folder / "report.html").write_text("mine")
    code, _, err = shell("report", ".")
    assert code == 2 and err.count("\n") == 1 and "report.html: is no page that rwjax wrote" in err


def test_a_folder_that_holds_no_diagnosis_is_refused_in_one_line(shell: Shell) -> None:
    code, _, err = shell("report", "out")
    assert code == 2 and err.count("\n") == 1 and "give the folder of a diagnosis" in err
