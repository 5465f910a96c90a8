"""The rules by the names that tables and tests show."""

from collections.abc import Callable

from experiments.house.circles import cyclic_modules
from experiments.house.code import crowded_root, effect_mentions, long_functions, stray_limits
from experiments.house.docstrings import undocumented
from experiments.house.mirror import private_in_tests, untested_modules
from experiments.house.tree import Finding, Tree

RULES: dict[str, Callable[[Tree], list[Finding]]] = {
    "modules in the root": crowded_root,
    "effects named outside effects/": effect_mentions,
    "limits outside the diagnosis settings": stray_limits,
    "imports in a circle": cyclic_modules,
    "long functions": long_functions,
    "public functions not fully documented": undocumented,
    "modules without a mirrored test": untested_modules,
    "tests that touch private members": private_in_tests,
}
