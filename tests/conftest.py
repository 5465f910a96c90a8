"""Strict JAX settings for every test, and the folders of measured data that some tests read.

Nothing of `rwjax` is imported here: the option `--jaxtyping-packages` checks only what is imported after it.
"""

import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import jax
import pytest

from tests.type_checks import begin_anew

os.environ.setdefault("EQX_ON_ERROR", "off")  # as the commands do: smooth programs are then kept, and not compiled anew
jax.config.update("jax_enable_x64", True)
jax.config.update("jax_numpy_dtype_promotion", "strict")  # float32 mixed with float64 becomes an error
jax.config.update("jax_numpy_rank_promotion", "raise")  # and so does a silent (n, 1) + (n,)
EXAMPLES = 100 if os.environ.get("RWJAX_EVERY_CALL") else 25  # of a property; `make test-all` sets the variable
if not os.environ.get("RWJAX_EVERY_CALL"):
    jax.config.update("jax_disable_most_optimizations", True)  # a tenth of the quick tests' time; all runs are short
hypothesis.settings.register_profile("rwjax", deadline=None, max_examples=EXAMPLES)  # the first call compiles
hypothesis.settings.load_profile("rwjax")
OBJECTS = 50_000  # before Python looks for circles among them, which costs a tenth of the tests' time

MAPS, MOST_MAPS = Path("/proc/self/maps"), 10_000  # programs of more of them take gigabytes
SHARED = Path(__file__).parents[2] / "shared"  # beside the repository, unless a variable says otherwise


def pytest_collection_finish() -> None:
    """What has been imported and collected stays, and is not looked through again and again."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(OBJECTS)


@pytest.fixture(scope="module", autouse=True)
def _programs_are_dropped() -> Iterator[None]:
    """Every compiled program takes up to 350 memory maps, of which Linux gives a process 65 530."""
    yield
    if not MAPS.exists() or MAPS.read_bytes().count(b"\n") > MOST_MAPS:
        jax.clear_caches()


@pytest.fixture(scope="session", autouse=True)
def _programs_are_made_fast() -> None:
    """A tenth of the quick tests' time; what is made so has files of its own."""
    if not os.environ.get("RWJAX_EVERY_CALL"):
        from rwjax.lowering import machine

        machine.EFFORT = 0


@pytest.fixture(scope="module", autouse=True)
def _signatures_are_checked() -> None:
    begin_anew()


@pytest.fixture(scope="session")
def realdata() -> Path:
    """The folder of logs measured on real rigs."""
    return _folder("RWJAX_REALDATA", "realdata", "real data")


@pytest.fixture(scope="session")
def examples() -> Path:
    """The folder of example rigs and logs with known causes."""
    return _folder("RWJAX_EXAMPLES", "examples", "examples")


def _folder(variable: str, name: str, words: str) -> Path:
    folder = Path(os.environ.get(variable) or SHARED / name)
    if not folder.is_dir():
        # reason: logs that others published may not be committed, and without them these tests have nothing to say
        pytest.skip(f"{words} not found: set {variable}")
    return folder


@pytest.fixture
def hears_ctrl_c() -> Iterator[None]:
    """Lets what a test begins hear Ctrl-C, which it inherits to ignore where the tests run in the background, and SIGTERM end it."""
    usual = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
    before = {number: signal.signal(number, handler) for number, handler in usual.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
