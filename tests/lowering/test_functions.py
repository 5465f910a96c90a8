"""Every function in every number of lanes and on every vector unit: the same bits, no library, one body in a module."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from llvmlite import ir

from rwjax.lowering.functions import NAMES, PARTS, call
from tests.lowering.compiled import OLD, compiled, looped, machine_code

TWO = {"pow", "maximum", "minimum"}
ONE_VALUE = [name for name in NAMES if name not in {whole for whole, _ in PARTS.values()}]
ANY = st.floats(allow_subnormal=False)
UNITS = ["-avx512f", "-fma,-avx512f", OLD]


def _arguments(name: str) -> list[np.ndarray]:
    rng = np.random.default_rng(5)
    size = 10.0 ** np.concatenate([rng.uniform(-3.0, 3.0, 3000), rng.uniform(-300.0, 300.0, 1000)])
    x = np.concatenate([size * rng.choice([-1.0, 1.0], 4000), [0.0, -0.0, np.inf, -np.inf, np.nan, 1.0, -1.0, 2.5]])
    return [x, np.concatenate([x[::-1][:4000:2], rng.integers(-9, 9, len(x) - 2000)])][: 1 + (name in TWO)]


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    """The same bits; a NaN is a NaN, whatever its payload."""
    return bool(np.all((a.view(np.int64) == b.view(np.int64)) | (np.isnan(a) & np.isnan(b))))


@pytest.mark.parametrize("name", ONE_VALUE)
def test_older_vector_units_give_the_same_bits(name: str) -> None:
    given_ = _arguments(name)
    here = compiled(name, len(given_))(*given_)
    for unit in UNITS:
        assert _same(compiled(name, len(given_), unit=unit)(*given_), here), unit


@pytest.mark.parametrize("name", ONE_VALUE)
def test_any_number_of_lanes_gives_the_bits_of_single_numbers(name: str) -> None:
    given_ = _arguments(name)
    single = compiled(name, len(given_), lanes=None)(*given_)
    for lanes in (2, 3, 8, 16):
        assert _same(compiled(name, len(given_), lanes=lanes)(*given_), single), lanes


@given(st.sampled_from(ONE_VALUE), arrays(float, (2, 8), elements=ANY))
def test_lanes_know_nothing_of_each_other(name: str, x: np.ndarray) -> None:
    count = 1 + (name in TWO)
    together = compiled(name, count)(*x[:count])
    turned = compiled(name, count)(*np.roll(x[:count], 3, axis=1))
    assert _same(np.roll(together, 3), turned)
    assert _same(together, compiled(name, count, lanes=None)(*x[:count]))


@given(arrays(float, (2, 16), elements=st.floats()))
def test_larger_and_smaller_numbers_and_signs_are_numpys(x: np.ndarray) -> None:
    with np.errstate(invalid="ignore"):
        assert np.array_equal(compiled("maximum", 2)(*x), np.maximum(*x), equal_nan=True)
        assert np.array_equal(compiled("minimum", 2)(*x), np.minimum(*x), equal_nan=True)
        sign = compiled("sign", 1)(x)
        assert np.array_equal(sign, np.sign(x).ravel(), equal_nan=True)
    assert np.array_equal(np.signbit(sign[sign == 0.0]), np.signbit(x.ravel()[sign == 0.0]))


@given(arrays(float, 9, elements=st.floats() | st.integers(-99, 99).map(lambda n: n / 2.0)))
def test_integers_near_a_number_are_numpys(x: np.ndarray) -> None:
    for name, of_numpy in (("floor", np.floor), ("ceil", np.ceil), ("round_even", np.round)):
        assert _same(compiled(name, 1)(x), of_numpy(x)), name


@pytest.mark.parametrize("name", ONE_VALUE)
def test_no_library_is_called(name: str) -> None:
    """Only what a processor before SSE4.1 lacks would be a call; JAX needs a later one."""
    module = looped(lambda builder, *x: call(builder, name, *x), 1 + (name in TWO), 8, False)
    for unit in ("", OLD):
        parsed, machine = machine_code(module, unit)
        text = machine.emit_assembly(parsed)
        called = {line.split()[1] for line in text.splitlines() if line.strip().startswith(("call", "jmp\t"))}
        known = {f.name for f in parsed.functions if not f.is_declaration} | {f'"{f.name}"' for f in parsed.functions}
        assert not {c for c in called if c[0].isalpha()} - known


def test_a_body_stands_once_in_a_module_and_nobody_outside_sees_it() -> None:
    def body(builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
        both = [call(builder, name, x) for name in ("sin", "cos", "sin", "exp")]
        return builder.fadd(builder.fadd(both[0], both[1]), builder.fadd(both[2], both[3]))

    module = looped(body, 1, 8, False)
    ours = [f for f in module.functions if f.name.startswith("rwjax.")]
    angles = ["rwjax.large_angles.1", "rwjax.large_angles.8", "rwjax.sine_and_cosine.8"]
    assert sorted(f.name for f in ours) == ["rwjax.exp.8", *angles]
    assert {f.linkage for f in ours} == {"internal"}


def test_operands_of_other_types_are_refused() -> None:
    module = ir.Module()
    double, single = ir.DoubleType(), ir.FloatType()
    for kinds in ([single], [ir.VectorType(double, 1)], [double, ir.VectorType(double, 8)]):
        function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), f"f{len(module.functions)}")
        builder = ir.IRBuilder(function.append_basic_block())
        with pytest.raises(TypeError, match="takes doubles, or vectors of two or more doubles; got"):
            call(builder, "exp", *function.args)


@pytest.mark.parametrize("name", ONE_VALUE)
def test_flushing_denormal_numbers_changes_no_normal_result(name: str) -> None:
    given_ = _arguments(name)
    plain, flushed = (compiled(name, len(given_), flush=flush)(*given_) for flush in (False, True))
    normal = ~(np.abs(plain) < 2.0**-1022)
    assert np.count_nonzero(normal) > 500
    assert _same(flushed[normal], plain[normal])
    assert np.all(flushed[~normal] == 0.0)
