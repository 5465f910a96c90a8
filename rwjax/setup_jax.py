"""Float64 and the persistent compilation cache; imported before anything that computes with JAX."""

import logging
import os
import sys
import warnings
from pathlib import Path

import jax
import jax.monitoring

from rwjax.cache_folder import VARIABLE, has_room, opened, place, trim_now_and_then
from rwjax.errors import InputError


def _current_folder() -> str | None:
    return getattr(jax.config, "jax_compilation_cache_dir", None)  # which type checkers do not know


def _keep_programs(folder: Path | None) -> None:
    """Has JAX keep its programs in a folder, if there is one that only the user can change."""
    try:
        usable = folder is not None and opened(folder)
    except InputError as error:
        if VARIABLE in os.environ:
            raise InputError(f"{VARIABLE}: {error}") from None
        logging.getLogger("rwjax").warning("rwjax: note: programs are compiled anew: %s", error)
        usable = False
    jax.config.update("jax_compilation_cache_dir", str(folder) if usable else None)
    if folder and usable and not has_room(folder):
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", sys.maxsize)


def _trim(event: str, **_: str | int) -> None:
    """Follows what JAX does; a miss is what it says of a program that it is about to write."""
    folder = _current_folder()
    if folder and event == "/jax/compilation_cache/cache_misses":
        trim_now_and_then(Path(folder))


jax.config.update("jax_enable_x64", True)
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
if _current_folder() in (None, os.environ.get(VARIABLE)):  # else the program that uses the library has set its own
    _keep_programs(place())
jax.monitoring.register_event_listener(_trim)
# A program that cannot be read or written costs time and nothing else.
warnings.filterwarnings("ignore", message="Error (reading|writing) persistent compilation cache entry")
