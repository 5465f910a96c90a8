"""Runs of a simulated platform, each of its own size of command, and fits to them, for tests of what holds in every run."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.going_on import FurtherSearch
from rwjax.logs.log import Log
from tests.systems import platform, record, run

TIME = np.arange(801) * 0.01
RIG = platform("viscous = 0.02")
SIZES = (0.5, 0.8, 1.1, 0.65)
Truth = Mapping[str, dict[str, float]]


def run_of(number: int, truth: Truth, noise: float = 2e-4, disturbed: float = 0.0) -> Log:
    """Readings of one run; `disturbed` adds a slow motion that no effect of the library makes [rad]."""
    pushed = np.sign(np.sin((1.4 + 0.3 * number) * TIME)) + 0.4 * np.sin(5.0 * TIME)
    command = np.where(TIME > 0.6, SIZES[number] * pushed, 0.0)
    rng = np.random.default_rng(number)
    y = run(RIG, record(TIME, command), {}, effects=dict(truth) or None)["yaw_rad"]
    walk = np.cumsum(np.cumsum(rng.normal(size=len(TIME))) * (TIME > 0.6))
    y = y + disturbed * walk / np.max(np.abs(walk)) + rng.normal(0.0, noise, len(TIME))
    return replace(record(TIME, command, {"yaw_rad": y}), name=f"{number}.csv")


def searched(logs: Sequence[Log], *hypotheses: Hypothesis) -> FurtherSearch:
    """A search that goes on among the names of some hypotheses, which are fitted."""
    fits = ModelFits.of(RIG, logs, range(len(logs)))
    search = FurtherSearch(fits, tuple(dict.fromkeys(name for e in hypotheses for name in e.names)))
    fits(NOTHING)
    fits.start_from_first_readings()
    search.halving.fit(hypotheses, NOTHING)
    fits.finish([e for e in hypotheses if e in fits])
    return search
