"""A diagnosis made by hand, for figures and pages that nobody wants to wait for."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from rwjax.diagnosis.estimates import Estimates
from rwjax.diagnosis.gap import Gap, HeldOut
from rwjax.diagnosis.localise.where import Missing, Where
from rwjax.diagnosis.result import Diagnosis, Ranked
from rwjax.diagnosis.settings import Settings
from rwjax.diagnosis.waterfall import Rung
from rwjax.logs.coverage import Split
from rwjax.report.plots import plot_runs
from tests.systems import platform, record

TIME = 0.1 * np.arange(50)
BEFORE, AFTER, FLOOR = 0.5, 0.11, 0.1
MARK = "<b>&"
"""What a name from a file may hold and a page must escape."""


def rung(*names: str, rms: float) -> Rung:
    """A step of the waterfall."""
    number = {"axis.inertia": (0.1, 0.001)}
    return Rung(names, rms, number, {"axis.inertia": (0.5, 1.0)}, {f"{n}.M_c": (0.2, 0.01) for n in names})


def held_out(rms: float) -> HeldOut:
    """Errors of both logs: one value throughout."""
    error = {k: {"yaw_rad": np.full(50, rms)} for k in (0, 1)}
    flat = {"yaw_rad": np.full(100, rms**2)}
    return HeldOut(
        flat, {"yaw_rad": np.full(100, FLOOR)}, {"yaw_rad": np.zeros(100, int)}, {"yaw_rad": np.zeros(100, int)}, error
    )


def diagnosed(**changed: Any) -> Diagnosis:
    """Coulomb friction found on a platform by two held-out logs."""
    rig = replace(platform("viscous = 0.02"), name=f"bench {MARK}")
    logs = tuple(replace(record(TIME, np.zeros(50)), name=f"{name} {MARK}.csv") for name in ("a", "b"))
    angle = np.linspace(-1.0, 1.0, 5000)
    none = np.zeros((5000, 0))
    missing = Missing(0, 0.2 * np.sign(angle), np.full(5000, 0.01), {"yaw_rate": angle}, none, none, none)
    found = {
        "rig": rig,
        "logs": logs,
        "verdict": "effect",
        "complete": True,
        "untried": (),
        "restricted": False,
        "uninformative": None,
        "effects": ("axis.coulomb",),
        "alternatives": (),
        "ranking": (Ranked("axis.coulomb", 0.9, AFTER), Ranked("none", 0.1, None)),
        "where": Where("yaw_rate", 0.8, "yaw_rate", None, {"time": 0.1, "yaw_rate": 0.8}, (missing,)),
        "windows": (),
        "left": None,
        "left_torque": None,
        "signal": "yaw_rad",
        "gaps": {"yaw_rad": Gap(BEFORE, AFTER, FLOOR, 0.975, (0.9, 0.99), 0.99)},
        "held_out": "marked",
        "next_experiment": "none needed",
        "proposal": None,
        "waterfall": (rung(rms=BEFORE), rung("axis.coulomb", rms=AFTER)),
        "alternatives_waterfall": (),
        "refused": {"axis.spring": f"a reason {MARK}"},
        "remarks": (f"a remark {MARK}",),
        "split": Split(),
        "corrected": rig,
        "before": held_out(BEFORE),
        "after": held_out(AFTER),
        "settings": Settings(),
        "estimates": Estimates({}, np.zeros((0, 0))),
    }
    made = object.__new__(Diagnosis)
    made.__dict__.update(found | changed)
    return made


def draws_one_figure(patch: pytest.MonkeyPatch) -> None:
    """Has a page hold one figure, that with the logs' names: it takes a fifth of the time."""
    patch.setattr("rwjax.report.html.figures_of", lambda d: {"runs": (plot_runs, (6.0, 2.0))})
