"""Estimates by session, as arrays."""

import numpy as np
import polars as pl
import pytest

from rwjax.fleet.plan import Job
from rwjax.fleet.sessions import FEWEST, common, lacking, latest, sessions_of, since_before
from rwjax.fleet.store import schema
from rwjax.fleet.work import failed


def row(rig: str, when: str, numbers: dict[str, float], misfit: float | None = None) -> dict:
    """A row whose numbers have unit variances and correlate by a half."""
    told = [{"name": name, "value": value, "standard_error": 1.0} for name, value in numbers.items()]
    covariance = 0.5 * np.eye(len(told)) + 0.5
    done = {"status": "done", "numbers": told, "covariance": covariance.ravel().tolist(), "misfit": misfit}
    return failed(Job(rig, when, "", ()), "fit", "") | done


RIGS = [f"r{k}" for k in range(FEWEST)]
ROWS = [row(rig, when, {"J": 1.0 + k, "b": float(when)}, misfit=2.0) for k, rig in enumerate(RIGS) for when in "123"]


def test_the_latest_session_of_every_rig_with_its_misfit() -> None:
    sessions = sessions_of(pl.DataFrame(ROWS, schema=schema()))
    found = latest(sessions, common(sessions))
    assert (found.names, found.rigs, set(found.whens)) == (("J", "b", "misfit"), tuple(RIGS), {"3"})
    assert found.value[2] == pytest.approx([3.0, 3.0, np.log(2.0)])
    assert np.array_equal(found.covariance[0], [[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.0]])


def test_what_has_changed_is_counted_from_the_mean_of_the_sessions_before() -> None:
    sessions = sessions_of(pl.DataFrame(ROWS, schema=schema()))
    found = since_before(sessions, ("b", "J"))
    assert found.value == pytest.approx(np.tile([1.5, 0.0], (FEWEST, 1)))  # 3 less the mean of 1 and 2
    assert found.before[:, 0] == pytest.approx(1.5) and found.sessions == pytest.approx(1.5)
    assert found.covariance[0] == pytest.approx(1.5 * np.array([[1.0, 0.5], [0.5, 1.0]]))


def test_a_number_that_too_few_tell_and_a_rig_that_tells_none_are_left_out() -> None:
    rows = [*ROWS, row("new", "1", {"other": 1.0}), failed(Job("gone", "1", "", ()), "fit", "why")]
    sessions = sessions_of(pl.DataFrame(rows, schema=schema()))
    assert latest(sessions, ("J", "other")).names == ("J",) and latest(sessions, ("J", "other")).rigs == tuple(RIGS)
    assert lacking(sessions, ("J",)).rows() == [("new", "1", "J")]  # that one failed is told of elsewhere
    none = latest({}, ("J",))
    assert (none.names, none.rigs, none.value.shape) == ((), (), (0, 0))
