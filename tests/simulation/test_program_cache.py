"""Traced programs on disk: a new process traces nothing, a spoilt file is no harm, and what is differentiated is traced."""

import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.simulation import program_cache as module
from rwjax.simulation.program_cache import stored

FIT = """
import jax.monitoring
traced = []
jax.monitoring.register_event_duration_secs_listener(
    lambda name, seconds, **more: traced.append(name) if name.endswith("trace_duration") and more["fun_name"] != "call" else None
)  # what was read from the disk is called `call`
import numpy as np
from rwjax.fitting.fit import fit
from tests.systems import platform, record, run
t = np.arange(300) * 0.01
u = np.sign(np.sin(3.0 * t))
rig = platform()
traced.clear()
found = fit(rig, [record(t, u, {"yaw_rad": 0.3 * t**2})])
print(len(traced), found.rig.values["axis.inertia"])
"""


@pytest.mark.slow
def test_a_second_process_traces_nothing_and_finds_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(tmp_path))

    def fit() -> list[str]:
        return subprocess.run([sys.executable, "-c", FIT], capture_output=True, text=True, check=True).stdout.split()

    first, second = fit(), fit()
    assert int(first[0]) > 0 and int(second[0]) == 0
    assert first[1] == second[1]
    for path in tmp_path.glob("lowered-*"):
        path.write_bytes(path.read_bytes()[:100])
    spoilt = fit()
    assert int(spoilt[0]) > 0 and spoilt[1] == first[1]


def test_inside_another_function_it_is_traced_there() -> None:
    @stored(tuple)
    def square(power: int, x):
        return [x**power]

    assert np.array_equal(square(2, np.arange(3.0))[0], [0.0, 1.0, 4.0])
    assert np.array_equal(jax.jacfwd(lambda x: square(3, x)[0])(jnp.arange(2.0)), [[0.0, 0.0], [0.0, 3.0]])


def test_the_programs_not_called_for_longest_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    traced: list[tuple[int, ...]] = []
    monkeypatch.setattr(module, "MOST_PROGRAMS", 2)

    @stored(tuple)
    def twice(structure: NotKept, x):
        traced.append(x.shape)  # what is not kept on disk is traced whenever it is made
        return [2.0 * x]

    for n in (1, 2, 1, 3, 1, 2):
        assert np.array_equal(twice(NotKept("any"), np.arange(float(n)))[0], 2.0 * np.arange(n))
    assert traced == [(1,), (2,), (3,), (2,)]


class NotKept(NamedTuple):
    """Stands for a structure with a user's own effect."""

    name: str

    @property
    def from_library(self) -> bool:
        return False


class Factor(eqx.Module):
    """Stands for a solver."""

    by: float
    form: str = eqx.field(static=True, default="times")
    from_library: bool = eqx.field(static=True, default=True)


def test_what_is_static_in_a_choice_makes_a_program_and_its_numbers_do_not(tmp_path: Path) -> None:
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))

    def kept() -> int:
        return len([*tmp_path.glob("traced-scaled-*")])

    @stored(tuple)
    def scaled(structure: str, x, *, factor: Factor = Factor(2.0)):  # noqa: B008 (a module, which nothing changes)
        return [factor.by * x if factor.form == "times" else x / factor.by]

    try:
        assert scaled("any", np.ones(1))[0] == 2.0 and kept() == 1
        assert scaled("any", np.ones(1), factor=Factor(3.0, from_library=False))[0] == 3.0 and kept() == 1
        assert scaled("any", np.ones(1), factor=Factor(4.0))[0] == 4.0 and kept() == 1
        assert scaled("any", np.ones(1), factor=Factor(4.0, "over"))[0] == 0.25 and kept() == 2
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    slope = jax.grad(lambda x: scaled("any", x, factor=Factor(5.0))[0])(1.0)
    assert slope == 5.0  # inside another traced function it is traced there, with its choice
    assert jax.grad(lambda by: scaled("any", 1.0, factor=Factor(by, "over"))[0])(2.0) == -0.25


def test_a_program_that_calls_back_to_python_is_not_kept_and_works(tmp_path: Path) -> None:
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))

    @stored(tuple)
    def checked(structure: str, x):
        return [jax.pure_callback(lambda x: x + 1.0, x, x)]

    try:
        assert checked("any", np.ones(1))[0] == 2.0
        assert not [*tmp_path.glob("traced-checked-*")]
    finally:
        jax.config.update("jax_compilation_cache_dir", before)


def test_a_full_disk_leaves_no_half_of_a_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = Path.write_bytes

    def full(path: Path, data: bytes) -> int:
        if not path.name.startswith("traced-"):  # JAX's own program
            return write(path, data)
        write(path, data[:10])
        raise OSError(28, "No space left on device")

    @stored(tuple)
    def thrice(structure: str, x):
        return [3.0 * x]

    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        with monkeypatch.context() as patch:
            patch.setattr(Path, "write_bytes", full)
            assert thrice("any", np.ones(1))[0] == 3.0
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    assert [*tmp_path.glob("traced-*")] == []
