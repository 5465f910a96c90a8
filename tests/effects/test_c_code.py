"""C code of numbers and laws."""

from rwjax.effects.c_code import bell, literal


def test_every_number_is_a_float_in_c() -> None:
    assert [literal(v) for v in (2.0, 0.05, -1e-9, 1e12)] == ["2.0f", "0.05f", "-1e-09f", "1e+12f"]


def test_a_square_needs_no_power() -> None:
    assert bell(0.3, 0.1, 2.0) == "0.3f * expf(-(w / 0.1f) * (w / 0.1f))"
    assert bell(0.3, 0.1, 1.5) == "0.3f * expf(-powf(w / 0.1f, 1.5f))"
