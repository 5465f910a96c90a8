"""Estimates of the rigs of a fleet by session, as arrays: of the latest session, and of what has changed since those before it."""

from typing import Any, NamedTuple

import numpy as np
import polars as pl

FEWEST = 8
"""Rigs below which the spread of a number is not known, and nothing is said of it."""
COMMON = 0.5
"""Share of the rigs above which a number is one of the fleet's [1]."""
MISFIT = "misfit"
"""Name of the number that is RMS error over noise; its logarithm is compared."""
OF_A_RUN = " in "
"""What stands in the name of a number that a run has of its own, which no other rig has."""


class Session(NamedTuple):
    """A session of a rig.

    Attributes:
        when: Its name.
        failed: Whether its job came to nothing.
        value: Numbers by name [SI].
        covariance: Their covariances by both names [SI²].
    """

    when: str
    failed: bool
    value: dict[str, float]
    covariance: dict[tuple[str, str], float]


Sessions = dict[str, list[Session]]
"""Sessions of each rig by its name, in their order; at least one."""


class Estimates(NamedTuple):
    """Estimates of several rigs, NaN where a rig does not tell a number.

    Attributes:
        names: Names of the numbers.
        rigs: Names of the rigs.
        whens: Their sessions.
        value: Numbers, or what they have changed by (rigs, numbers) [SI].
        covariance: What the logs leave of each rig's (rigs, numbers, numbers) [SI²].
        sessions: How many times the spread from session to session counts (rigs, numbers) [1].
        before: Numbers from which a change is counted (rigs, numbers) [SI], 0 where none is.
    """

    names: tuple[str, ...]
    rigs: tuple[str, ...]
    whens: tuple[str, ...]
    value: np.ndarray
    covariance: np.ndarray
    sessions: np.ndarray
    before: np.ndarray


def sessions_of(rows: pl.DataFrame) -> Sessions:
    """The sessions of which there are estimates, or that failed.

    Args:
        rows: Results of a fleet (`rwjax.fleet.store.schema`).

    Returns:
        The sessions of each rig.
    """
    found: Sessions = {}
    told = rows.filter(pl.col("numbers").is_not_null() | (pl.col("status") != "done")).sort("rig", "when")
    for row in told.iter_rows(named=True):
        found.setdefault(row["rig"], []).append(_session(row))
    return found


def _session(row: dict[str, Any]) -> Session:
    """The session of a row, the misfit among its numbers."""
    if row["status"] != "done":
        return Session(row["when"], True, {}, {})
    names = [one["name"] for one in row["numbers"]]
    value = {one["name"]: one["value"] for one in row["numbers"] if OF_A_RUN not in one["name"]}
    pairs = ((a, b) for a in names for b in names)
    if row["misfit"]:
        value[MISFIT] = float(np.log(row["misfit"]))
    return Session(row["when"], False, value, dict(zip(pairs, row["covariance"], strict=True)))


def common(sessions: Sessions) -> tuple[str, ...]:
    """The numbers of a fleet.

    Args:
        sessions: Its sessions.

    Returns:
        Names of those that most rigs tell in their latest session.
    """
    counts: dict[str, int] = {}
    for own in sessions.values():
        for name in own[-1].value:
            counts[name] = counts.get(name, 0) + 1
    return tuple(name for name, count in counts.items() if count > COMMON * len(sessions))


def latest(sessions: Sessions, names: tuple[str, ...]) -> Estimates:
    """Every rig in its latest session.

    Args:
        sessions: The sessions.
        names: Names of the numbers.

    Returns:
        The estimates.
    """
    one, none = np.ones(len(names)), np.zeros(len(names))
    return _together(names, [(rig, own[-1].when, *_arrays(names, own[-1]), one, none) for rig, own in sessions.items()])


def since_before(sessions: Sessions, names: tuple[str, ...]) -> Estimates:
    """What every rig with several sessions has changed by in the latest, against the mean of those before that tell the number.

    Args:
        sessions: The sessions.
        names: Names of the numbers.

    Returns:
        The changes as estimates.
    """
    found = []
    for rig, (*earlier, last) in sessions.items():
        if earlier:
            values, covariances = zip(*(_arrays(names, one) for one in earlier), strict=True)
            value, covariance = _arrays(names, last)
            seen = np.isfinite(values)
            count = seen.sum(axis=0)
            each = np.maximum(count, 1)
            mean = np.where(count > 0, np.where(seen, values, 0.0).sum(axis=0) / each, np.nan)
            spread = covariance + np.sum(covariances, axis=0) / np.outer(each, each)
            found.append((rig, last.when, value - mean, spread, 1.0 + 1.0 / each, mean))
    return _together(names, found)


def lacking(sessions: Sessions, names: tuple[str, ...]) -> pl.DataFrame:
    """Rigs that do not tell all numbers in their latest session.

    Args:
        sessions: The sessions.
        names: Names of the numbers.

    Returns:
        `rig`, `when` and the `numbers` that it lacks; a session that failed is told of elsewhere.
    """
    rows = [
        (rig, own[-1].when, ", ".join(without))
        for rig, own in sessions.items()
        if not own[-1].failed and (without := [name for name in names if name not in own[-1].value])
    ]
    return pl.DataFrame(rows, dict.fromkeys(("rig", "when", "numbers"), pl.String), orient="row")


def _arrays(names: tuple[str, ...], of: Session) -> tuple[np.ndarray, np.ndarray]:
    """Numbers in the order of their names, NaN where there is none, and their covariance."""
    return (
        np.array([of.value.get(name, np.nan) for name in names]),
        np.array([[of.covariance.get((a, b), 0.0) for b in names] for a in names]).reshape(len(names), len(names)),
    )


def _together(
    names: tuple[str, ...], found: list[tuple[str, str, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
) -> Estimates:
    """Estimates of several rigs as arrays, without numbers that too few tell, and without rigs that tell none."""
    count = len(names)
    value = np.array([one[2] for one in found]).reshape(len(found), count)
    told = np.isfinite(value).sum(axis=0) >= FEWEST
    kept = [k for k, own in enumerate(value) if np.isfinite(own[told]).any()]
    _, _, _, covariance, sessions, before = zip(*(found[k] for k in kept), strict=True) if kept else ((),) * 6
    return Estimates(
        tuple(name for name, enough in zip(names, told, strict=True) if enough),
        tuple(found[k][0] for k in kept),
        tuple(found[k][1] for k in kept),
        value[kept][:, told],
        np.array(covariance).reshape(len(kept), count, count)[:, told][:, :, told],
        np.array(sessions).reshape(len(kept), count)[:, told],
        np.array(before).reshape(len(kept), count)[:, told],
    )
