"""The processor: LLVM's code for it, and functions of object code that can be called."""

import ctypes
from collections.abc import Callable
from functools import cache
from threading import Lock

import llvmlite.binding as llvm

PASSES = (
    "post_order_function_attributes",
    "always_inliner",
    "instruction_combine",
    "new_gvn",
    "simplify_cfg",
    "dead_code_elimination",
)
"""Passes over a module. It comes without repeats, and with what stays the same in a loop before the loop: LLVM's own order of passes
takes twice as long and makes code that is not measurably faster."""

OPTIONS = ("-disable-lsr",)
"""LLVM's options of all code that this process makes. Of the addresses in loops nothing else would be made: it takes a third of the time
of a program with derivatives, and these run as fast without it."""

EFFORT = 1
"""How hard LLVM tries for fast code, 0 to 3 [1]. With 2 it takes longer and makes the same code but for a few bytes. With 0 it is done
soonest, and programs run slower. The numbers were the same in all programs that were tried."""

_lock = Lock()  # LLVM's contexts are not for several threads at once
_engines: list = []  # what was loaded stays while the process lives


@cache
def _target() -> llvm.Target:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    for option in OPTIONS:
        llvm.set_option("rwjax", option)
    return llvm.Target.from_default_triple()


@cache
def processor() -> tuple[str, str]:
    """Name of this processor, and what it can do, as LLVM writes it.

    Returns:
        Name and features.
    """
    _target()
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def doubles_in_a_vector() -> int:
    """How many doubles a vector of this processor holds.

    Returns:
        The number [1].
    """
    features = processor()[1].split(",")
    return 8 if "+avx512f" in features else 4 if "+avx" in features else 2


def _machine(features: str) -> llvm.TargetMachine:
    name, own = processor()
    joined = ",".join(part for part in (own, features) if part)
    return _target().create_target_machine(cpu=name, features=joined, opt=EFFORT, reloc="pic", codemodel="jitdefault")


def compiled(text: str, features: str = "") -> bytes:
    """Object code of a module.

    Args:
        text: The module in LLVM's own language.
        features: What the processor is to be taken to have or lack besides its own, as `-avx512f`.

    Returns:
        The object code.
    """
    with _lock:
        machine = _machine(features)
        module = llvm.parse_assembly(text, context=llvm.create_context())
        passes = llvm.create_new_module_pass_manager()
        for name in PASSES:
            getattr(passes, f"add_{name}_pass")()
        passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
        return machine.emit_object(module)


def loaded(code: bytes, name: str, result: type | None, *arguments: type) -> Callable[..., None]:
    """A function of object code.

    Args:
        code: The object code.
        name: Name of the function.
        result: Type of its result, of `ctypes`.
        *arguments: Types of its arguments.

    Returns:
        The function.
    """
    with _lock:
        empty = llvm.parse_assembly("", context=llvm.create_context())
        engine = llvm.create_mcjit_compiler(empty, _machine(""))
        engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        engine.finalize_object()
        _engines.append(engine)
        return ctypes.CFUNCTYPE(result, *arguments)(engine.get_function_address(name))
