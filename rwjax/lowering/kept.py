"""Lowered programs of this process and on disk: what was lowered once is loaded from there."""

import json
import logging
import os
from collections.abc import Callable, Sequence
from threading import Lock

import llvmlite
import numpy as np

from rwjax.lowering import machine, program_files
from rwjax.lowering.arrays import Spread
from rwjax.lowering.emitter import Unsupported
from rwjax.lowering.machine import processor
from rwjax.lowering.program import Code, Lowered, Slot, build

LANES = 8
"""Runs side by side in a vector [1]."""
programs: dict[object, "Lowered | None"] = {}
"""Programs of this process, None for those that run through XLA."""
_locks: dict[object, Lock] = {}
_lock = Lock()
THROUGH_XLA = "RWJAX_THROUGH_XLA"
"""Environment variable that, set to 1, has XLA run all programs."""


def lowered(
    name: str,
    key: object,
    function: Callable,
    arguments: Sequence[np.ndarray | np.generic],
    given: Sequence[Spread],
    keep: bool,
    lanes: int = LANES,
) -> Lowered | None:
    """A function as machine code.

    Args:
        name: Name under which it is kept.
        key: What it depends on besides the shapes of its arguments.
        function: The function of one run and one direction.
        arguments: Arguments of one run and one direction [any unit].
        given: Over what they differ.
        keep: Whether it may be kept on disk: whether the library's source and the key determine it.
        lanes: Runs side by side in a vector [1].

    Returns:
        The program; None where it runs through XLA: because it holds what is not lowered, or everything does.
    """
    if os.environ.get(THROUGH_XLA) == "1":
        return None
    whole = (name, key, tuple((a.shape, a.dtype.char) for a in arguments), tuple(given), lanes)
    if whole in programs:
        return programs[whole]
    with _lock:
        lock = _locks.setdefault(whole, Lock())
    with lock:
        if whole not in programs:
            programs[whole] = _found(name, whole, function, arguments, given, keep, lanes)
    return programs[whole]


def _found(
    name: str,
    whole: object,
    function: Callable,
    arguments: Sequence[np.ndarray | np.generic],
    given: Sequence[Spread],
    keep: bool,
    lanes: int,
) -> Lowered | None:
    key = (whole, processor(), machine.EFFORT, llvmlite.__version__)
    path = program_files.file_of("lowered", name, key) if keep else None
    if (data := program_files.read(path)) is not None:
        return Lowered(_unpacked(data))
    try:
        code = build(function, arguments, given, lanes)
    except Exception as error:  # XLA runs every program of JAX, and tells the user of a fault in an effect of their own
        what = str(error) if isinstance(error, Unsupported) else f"{type(error).__name__}: {error}"
        logging.getLogger("rwjax").warning("rwjax: note: %s runs through XLA, which is slower: %s", name, what)
        return None
    program_files.write(path, _packed(code))
    return Lowered(code)


def _packed(code: Code) -> bytes:
    about = {"lanes": code.lanes, "arguments": code.arguments, "results": code.results, "workspace": code.workspace}
    return json.dumps(about).encode() + b"\n" + code.code


def _unpacked(data: bytearray) -> Code:
    about, _, code = bytes(data).partition(b"\n")
    held = json.loads(about)

    def slots(every: list) -> tuple[Slot, ...]:
        return tuple(Slot(tuple(shape), kind, Spread(*spread)) for shape, kind, spread in every)

    return Code(code, held["lanes"], slots(held["arguments"]), slots(held["results"]), tuple(held["workspace"]))
