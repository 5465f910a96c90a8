r"""The numbers of a fleet pooled: mean and spread over its rigs, numbers that all rigs share, and each rig's own beside what its siblings tell.

An estimate $\hat\theta_i$ of rig $i$ has the covariance $\Sigma_i$ that its logs leave, and the rig's own numbers are drawn from those of the
fleet: $\hat\theta_i \sim N(\theta_i, \Sigma_i)$, $\theta_i \sim N(\mu, D)$ with $D$ diagonal, and 0 for a number that all rigs share. With
$W_i = (\Sigma_i + D)^{-1}$ the best linear unbiased values are (Henderson, Biometrics 31, 1975)

$$\mu = C \sum_i W_i \hat\theta_i, \qquad C = \Big(\sum_i W_i\Big)^{-1}, \qquad \theta_i = \mu + D W_i (\hat\theta_i - \mu),$$

$$\mathrm{cov}(\theta_i) = D - D W_i D + (I - D W_i)\, C\, (I - D W_i)^T.$$

Where $\hat\theta_i$ is normal, this is what one fit of the logs of all rigs gives. $D$ comes from `rwjax.fleet.changes`, and its error does not count.
"""

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
import polars as pl

from rwjax.fleet.changes import TINY, compared
from rwjax.fleet.sessions import MISFIT, Estimates

FLEET = {
    "number": pl.String,
    **dict.fromkeys(("mean", "standard_error", "spread"), pl.Float64),
    "shared": pl.Boolean,
    "rigs": pl.Int64,
}
"""Columns of the fleet's numbers."""
DIFFERS = 1.0
"""Standard errors of an estimate by which sound rigs may seem to differ in a number that they share [1]."""
OWN = {
    **dict.fromkeys(("rig", "when", "number"), pl.String),
    **dict.fromkeys(("alone", "alone_error", "value", "standard_error"), pl.Float64),
}
"""Columns of the rigs' numbers."""


class Pooled(NamedTuple):
    """Numbers of a fleet.

    Attributes:
        fleet: `number`, its `mean` over the rigs with the mean's `standard_error`, the `spread` (standard deviation) of the rigs about it
            [SI], whether it is `shared`, and how many `rigs` count.
        own: `rig`, `when`, `number`; what its logs tell `alone` and the standard error of that, null where they tell nothing; `value` and
            `standard_error` beside its siblings [SI].
    """

    fleet: pl.DataFrame
    own: pl.DataFrame


def alike(of: Estimates, shared: Collection[str]) -> tuple[tuple[str, ...], list[str]]:
    """Which of the numbers that are said to be shared the rigs do share.

    Args:
        of: Estimates of the rigs.
        shared: Names of the numbers.

    Returns:
        The names of those that sound rigs do not differ in by more than `DIFFERS`, and a sentence of each other one.
    """
    spread, same, notes = dict(zip(of.names, compared(of).spread, strict=True)) if of.names else {}, [], []
    for name in shared:
        if name not in spread:
            notes.append(f"`shared` names {name}, of which too few rigs tell anything")
            continue
        error = float(np.sqrt(np.nanmedian(of.covariance[:, of.names.index(name), of.names.index(name)])))
        if spread[name] > DIFFERS * error:
            notes.append(
                f"`shared` names {name}, in which sound rigs differ by {spread[name]:.2g}, {spread[name] / max(error, TINY):.2g} times its "
                "standard error: it is taken as each rig's own"
            )
        else:
            same.append(name)
    return tuple(same), notes


def pooled(of: Estimates, shared: Collection[str] = (), apart: Collection[str] = ()) -> Pooled:
    """The numbers of a fleet.

    Args:
        of: Estimates of its rigs.
        shared: Names of numbers that are one and the same in all rigs.
        apart: Rigs that differ from their siblings: they do not count, and their numbers are what their logs tell alone, their siblings'
            where they tell nothing.

    Returns:
        The numbers.
    """
    among = np.array([rig not in apart for rig in of.rigs], bool)
    told = np.isfinite(of.value)
    kept = [k for k, name in enumerate(of.names) if name != MISFIT and told[among, k].any()]
    names = [of.names[k] for k in kept]
    if not kept:
        return Pooled(pl.DataFrame(schema=FLEET), pl.DataFrame(schema=OWN))
    found = compared(of, shared)
    unit, told = found.unit[kept], told[:, kept]
    value = np.where(told, of.value[:, kept], 0.0) / unit
    D = np.diag((found.spread[kept] / unit) ** 2)
    left = of.covariance[:, kept][:, :, kept] / np.outer(unit, unit)
    W = np.linalg.pinv(np.where(told[:, :, None] & told[:, None, :], left + D, 0.0), hermitian=True)
    C = np.linalg.pinv(W[among].sum(axis=0), hermitian=True)
    mean = C @ np.einsum("rjk,rk->j", W[among], value[among])
    gain = D @ W
    own = mean + np.einsum("rjk,rk->rj", gain, np.where(told, value - mean, 0.0))
    rest = np.eye(len(kept)) - gain
    variance = np.einsum("rjj->rj", D - gain @ D + rest @ C @ rest.transpose(0, 2, 1))
    alone, alone_error = value * unit, np.sqrt(np.einsum("rjj->rj", left)) * unit
    own = np.where(among[:, None] | ~told, own * unit, alone)
    error = np.where(among[:, None] | ~told, np.sqrt(np.maximum(variance, 0.0)) * unit, alone_error)
    fleet = [
        (name, m, e, s, name in shared, int(n))
        for name, m, e, s, n in zip(
            names, mean * unit, np.sqrt(np.diag(C)) * unit, found.spread[kept], told[among].sum(axis=0), strict=True
        )
    ]
    rows = [
        (rig, when, name, *((alone[r, k], alone_error[r, k]) if told[r, k] else (None, None)), own[r, k], error[r, k])
        for r, (rig, when) in enumerate(zip(of.rigs, of.whens, strict=True))
        for k, name in enumerate(names)
    ]
    return Pooled(pl.DataFrame(fleet, FLEET, orient="row"), pl.DataFrame(rows, OWN, orient="row"))
