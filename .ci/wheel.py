"""Run by a Python that has the wheel: it holds what it needs, every module imports, and none comes from the repository."""

import importlib
import pkgutil
import sys
import sysconfig
import warnings
from importlib.resources import files
from pathlib import Path

import rwjax

assert Path(rwjax.__file__).is_relative_to(sysconfig.get_path("purelib")), rwjax.__file__
PAGE = ("report.html.j2", "motion.js", "uplot/uPlot.iife.min.js", "uplot/uPlot.min.css", "uplot/LICENSE")
assert all((files("rwjax") / name).is_file() for name in ("py.typed", *(f"report/{part}" for part in PAGE)))
warnings.filterwarnings("error", module=r"rwjax(\.|$)")  # what a later Python gives up
for module in pkgutil.walk_packages(rwjax.__path__, "rwjax."):
    if module.name != "rwjax.__main__":
        importlib.import_module(module.name)
assert not {"tests", "experiments", "firmware"} & {name.partition(".")[0] for name in sys.modules}
