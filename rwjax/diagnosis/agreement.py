r"""Agreement: whether every run, and commands of every size, ask for as much of a name as all of them together.

A true effect has one amplitude everywhere. Let $r$ be the residual with the name and $d$ the change of the prediction that the name
brings after all other numbers have adapted, both in units of the noise. Part $i$ of the readings then asks for

$$ a_i = 1 - \frac{\sum_i r\,d}{\sum_i d^2}, \qquad
   \sigma_i^2 = \frac{c_i \sum_i r_i^2 d^2}{\bigl(\sum_i d^2\bigr)^2} $$

times the amplitude that was fitted, with the residual $r_i = r - (1 - a_i)\,d$ of the part's own amplitude and the correlation time $c_i$
of the products $r_i\,d$ [samples]. What else is missing is part of $r_i$, and so of the errors; that the parts disagree is not.

How unevenly the parts ask for it is the weighted mean

$$ h^2 = \frac{\sum_i w_i \max\bigl((a_i - 1)^2 - \sigma_i^2,\, 0\bigr)}{\sum_i w_i}, \qquad w_i = \frac{\sum_i d^2}{\sum d^2}, $$

over the runs, or over the halves by size of command and by time together, whichever is larger.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.information_criterion import correlation_time, residuals
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.logs.log import Log
from rwjax.logs.segments import runs_of


class Amplitude(NamedTuple):
    """What one part of the readings asks for.

    Attributes:
        value: amplitude, in units of the fitted one [1].
        error: its standard error [1].
        weight: share of the change that lies in this part [1].
        run: number of the run that the part is; None for a part of another kind.
    """

    value: float
    error: float
    weight: float
    run: int | None


def _middles(logs: Sequence[Log], run: Sequence[int]) -> dict[int, float]:
    """The middle of each run [s] by its number, of logs that may be its segments."""
    times = {n: [log.time for log, of in zip(logs, run, strict=True) if of == n] for n in run}
    return {n: 0.5 * float(min(t[0] for t in of) + max(t[-1] for t in of)) for n, of in times.items()}


def amplitudes(fits: ModelFits, larger: Hypothesis, smaller: Hypothesis) -> list[Amplitude]:
    """Amplitude that each training run asks for, then the smaller and the larger commands, then the runs' first and second halves.

    Args:
        fits: fits of both hypotheses among them.
        larger: the hypothesis with the name.
        smaller: the hypothesis without it.

    Returns:
        One amplitude for each of these parts in which the name changes anything.
    """
    with_it, without = (residuals(fits.known(e), fits.train) for e in (larger, smaller))
    logs = [fits.problem.logs[k] for k in fits.train]
    numbers = runs_of(fits.problem.logs)[list(fits.train)].tolist()
    middles = _middles(logs, numbers)
    r, d, run, size, late = [], [], [], [], []
    for name, series in with_it.items():
        held = [k for k, log in enumerate(logs) if name in log.outputs]
        for k, one, other in zip(held, series, without[name], strict=True):
            r.append(one)
            d.append(one - other)
            run.append(np.full(len(one), numbers[k]))
            size.append(np.abs(logs[k].at_drive).reshape(len(one), -1).max(axis=1))
            late.append(logs[k].time >= middles[numbers[k]])
    whole = sum(float(np.sum(b**2)) for b in d)
    middle = float(np.median(np.concatenate(size)))
    parts = [(n, [k == n for k in run]) for n in dict.fromkeys(int(k[0]) for k in run)]
    parts += [(None, at) for at in ([s <= middle for s in size], [s > middle for s in size], [~s for s in late], late)]
    found = []
    for number, part in parts:
        square = sum(float(np.sum(b[at] ** 2)) for b, at in zip(d, part, strict=True))
        if square > 0.0:
            short = sum(float(a[at] @ b[at]) for a, b, at in zip(r, d, part, strict=True)) / square
            products = [(a - short * b) * b for a, b in zip(r, d, strict=True)]
            spread = sum(correlation_time(p) * float(np.sum(p[at] ** 2)) for p, at in zip(products, part, strict=True))
            found.append(Amplitude(1.0 - short, float(np.sqrt(spread)) / square, square / whole, number))
    return found


def unevenness(parts: Sequence[Amplitude]) -> float:
    """How unevenly the parts ask for a name, by what each holds of its change.

    Args:
        parts: what each part asks for, of `amplitudes`.

    Returns:
        Root of the weighted mean square by which amplitudes differ from the fitted one beyond their errors [1], of the runs or of the other
        parts, whichever is larger; 0 where there are none, infinite where one of their numbers is not finite.
    """
    if not np.isfinite([(a.value, a.error, a.weight) for a in parts]).all():
        return np.inf
    found = [0.0]
    for group in ([a for a in parts if a.run is not None], [a for a in parts if a.run is None]):
        beyond = sum(a.weight * max((a.value - 1.0) ** 2 - a.error**2, 0.0) for a in group)
        found.append(float(np.sqrt(beyond / sum(a.weight for a in group))) if group else 0.0)
    return max(found)
