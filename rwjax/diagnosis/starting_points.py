"""Starting points: where the fit of a hypothesis may begin, by its score screen around its parent's estimates."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis, chosen_names, free_names, handed_on, structure_for
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.score_screen import Candidate, ScoreScreen, Screened
from rwjax.effects.library import included_numbers, limit_numbers, null_of_optional
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import Problem
from rwjax.fitting.processes import Task
from rwjax.fitting.secant import search_point, with_residual
from rwjax.plant.from_rig import theta_of
from rwjax.plant.structure import Structure


@dataclass(frozen=True)
class Begun:
    """Where the fit of one hypothesis may begin.

    Attributes:
        predicted: half the sum of squares [1] that the score screen predicts to be left, at most what `here` leaves.
        here: the fit as it stands at the best of the screened points, without a step.
        places: fits without a step at the points from which the search should begin; the one with the least cost first;
            none where it is predicted to leave far more than its parent, or where no run from any of them stays within the range of numbers.
    """

    predicted: float
    here: Fit
    places: list[Fit]


def begin(
    fits: ModelFits, hypotheses: Sequence[Hypothesis], parent: Hypothesis, behind: float = np.inf
) -> dict[Hypothesis, Begun]:
    """Screens hypotheses from a parent's estimates, and simulates each at the places where it may begin.

    What is missing bends these estimates: friction grows until a run without a stop does not reach it. So a hypothesis that changes nothing
    at one of its places begins from the rig file's numbers, too.

    Args:
        fits: fits, the parent's among them.
        hypotheses: those to begin.
        parent: the hypothesis from whose estimates they begin.
        behind: predicted cost, against the parent's, above which a hypothesis begins nowhere [1]. The parent's special cases and what was
            fitted before begin anyway: of these more is known than the prediction.

    Returns:
        The places by hypothesis; two places of the same cost count as one, and one from which a run leaves the range of numbers as none.
    """
    run = partial(fits.together, work=fits.settings.headway.screened * len(hypotheses))
    screen = ScoreScreen(fits(parent), fits.settings.screening, run)
    found = screen.predict([candidate_of(fits, e, parent) for e in hypotheses])
    screened = dict(zip(hypotheses, found, strict=True))
    here = {e: _here(fits, e, parent, s) for e, s in screened.items()}
    predicted, most = {e: min(s.predicted, here[e].cost) for e, s in screened.items()}, behind * fits(parent).cost
    ahead = [e for e in hypotheses if predicted[e] <= most or parent.contains(e) or fits.stepped(e)]
    places: dict[Hypothesis, list[Fit]] = {e: [] for e in hypotheses}
    same = fits.settings.halving.same_place

    def simulate(points: list[tuple[Hypothesis, Fit]]) -> None:
        searches = [Task(f.problem, partial(with_residual, f)) for _, f in points]
        for (e, _), f in zip(points, run(searches), strict=True):
            known = any(abs(f.cost - other.cost) <= same * other.cost for other in places[e])
            places[e] += (f,) if np.isfinite(f.cost) and not known else ()

    simulate([(e, replace(here[e], theta=theta)) for e in ahead for theta in screened[e].begin])
    without = fits(parent).cost
    hidden = [e for e in ahead if any(abs(f.cost - without) <= same * without for f in places[e])]
    simulate([(e, replace(here[e], theta=theta)) for e in hidden for theta in fits.space(e)[1]])
    return {e: Begun(predicted[e], here[e], sorted(places[e], key=lambda f: f.cost)) for e in hypotheses}


def _here(fits: ModelFits, hypothesis: Hypothesis, parent: Hypothesis, screened: Screened) -> Fit:
    """A hypothesis as it stands where it was screened."""
    problem = fits.training(structure_for(fits.rig, hypothesis))
    coordinates, _ = fits.space(hypothesis)
    return search_point(problem, coordinates, screened.theta, _first_states(problem, fits(parent)), screened.residual)


def candidate_of(fits: ModelFits, hypothesis: Hypothesis, parent: Hypothesis) -> Candidate:
    """What a hypothesis is screened with, from a parent's estimates.

    Args:
        fits: fits, the parent's among them.
        hypothesis: the hypothesis to screen.
        parent: the hypothesis from whose estimates it begins.

    Returns:
        The candidate of the score screen.
    """
    structure = structure_for(fits.rig, hypothesis)
    problem = fits.training(structure)
    moves, starts = fits.space(hypothesis)
    own, of_parent = ({*free_names(fits.rig, e, fits.outputs)} for e in (hypothesis, parent))
    chosen, of_parents_choice = {*chosen_names(hypothesis)}, {*chosen_names(parent)}
    shared = of_parent & own | chosen & of_parents_choice
    values = fits(parent).numbers()
    for name, same in handed_on(included_numbers(), own - shared, of_parent):
        values[name] = values[same]
        shared.add(name)
    known = np.array([name in shared for name in structure.names])
    free = np.array([name in own for name in structure.names])
    added = (free | np.array([name in chosen for name in structure.names])) & ~known
    null = theta_of(fits.rig, structure)
    bases = [np.where(known, _in_order(fits, structure, values), start) for start in starts]
    far = any(_far(fits, name, values[name]) for name in shared)  # what the rig lacks may have driven them there
    alike = dict(handed_on(limit_numbers(), own - shared, of_parent))
    bounds = np.tile([-np.inf, np.inf], (len(null), 1))
    bounds[moves.index] = moves.bounds
    off, start = np.where(added, null, bases[0]), _first_states(problem, fits(parent))
    unprobed = [*(starts if far else ())]
    number = added & np.isin(structure.names, hypothesis.numbers)
    if number.any() and not (added & ~number).any():  # nothing else is begun, and numbers have no starts of their own
        limits = fits.settings.screening
        unprobed += [np.where(number, factor * base, base) for base in bases for factor in limits.number_from]
        bases = [np.where(number, (1.0 + limits.number_moved) * base, base) for base in bases]
    if alike:
        handed = [values[alike[name]] if name in alike else bases[0][k] for k, name in enumerate(structure.names)]
        unprobed.append(np.array(handed))
    of_form = np.array([null_of_optional(name) is not None for name in structure.names])
    amplitude = free & added & (number | (null == 0.0) & ~of_form)
    return Candidate(problem, start, off, bases, unprobed, free, amplitude, bounds)


def _in_order(fits: ModelFits, structure: Structure, values: dict[str, float]) -> np.ndarray:
    """Numbers by name in the order of a structure, those not given at their null."""
    return np.array([values.get(n, v) for n, v in zip(structure.names, theta_of(fits.rig, structure), strict=True)])


def _far(fits: ModelFits, name: str, value: float) -> bool:
    """Whether a positive number of the rig was fitted far from what the rig file says."""
    said, far = fits.rig.values.get(name, 0.0), fits.settings.screening.far
    return said > 0.0 and not said / far <= value <= said * far


def _first_states(problem: Problem, fitted: Fit) -> np.ndarray:
    """First states of a fit in another structure's order."""
    start = problem.start.copy()
    for k, name in enumerate(fitted.problem.structure.states):
        if name in problem.structure.states:
            start[:, problem.structure.states.index(name)] = fitted.start[:, k]
    return start
