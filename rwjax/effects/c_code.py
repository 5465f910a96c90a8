"""Numbers and laws as C code in single precision."""


def literal(value: float) -> str:
    """A number as a C literal.

    Args:
        value: The number [any unit].

    Returns:
        Its digits, as `0.05f`.
    """
    text = f"{value:.9g}"
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


def bell(peak: float, rate: float, power: float) -> str:
    r"""What friction has at small rates above that of sliding, $M_e\,e^{-(w/v_s)^n}$.

    Args:
        peak: Its value at standstill [N m].
        rate: Rate at which it has fallen to 1/e [rad/s].
        power: Exponent of the fall [1].

    Returns:
        A C expression of the rate's size `w`.
    """
    share = f"w / {literal(rate)}"
    inside = f"({share}) * ({share})" if power == 2.0 else f"powf({share}, {literal(power)})"
    return f"{literal(peak)} * expf(-{inside})"
