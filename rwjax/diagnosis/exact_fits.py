"""Fits by exact derivatives, and the last digits of the reported one.

Exact derivatives through short windows follow a narrow valley of the cost where secants of whole runs creep. They also find a valley
before which whole runs end.
"""

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis, structure_for
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.nonsmooth import beyond_stairs
from rwjax.fitting.problem import Problem
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.fitting.threads import on_threads


def fit_exactly(fits: ModelFits, hypotheses: Iterable[Hypothesis]) -> None:
    """Carries fits on by exact derivatives through short windows that begin at what was measured.

    Those that come near the best fit are carried to their end. A hypothesis whose readings reach back further than the windows is
    left as it is. All are fitted once more where this frees the first states.

    Args:
        fits: fits that have begun.
        hypotheses: those to carry on.
    """
    wanted = [
        e
        for e in dict.fromkeys(hypotheses)
        if fits.fitted_exactly.get(e) != fits.by_start_rule and _within_windows(fits, e)
    ]
    if not wanted:
        return
    by_start_rule, begun = fits.by_start_rule, [fits.known(e) for e in wanted]
    fits.fitted_exactly |= dict.fromkeys(wanted, by_start_rule)
    problems = [fits.training(f.problem.structure) for f in begun]
    most = fits.settings.halving.behind * fits.least(fits)
    trial = partial(_exactly, fits, most=most, check=fits.headway.budget.ending())
    found = dict(zip(wanted, on_threads(trial, problems, begun), strict=True))
    fits.keep(found)
    near = [e for e in wanted if found[e].cost <= most and not fits.ended(e)]
    if near:
        fits.finish(near)
    else:
        fits.free_starts()
    if fits.by_start_rule != by_start_rule:
        fit_exactly(fits, wanted)


def polish(fits: ModelFits, hypothesis: Hypothesis) -> Fit:
    """The fit of a hypothesis to the last digit, by exact derivatives and then by secants.

    Secant steps come last because stick-slip makes the cost nonsmooth. A number without trace is then tried elsewhere.

    Args:
        fits: fits that have begun.
        hypothesis: the one to report.

    Returns:
        Its fit.
    """
    fit_exactly(fits, [hypothesis])
    fits(hypothesis)
    fits.carry_on([hypothesis], fits.settings.fitting.reported_tolerance)
    found = fits.known(hypothesis)
    if np.isfinite(found.cost) and _within_windows(fits, hypothesis):
        check = fits.headway.budget.check
        least = partial(least_squares, found.problem, found.coordinates, found.theta, start=found.start, check=check)
        better = beyond_stairs(least(most_steps=0), check)
        if better.cost <= found.cost:
            fits.keep({hypothesis: better})
            fits.carry_on([hypothesis], fits.settings.fitting.reported_tolerance)
    return fits.known(hypothesis)


def _within_windows(fits: ModelFits, hypothesis: Hypothesis) -> bool:
    """Whether the readings of a hypothesis reach back no further than the windows."""
    return structure_for(fits.rig, hypothesis).longest_encoder_delay <= fits.problem.structure.longest_encoder_delay


def _exactly(fits: ModelFits, problem: Problem, begun: Fit, most: float, check: Callable[[], None]) -> Fit:
    """A fit after a few trial steps by exact derivatives, and carried to its end where they leave at most so much."""
    nodes, c = measured_nodes(problem, begun.theta), begun.coordinates
    least, steps = partial(least_squares, problem, c, check=check), fits.settings.fitting.trial_steps
    found = least(begun.theta, start=begun.start, nodes=nodes, most_steps=steps)
    found = found if found.cost > most else least(found.theta, start=found.start)
    fits.headway.advance(fits.settings.headway.exact)
    return found
