"""rwjax: a rig file with inertia and viscous friction alone; the diagnosis has to find what it lacks."""

import rwjax
from experiments.peers.by_rwjax import log_of, run
from experiments.peers.problems import Problem

__all__ = ["fit", "run", "says"]
sentence: list[str] = []


def fit(p: Problem) -> rwjax.Rig:
    """The corrected rig."""
    rig = rwjax.parse_rig(p.bare)
    found = rwjax.diagnose(rig, [log_of(p, rig, p.train)], budget=300.0)
    sentence[:] = [found.sentence]
    return found.corrected


def says() -> str:
    """What it names."""
    return sentence[0]
