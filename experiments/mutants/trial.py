"""Tests run in a copy of a checkout in which one module is another."""

import multiprocessing
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

LIMIT = 60
"""Time of the processor [s] after which tests have failed; they take about 3 s, and waiting ones have ten times as long."""
MEMORY = 24 * 2**30
"""Addresses [bytes] that tests may take: a loop without end fills the memory before its time is up."""
OPTIONS = ["-x", "-q", "-m", "not slow", "--hypothesis-seed=0", "-p", "no:cacheprovider"]
OPTIONS += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # hypothesis is imported already
CONTEXT = multiprocessing.get_context("forkserver")
"""Processes begin where what tests import from elsewhere is imported already, which takes longer than most tests."""
CONTEXT.set_forkserver_preload(
    ["pytest", "hypothesis.strategies", "equinox", "beartype", "scipy.signal", "scipy.stats"]
)


class Copy:
    """A copy of the checkout in which one module at a time is another."""

    def __init__(self, root: Path, folder: Path) -> None:
        self.folder = folder
        listed = subprocess.run(
            ["git", "ls-files", "-co", "--exclude-standard"], cwd=root, stdout=subprocess.PIPE, text=True, check=True
        )
        for name in listed.stdout.splitlines():
            if (root / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(root / name, folder / name)

    def passes(self, path: str, source: str, tests: str, keep_bytecode: bool = False) -> bool:
        """Whether tests pass with another source of a module."""
        shutil.rmtree(self.folder / ".hypothesis", ignore_errors=True)  # no example that another mutant has left
        module = self.folder / path
        kept, made = module.read_bytes(), module.stat().st_mtime_ns
        module.write_text(source)
        process = CONTEXT.Process(target=_run, args=(self.folder, tests, keep_bytecode))
        process.start()
        process.join(10 * LIMIT)
        process.kill()
        process.join()
        module.write_bytes(kept)
        os.utime(module, ns=(made, made))  # so that its bytecode counts as that of this source
        return process.exitcode == 0


def _run(folder: Path, tests: str, keep_bytecode: bool) -> None:
    """Runs tests in a copy, in a process of their own whose exit code says whether they pass."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    os.chdir(folder)
    os.environ["PYTHONPATH"] = str(folder)
    sys.path.insert(0, str(folder))
    sys.dont_write_bytecode = not keep_bytecode
    os._exit(pytest.main([tests, *OPTIONS]))
