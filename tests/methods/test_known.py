"""Lines of a first rig file."""

import tomllib

from rwjax.methods.known import Known


def test_a_line_is_toml_and_says_symbol_unit_and_source() -> None:
    line = Known(1.5e-3, "of the model").line("axis.inertia")
    assert tomllib.loads(line) == {"inertia": 1.5e-3}
    assert line.endswith("# I, kg m2: of the model")
