"""What has been compiled once serves new starts and other logs of the same padded shape."""

from collections.abc import Iterator
from contextlib import contextmanager

import jax
import numpy as np

from rwjax.fitting.fit import fit
from tests.systems import platform, record, run

FREE = '"axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'
COMPILED = "/jax/core/compile/backend_compile_duration"


@contextmanager
def _compilations() -> Iterator[list[str]]:
    """The names of the programs that are compiled, or fetched from the cache on disk, while the block runs."""
    found: list[str] = []

    def hear(event: str, _: float, **more: object) -> None:
        if event == COMPILED:
            found.append(str(more.get("fun_name", event)))

    jax.monitoring.register_event_duration_secs_listener(hear)
    try:
        yield found
    finally:
        jax.monitoring.unregister_event_duration_listener(hear)


def _log(samples: int, pace: float):
    rig, t = platform(free=FREE), np.arange(samples) * 0.01
    u = np.where(t > 0.6, 0.6 * np.sign(np.sin(pace * t)) + 0.3 * np.sin(5.0 * t), 0.0)
    y = run(rig, record(t, u), {})["yaw_rad"]
    return record(t, u, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, 1e-3, samples)})


def test_a_new_start_and_a_second_log_of_the_same_padded_shape_compile_nothing() -> None:
    truth = platform(free=FREE)
    first, second = _log(501, 1.7), _log(497, 2.3)
    with _compilations() as heard:
        jax.jit(lambda x: 3.0 * x)(np.arange(5.0))
    assert heard  # else the listener hears nothing and the test says nothing
    fit(truth, [first])
    wrong = truth.with_values({name: 1.6 * truth.values[name] for name in truth.free})
    for rig, log in ((wrong, first), (truth, second), (wrong, second)):
        with _compilations() as again:
            fit(rig, [log])
        assert again == []


def test_another_choice_of_free_numbers_compiles_nothing() -> None:
    fit(platform(free=FREE), [_log(501, 1.7)])
    with _compilations() as again:
        fit(platform(free='"axis.inertia"'), [_log(501, 1.7)])
    assert again == []
