"""Why does the model of a reaction-wheel testbed differ from the rig? Fit, compare, diagnose, with JAX.

The names here read and write a rig and its logs. What is made of them, in the order of the data: `rwjax.fit.rig_fit.fit_rig`,
`rwjax.predict.predict_log`, `rwjax.compare.compare`, `rwjax.diagnose.diagnosis.diagnose`, and `rwjax.control`.
"""

from . import interrupt as interrupt  # Ctrl-C of the command comes before what takes long to import
from . import setup_jax as setup_jax  # float64 and the compilation cache come before any computation

from .errors import InputError as InputError
from .errors import LogError as LogError
from .errors import RigError as RigError
from .rig import Rig as Rig
from .rig import parse_rig as parse_rig
from .rig import read_rig as read_rig
from .rig import write_rig as write_rig
from .log import Log as Log
from .log import read_log as read_log
from .log import read_logs as read_logs
from .log import write_log as write_log
from .held_out import Fold as Fold
from .held_out import folds as folds

__version__ = "0.1.0"
