"""Why does the model of a reaction-wheel testbed differ from the rig? Fit, compare, diagnose, with JAX.

`read_rig` and `read_logs` read the files, and `questions` asks whether they belong together. `fit`, `predict`, `compare` and `diagnose`
work on a rig and its logs. `region`, `tune` and `sweep` choose gains. `simulate` runs the model, by the solver
`Exact` or `Smooth`. Each name is imported when it is first
used. JAX comes with the first that computes, and is set to float64 then; a program that uses JAX of its own before that imports
`rwjax.setup_jax` first.
"""

from importlib import import_module

TYPE_CHECKING = False  # `typing` takes longer to import than all that comes before the command hears Ctrl-C
if TYPE_CHECKING:
    from .errors import InputError as InputError
    from .errors import LogError as LogError
    from .errors import RigError as RigError
    from .rig.model import Rig as Rig
    from .rig.read import parse_rig as parse_rig
    from .rig.read import read_rig as read_rig
    from .rig.write import write_rig as write_rig
    from .logs.log import Log as Log
    from .logs.read import read_log as read_log
    from .logs.read import read_logs as read_logs
    from .logs.write import write_log as write_log
    from .logs.held_out import Fold as Fold
    from .logs.held_out import folds as folds
    from .fitting.questions.ask import questions as questions
    from .fitting.fit import fit as fit
    from .fitting.predict import predict as predict
    from .methods.comparison import compare as compare
    from .diagnosis.diagnosis import diagnose as diagnose
    from .diagnosis.record import read_diagnosis as read_diagnosis
    from .control.region import region as region
    from .control.gain_design import tune as tune
    from .control.sweep import sweep as sweep
    from .simulation.exact import Exact as Exact
    from .simulation.simulate import simulate as simulate
    from .simulation.smooth import Smooth as Smooth

__version__ = "0.1.0"

_HOME = {
    "errors": ("InputError", "LogError", "RigError"),
    "rig.model": ("Rig",),
    "rig.read": ("parse_rig", "read_rig"),
    "rig.write": ("write_rig",),
    "logs.log": ("Log",),
    "logs.read": ("read_log", "read_logs"),
    "logs.write": ("write_log",),
    "logs.held_out": ("Fold", "folds"),
    "fitting.questions.ask": ("questions",),
    "fitting.fit": ("fit",),
    "fitting.predict": ("predict",),
    "methods.comparison": ("compare",),
    "diagnosis.diagnosis": ("diagnose",),
    "diagnosis.record": ("read_diagnosis",),
    "control.region": ("region",),
    "control.gain_design": ("tune",),
    "control.sweep": ("sweep",),
    "simulation.exact": ("Exact",),
    "simulation.simulate": ("simulate",),
    "simulation.smooth": ("Smooth",),
}
"""The module of each public name; the imports above say the same to type checkers, and a test that they agree."""

__all__ = ["__version__", *(name for names in _HOME.values() for name in names)]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    module = next((module for module, names in _HOME.items() if name in names), None)
    if module is None:
        raise AttributeError(f"module `rwjax` has no attribute `{name}`")
    return getattr(import_module(f"rwjax.{module}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
