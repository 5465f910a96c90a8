"""Why does the model of a reaction-wheel testbed differ from the rig? Fit, compare, diagnose, with JAX.

`read_rig` and `read_logs` read the files. `fit`, `predict`, `compare` and `diagnose` work on a rig and its logs. `region`, `tune` and
`sweep` choose gains. `simulate` runs the model. Each name is imported when it is first used: JAX comes with the first that computes.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .rig.model import Rig as Rig

__version__ = "0.1.0"

_HOME = {
    "InputError": "errors",
    "LogError": "errors",
    "RigError": "errors",
    "Rig": "rig.model",
    "read_rig": "rig.read",
    "parse_rig": "rig.read",
    "write_rig": "rig.write",
    "Log": "logs.log",
    "read_log": "logs.read",
    "read_logs": "logs.read",
    "write_log": "logs.write",
    "Fold": "logs.held_out",
    "folds": "logs.held_out",
}
"""Where each public name lives."""

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module `rwjax` has no attribute `{name}`")
    return getattr(import_module(f"rwjax.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
