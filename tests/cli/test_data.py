"""`rwjax data`, as a user calls it; what it fetches is tested with `rwjax.logs.published`."""

from pathlib import Path

from tests.cli.shell import program


def test_data_lists_the_sets_with_source_and_licence(tmp_path: Path) -> None:
    done = program("data", cwd=tmp_path)
    assert done.returncode == 0 and "emps:" in done.stdout and "source:" in done.stdout and "licence:" in done.stdout


def test_an_unknown_set_is_refused_in_one_line(tmp_path: Path) -> None:
    for arguments in (("fetch", "empss"), ("fetch",)):
        done = program("data", *arguments, cwd=tmp_path)
        assert done.returncode == 2 and done.stderr.count("\n") == 1 and "known are emps" in done.stderr
    assert not list(tmp_path.iterdir())


def test_another_word_than_fetch_is_refused_with_what_is_right(tmp_path: Path) -> None:
    done = program("data", "list", cwd=tmp_path)
    right = "`rwjax data` lists the sets, `rwjax data fetch NAME` brings one"
    assert done.returncode == 2 and done.stderr == f"rwjax: data list: is not known; {right}\n"
