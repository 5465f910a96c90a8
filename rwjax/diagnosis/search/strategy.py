"""Strategy: how the hypothesis is searched for that explains the training logs."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.search.choice import Choice


class Strategy(ABC):
    """A search among hypotheses: it decides which of them are fitted, and which one is chosen."""

    @abstractmethod
    def choose(self, fits: ModelFits, candidates: Sequence[str]) -> Choice:
        """Chooses a hypothesis by fits to the training logs.

        Args:
            fits: the rig's fits, that of the rig as it is among them; the search adds its own.
            candidates: names that might be missing: effects, and `parameter.NAME` for fixed numbers that may be wrong.

        Returns:
            The choice, with what was tried.
        """
