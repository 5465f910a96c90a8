"""Functions of `rwjax.lowering` compiled for one vector unit or another, called with arrays; errors in units in the last place."""

from collections.abc import Callable
from ctypes import CFUNCTYPE, c_int64, c_void_p
from functools import cache

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir

from rwjax.lowering.functions import call

HOST = ""
OLD = "-avx512f,-avx2,-avx,-fma"  # what is left is SSE4
ENGINES = []  # compiled code lives as long as its engine
Function = Callable[..., np.ndarray]


@cache
def _ready() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


@cache
def compiled(name: str, operands: int, lanes: int | None = 8, unit: str = HOST, flush: bool = False) -> Function:
    """A function of arrays, as long as a multiple of the lanes."""
    return compiled_body(lambda builder, *values: call(builder, name, *values), operands, lanes, unit, flush)


def machine_code(module: ir.Module, unit: str) -> tuple[llvm.ModuleRef, llvm.TargetMachine]:
    """A module after LLVM's passes, and the machine it is for."""
    _ready()
    parsed = llvm.parse_assembly(str(module))
    parsed.verify()
    features = llvm.get_host_cpu_features().flatten()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=f"{features},{unit}" if unit else features, opt=3
    )
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=2))
    builder.getModulePassManager().run(parsed, builder)
    return parsed, machine


def compiled_body(
    body: Callable, operands: int, lanes: int | None = 8, unit: str = HOST, flush: bool = False
) -> Function:
    """A loop over arrays around what `body` writes."""
    parsed, machine = machine_code(looped(body, operands, lanes, flush), unit)
    engine = llvm.create_mcjit_compiler(parsed, machine)
    engine.finalize_object()
    ENGINES.append(engine)
    run = CFUNCTYPE(None, c_int64, *[c_void_p] * (operands + 1))(engine.get_function_address("loop"))

    def function(*arrays: np.ndarray) -> np.ndarray:
        given = [np.ascontiguousarray(np.asarray(a, float).ravel()) for a in np.broadcast_arrays(*arrays)]
        size = -len(given[0]) % (lanes or 1)
        padded = [np.concatenate([a, np.full(size, 0.5)]) for a in given]
        out = np.empty_like(padded[0])
        run(len(out) // (lanes or 1), out.ctypes.data, *(a.ctypes.data for a in padded))
        return out[: len(given[0])]

    return function


def looped(body: Callable, operands: int, lanes: int | None, flush: bool) -> ir.Module:
    module = ir.Module()
    double, word = ir.DoubleType(), ir.IntType(64)
    kind = double if lanes is None else ir.VectorType(double, lanes)
    pointer = ir.PointerType(double)
    loop = ir.Function(module, ir.FunctionType(ir.VoidType(), [word] + [pointer] * (operands + 1)), "loop")
    entry, head, end = (loop.append_basic_block(text) for text in ("entry", "head", "end"))
    builder = ir.IRBuilder(entry)
    if flush:
        _flush_to_zero(builder)
    builder.branch(head)
    builder.position_at_end(head)
    k = builder.phi(word)
    k.add_incoming(word(0), entry)
    first = builder.mul(k, word(lanes or 1))
    places = [builder.bitcast(builder.gep(a, [first]), ir.PointerType(kind)) for a in loop.args[1:]]
    values = [builder.load(place, align=8) for place in places[1:]]
    builder.store(body(builder, *values), places[0], align=8)
    following = builder.add(k, word(1))
    k.add_incoming(following, builder.block)
    builder.cbranch(builder.icmp_signed("<", following, loop.args[0]), head, end)
    builder.position_at_end(end)
    if flush:
        _flush_to_zero(builder, 0x1F80)
    builder.ret_void()
    return module


def _flush_to_zero(builder: ir.IRBuilder, state: int = 0x1F80 | 0x8040) -> None:
    """Denormal operands and results count as 0, as in XLA's programs; 0x1F80 is how a process starts."""
    cell = builder.alloca(ir.IntType(32))
    builder.store(ir.Constant(ir.IntType(32), state), cell)
    kind = ir.FunctionType(ir.VoidType(), [cell.type])
    name = "llvm.x86.sse.ldmxcsr"
    known = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
    builder.call(known, [cell])


def ulps(found: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Distance to the exact value, in units in the last place of its nearest double; infinite where one is none."""
    with np.errstate(all="ignore"):
        nearest = np.asarray(exact, float)
    same = (found == nearest) | (np.isnan(found) & np.isnan(nearest))
    with np.errstate(all="ignore"):
        away = np.abs(found.astype(np.longdouble) - exact) / np.spacing(np.maximum(np.abs(nearest), 2.0**-1022))
    away = np.where(np.isfinite(away), away, np.inf)
    return np.where(same, np.minimum(away, 0.5), away).astype(float)
