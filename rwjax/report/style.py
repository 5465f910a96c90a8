"""Colours, labels and names, the same in every figure."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from rwjax.errors import printable
from rwjax.kinds import half_column

LONGEST_NAME = 40
"""Characters of a name that a figure has room for."""

MEASURED, BEFORE, AFTER, FLOOR = "#222222", "#c1440e", "#1b6ca8", "#8a8a8a"
"""Colours of a measurement, of the model before and after effects are added, and of the noise floor."""
MEASURED_WIDE = "#8a8a8a"
"""Colour of a measurement as a wide line on a page that may be dark."""
AXIS_LABEL = {
    "yaw_rad": "yaw ψ [rad]",
    "yaw_rad_s": "yaw rate ψ' [rad/s]",
    "wheel_rad": "wheel angle θ [rad]",
    "wheel_rad_s": "wheel rate Ω [rad/s]",
    "current_A": "current i [A]",
    "yaw_rate": "yaw rate ψ' [rad/s]",
    "yaw": "yaw ψ, one turn [rad]",
    "wheel_rate": "wheel rate Ω [rad/s]",
    "wheel_angle": "wheel angle θ, one turn [rad]",
    "current": "current i [A]",
    "voltage": "command u [V]",
    "time": "time t [s]",
}
AXIS_LABEL |= {
    "pitch_rad": "pitch θ [rad]",
    "pitch_rad_s": "pitch rate θ' [rad/s]",
    "pitch": "pitch θ [rad]",
    "pitch_rate": "pitch rate θ' [rad/s]",
    **{
        half_column(y, k): f"{k + 1}: {AXIS_LABEL[y]}"
        for y in ("wheel_rad", "wheel_rad_s", "current_A")
        for k in range(2)
    },
}
"""Label of every output by its column of the log, and of every coordinate of a missing torque by its name."""


def drawn_name(name: str) -> str:
    r"""A name from a file as a figure shows it: on one line, not too long, a `$` no beginning of a formula.

    Args:
        name: the name.

    Returns:
        Text for matplotlib.
    """
    text = printable(name)
    text = text if len(text) <= LONGEST_NAME else f"{text[: LONGEST_NAME - 1]}…"
    return text.replace("$", r"\$")


@contextmanager
def any_letters() -> Iterator[None]:
    """Letters that the figures' font lacks are drawn as boxes, without a warning for each.

    Yields:
        Nothing.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        warnings.filterwarnings("ignore", "Matplotlib currently does not support .* natively", UserWarning)
        yield
