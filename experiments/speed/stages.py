"""Where a diagnosis spends its time: `python -m experiments.speed.stages [CASE …]`, the cases of `experiments.speed.diagnosis`.

Each case is diagnosed twice in this process; the second time, with every program compiled, is split over its stages, each without
the stages inside it.
"""

import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

from experiments.speed.diagnosis import CASES, write
from experiments.speed.table import machine, show, timed
from rwjax import read_logs, read_rig
from rwjax.diagnosis import diagnosis, exact_fits
from rwjax.diagnosis.model_comparison import ModelComparison
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.score_screen import ScoreScreen
from rwjax.diagnosis.search import forward_backward, successive_halving
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from rwjax.report.html import write_report

STAGES = {
    "single fits, that of the rig as it is": ((ModelFits, "__call__"),),
    "probes of all candidates, where to begin": ((ScoreScreen, "predict"),),
    "rounds of successive halving": ((SuccessiveHalving, "_halve"),),
    "fits to the end": ((ModelFits, "finish"),),
    "close ones until nothing is gained": ((ModelFits, "settle"),),
    "exact derivatives": (
        (exact_fits, "fit_exactly"),
        (forward_backward, "fit_exactly"),
        (successive_halving, "fit_exactly"),
    ),
    "searches from all places": ((SuccessiveHalving, "from_all_places"),),
    "information criterion": ((ModelComparison, "_seen"),),
    "to the last digit": ((diagnosis, "polish"),),
    "held-out runs": ((diagnosis, "held_out"),),
    "where": ((diagnosis, "locate"),),
    "report": ((sys.modules[__name__], "write_report"),),
}
"""The functions of each stage; one that several modules import is followed in each of them."""


class Clock:
    """Seconds of every stage, without those inside it."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = defaultdict(float)
        self.inside: list[float] = []

    def follow(self, stage: str, owner: Any, name: str) -> None:
        """Times a function or method from now on."""
        setattr(owner, name, self._timed(stage, getattr(owner, name)))

    def _timed(self, stage: str, call: Callable) -> Callable:
        @wraps(call)
        def timed_call(*arguments: Any, **named: Any) -> Any:
            self.inside.append(0.0)
            begin = time.perf_counter()
            try:
                return call(*arguments, **named)
            finally:
                whole = time.perf_counter() - begin
                self.spent[stage] += whole - self.inside.pop()
                if self.inside:
                    self.inside[-1] += whole

        return timed_call


def main(names: list[str]) -> None:
    """Prints a table of all cases."""
    clock, columns = Clock(), []
    for stage, followed in STAGES.items():
        for owner, name in followed:
            clock.follow(stage, owner, name)
    for name in names or CASES:
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder) / log for log in write(CASES[name], Path(folder))]
            rig = read_rig(Path(folder) / "rig.toml")

            def answer(folder: str = folder, files: list[Path] = files, rig: Any = rig) -> None:
                write_report(diagnosis.diagnose(rig, read_logs(files, rig)), Path(folder))

            answer()
            clock.spent.clear()
            whole, _ = timed(answer)
        columns.append({**clock.spent, "all else": whole - sum(clock.spent.values()), "together": whole})
    rows = [[stage, *(f"{c.get(stage, 0.0):.1f}" for c in columns)] for stage in (*STAGES, "all else", "together")]
    show(f"Seconds of a diagnosis, programs compiled; {machine()}", ("stage", *(names or CASES)), rows)


if __name__ == "__main__":
    main(sys.argv[1:])
