"""A whole diagnosis in one file: for its page to be drawn again, and for a notebook that goes on with it.

The file is a numpy archive. `tree` is JSON, in which an array is the number of the archive's `array_…`. It holds no program: nothing of it
is run when it is read.
"""

import io
import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import cattrs
import numpy as np

from rwjax.diagnosis.localise.where import Missing, Where
from rwjax.diagnosis.result import Diagnosis
from rwjax.errors import InputError, refuses_other_types

RECORD = "diagnosis.npz"
"""Name of the file in the folder of a diagnosis."""
SCHEMA = "rwjax.record/1"
"""The layout of the file."""


def record(d: Diagnosis) -> bytes:
    """A diagnosis as the content of its file.

    Args:
        d: the diagnosis. The draws by which its missing torque was judged are left out: they are as large as everything else together.

    Returns:
        The bytes.
    """
    arrays: list[np.ndarray] = []

    def put(array: np.ndarray) -> int:
        arrays.append(array)
        return len(arrays) - 1

    converter = cattrs.Converter()
    converter.register_unstructure_hook(np.ndarray, put)
    tree = json.dumps(
        [SCHEMA, converter.unstructure(replace(d, where=_without_draws(d.where)))], default=np.generic.item
    )
    file = io.BytesIO()
    named: dict[str, Any] = {f"array_{k}": array for k, array in enumerate(arrays)}
    np.savez_compressed(file, tree=np.frombuffer(tree.encode("utf-8", "surrogatepass"), np.uint8), **named)
    return file.getvalue()


@refuses_other_types
def read_diagnosis(folder: str | os.PathLike[str]) -> Diagnosis:
    """The diagnosis that `rwjax diagnose -o FOLDER` has written.

    Args:
        folder: the folder of its results.

    Returns:
        The diagnosis, without the draws by which its missing torque was judged.

    Raises:
        InputError: the folder holds none, or one that this version cannot read.
    """
    path = Path(folder) / RECORD
    again = "`rwjax diagnose` writes it anew"
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as archive:
            schema, tree = json.loads(archive["tree"].tobytes().decode("utf-8", "surrogatepass"))
            if schema != SCHEMA:
                raise InputError(f"{path}: is of layout {schema}, and this version reads {SCHEMA}; {again}")
            converter = cattrs.Converter(detailed_validation=False)
            converter.register_structure_hook(np.ndarray, lambda number, _: archive[f"array_{number}"])
            converter.register_structure_hook(float | str, lambda scale, _: scale)
            return converter.structure(tree, Diagnosis)
    except OSError as bad:
        raise InputError(f"{path}: cannot be read: {bad.strerror or bad}; give the folder of a diagnosis") from None
    except InputError:
        raise
    except Exception:  # reason: what is wrong in a damaged archive is said by errors of a dozen kinds
        raise InputError(f"{path}: is no whole diagnosis of this version; {again}") from None


def _without_draws(where: Where | None) -> Where | None:
    """Where the gap lies, each missing torque without its draws."""
    if where is None:
        return None

    def bare(one: Missing) -> Missing:
        none = np.zeros((len(one.torque), 0))
        return replace(one, own=none, still=none, speed=none)

    return replace(where, missing=tuple(bare(one) for one in where.missing))
