"""The commit that a result is of."""

import subprocess
from pathlib import Path

from experiments.commit import commit


def test_a_commit_is_named_and_changes_to_tracked_files_are_told(tmp_path: Path) -> None:
    def git(*words: str) -> str:
        who = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
        return subprocess.run(["git", *who, *words], cwd=tmp_path, check=True, capture_output=True, text=True).stdout

    git("init", "-q")
    (tmp_path / "code.py").write_text("a = 1")
    git("add", "code.py")
    git("commit", "-q", "-m", "first")
    git("tag", "v1")  # whose name is no hash
    (tmp_path / "results.jsonl").write_text("{}")  # which git does not know
    commit.cache_clear()
    assert commit(tmp_path) == git("rev-parse", "--short", "HEAD").strip()
    (tmp_path / "code.py").write_text("a = 2")
    assert "dirty" not in commit(tmp_path)  # the code that was loaded
    commit.cache_clear()
    assert commit(tmp_path) == git("rev-parse", "--short", "HEAD").strip() + "-dirty"


def test_no_checkout_has_no_commit(tmp_path: Path) -> None:
    assert commit(tmp_path) == ""
