r"""Law: how much of the missing torque a free-form law of one coordinate explains.

The law is the mean of the missing torque in bins of the coordinate that hold equally many samples. It explains

$$ V = \sum_b W_b\, m_b^2, \qquad W_b = \sum_b w, \qquad m_b = \frac{\sum_b w\,\tau}{W_b}, $$

with the weights $w$ of the smoother. The same steps with readings that the fitted rig would have given tell what chance explains.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis, coordinate_of, structure_for
from rwjax.diagnosis.localise.body_motion import Own, read_body
from rwjax.diagnosis.localise.regimes import weights
from rwjax.diagnosis.localise.where import Missing, missing_torque, tells_torque
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.fitting.prediction import every_output


class Law(NamedTuple):
    """What a law of a coordinate explains.

    Attributes:
        explains: weighted square of the missing torque that it explains, beyond chance [1].
        chance: standard deviation of what chance alone explains [1].
    """

    explains: float
    chance: float


def laws(fits: ModelFits, hypothesis: Hypothesis, coordinates: Sequence[str]) -> dict[str, Law]:
    """Free-form laws of the torque that a hypothesis still misses.

    Args:
        fits: a fit of the hypothesis among them.
        hypothesis: the hypothesis.
        coordinates: coordinates, in the words of `diagnosis.json`.

    Returns:
        By coordinate the law; none where no log tells the coordinate or the motion, and none where the motion does not tell the torque
        (`tells_torque`).
    """
    structure = structure_for(fits.rig, hypothesis)
    if not tells_torque(structure):
        return {}
    fitted, limits = fits.known(hypothesis), fits.settings.localisation
    body = "wheel" if structure.kind == "wheel" else "yaw"
    clean = every_output(fitted.problem, fitted.theta, fitted.start)
    read = {k: read_body(fitted, k, body, limits, Own(clean[k], limits.draws)) for k in fits.train}
    missing = [missing_torque(fitted, k, clean[k], r, limits) for k, r in read.items() if r is not None]
    told = [c for c in dict.fromkeys(coordinates) if missing and all(c in m.coordinates for m in missing)]
    return {c: _law(missing, c, fits.settings.partial.bins) for c in told}


def _law(missing: list[Missing], coordinate: str, bins: int) -> Law:
    """The law of one coordinate."""
    c = np.concatenate([m.coordinates[coordinate] for m in missing])
    w = np.concatenate([weights(m.deviation) for m in missing])
    torque = np.concatenate([np.column_stack([m.torque, m.own]) for m in missing])
    edges = np.quantile(c, np.linspace(0.0, 1.0, bins + 1)[1:-1])
    index = np.searchsorted(edges, c)
    mass = np.bincount(index, w, bins)
    sums = np.stack([np.bincount(index, w * column, bins) for column in torque.T])
    explained = np.sum(sums**2 / np.maximum(mass, 1e-300), axis=1)
    return Law(float(explained[0] - np.mean(explained[1:])), float(np.std(explained[1:])))


def law_left(fits: ModelFits, larger: Hypothesis, smaller: Hypothesis, name: str) -> float | None:
    """What a free-form law of a name's coordinate still explains with the name, against what it explains without.

    Args:
        fits: fits of both hypotheses among them.
        larger: the hypothesis with the name.
        smaller: the hypothesis without it.
        name: the name.

    Returns:
        The share [1]; None where a measured acceleration shows no such law.
    """
    coordinate = coordinate_of(name)
    before, after = (laws(fits, e, [coordinate]).get(coordinate) for e in (smaller, larger))
    if before is None or after is None or before.explains <= fits.settings.partial.sigmas * before.chance:
        return None
    return max(after.explains - fits.settings.partial.sigmas * after.chance, 0.0) / before.explains
