"""The commit that a stored result is of."""

import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@cache
def commit(folder: Path = ROOT) -> str:
    """Short hash of a checkout, with `-dirty` if tracked files are changed, or nothing if there is no checkout.

    It is asked once, since a process goes on with the code that it has loaded.
    """
    asked = ["git", "describe", "--always", "--dirty", "--exclude", "*"]
    try:
        return subprocess.run(asked, cwd=folder, capture_output=True, text=True, check=False).stdout.strip()
    except FileNotFoundError:  # no git
        return ""
