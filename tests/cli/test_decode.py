"""`rwjax decode`, as a user calls it."""

from pathlib import Path

import pytest

from experiments.testbed.campaign import RIG
from tests.command import refuses
from tests.command import rwjax as within
from tests.link.ports import stream


def test_a_raw_stream_becomes_a_log(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    raw = tmp_path / "cut.raw"
    raw.write_bytes(b"".join(stream([*range(40), *range(44, 90)]))[:-9])
    assert within(monkeypatch, "decode", RIG, raw) == 0
    said = capsys.readouterr()
    assert said.out == f"{tmp_path / 'cut.csv'}\n" and said.err == "note: cut.csv: gap of 4 samples before 0.44 s\n"
    assert len((tmp_path / "cut.csv").read_text().splitlines()) == 85 + 4


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("decode", "RIG", "."), ".: is a folder; give the path of a raw stream"),
        (
            ("decode", "RIG", "run.csv"),
            "run.csv: is a log already; give the raw stream that a recording has left (.raw)",
        ),
        (("decode", "RIG", "OUT.raw"), "OUT.raw: cannot be read: No such file or directory"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: tuple[str, ...],
    said: str,
) -> None:
    refuses(monkeypatch, capsys, tmp_path, arguments, said)
