"""The tables of effects in the docs are those that the classes give."""

import re
from pathlib import Path

import pytest

from rwjax.effects.library import BY_NAME, EFFECTS, UNLISTED
from rwjax.effects.table import PAGE, RANGES_REGION, REGIONS, main, table, table_of_ranges, with_tables
from rwjax.kinds import RANGES

ROOT = Path(__file__).parents[2]


def test_the_committed_tables_are_those_of_the_classes() -> None:
    page = (ROOT / PAGE).read_text(encoding="utf-8")
    assert with_tables(page) == page, "run `python -m rwjax.effects.table`"


def test_every_effect_that_a_file_may_name_has_a_row_or_is_that_of_a_half() -> None:
    rows = re.findall(r"^\| `([\w.]+)`", "".join(table(effects) for effects in REGIONS.values()), re.M)
    halves = {name for name, effect in BY_NAME.items() if effect.__base__ in EFFECTS}
    assert sorted(rows) == sorted({*BY_NAME} - halves - {effect.name for effect in UNLISTED})


def test_a_row_has_its_numbers_with_units_and_what_they_are_if_left_out() -> None:
    row = next(line for line in table(EFFECTS).splitlines() if "`axis.stribeck`" in line)
    numbers, kinds = row.split("|")[4:6]
    assert numbers.strip() == "`M_c`, `M_e` N m, `v_s` rad/s, `n` 1 (2 if left out)"
    assert kinds.strip() == "platform, reaction, joint"
    drag = next(line for line in table(EFFECTS).splitlines() if "`axis.quadratic_drag`" in line)
    assert "`c` N m s²/rad²" in drag


def test_every_range_has_its_row() -> None:
    head, _, *rows = table_of_ranges().splitlines()
    assert head == "| quantity | unit | least | most |" and len(rows) == len(RANGES)
    assert "| an inertia | kg m2 | 1e-12 | 1e+12 |" in rows


def test_a_page_without_markers_is_refused() -> None:
    page = "".join(f"<!-- {name} -->\nold\n<!-- /{name} -->\nREST\n" for name in (*REGIONS, RANGES_REGION))
    assert "\nold\n" not in with_tables(page) and with_tables(page).count("REST") == 3
    with pytest.raises(ValueError, match=r"no lines `<!-- effects -->` and `<!-- /effects -->`"):
        with_tables(page.replace("<!-- effects -->", ""))


def test_the_command_writes_the_page_of_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    page = tmp_path / PAGE
    page.parent.mkdir()
    page.write_text(
        "".join(f"<!-- {name} -->\n<!-- /{name} -->\n" for name in (*REGIONS, RANGES_REGION)), encoding="utf-8"
    )
    for words in ("written", "as it was"):
        main()
        assert capsys.readouterr().err.rstrip().endswith(words)
    assert "| `axis.viscous` |" in page.read_text(encoding="utf-8")


def test_outside_the_repository_one_line_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit, match=r"^docs/files.md: is not below this folder; run this at the root"):
        main()
