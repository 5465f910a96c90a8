"""The limit in C, built with gcc into build/."""

import ctypes
import shutil
import subprocess
from functools import cache
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from experiments.control.problem import COULOMB, LIMIT, PERIOD, SMOOTH, STATIC, STEPS, V_S, VISCOUS, I, K, L, b, rig
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP

SOURCE = Path(__file__).with_name("c_limit.c")
BUILD = Path(__file__).parents[2] / "build"
DOUBLES = np.ctypeslib.ndpointer(np.float64, flags="C")


class CRig(ctypes.Structure):
    """`Rig` of the C program."""

    _fields_ = [
        *((name, ctypes.c_double) for name in ("I", "Mc", "Me", "ivs", "gw", "gO", "gi", "hw")),
        *((name, ctypes.c_double * 16) for name in ("E", "P1", "P2")),
        *((name, ctypes.c_double) for name in ("bi", "h", "limit", "smooth", "period")),
    ]


def available() -> bool:
    """Whether there is a compiler, and a processor with vectors of 512 bits."""
    features = Path("/proc/cpuinfo")
    wide = features.exists() and "avx512f" in features.read_text().split()
    return wide and shutil.which("gcc") is not None


@cache
def library() -> ctypes.CDLL:
    """The compiled program."""
    BUILD.mkdir(exist_ok=True)
    target = BUILD / "control_limit.so"
    if not target.exists() or target.stat().st_mtime < SOURCE.stat().st_mtime:
        wide = ["-O3", "-march=native", "-ffast-math", "-mprefer-vector-width=512", "-fopenmp", "-Wno-psabi"]
        compiled = target.with_suffix(".o")
        subprocess.run(["gcc", *wide, "-fPIC", "-c", "-o", compiled, SOURCE], check=True)
        # linked without -ffast-math, which would take subnormal numbers from the whole process
        subprocess.run(["gcc", "-shared", "-fopenmp", "-o", target, compiled, "-lmvec", "-lm"], check=True)
    c = ctypes.CDLL(str(target))
    n, i, f = ctypes.c_long, ctypes.c_int, ctypes.c_double
    bytes_, shorts = (np.ctypeslib.ndpointer(t, flags="C") for t in (np.uint8, np.uint16))
    c.region_grid.argtypes = [n, n, *[DOUBLES] * 5, bytes_]
    c.region_count.argtypes = [n, DOUBLES, DOUBLES, n, *[DOUBLES] * 3, shorts]
    c.sweep.argtypes = [i, i, i, ctypes.POINTER(CRig), *[DOUBLES] * 3, f, DOUBLES, i]
    return c


@cache
def of_rig() -> CRig:
    """The benchmark's rig with the library's own propagator, the wheel's angle left out."""
    structure = structure_of(rig())
    plant = plant_of(structure, jnp.asarray(theta_of(rig(), structure)))
    h = PERIOD / STEPS
    p = EXPONENTIAL_STEP.prepare(plant, jnp.asarray(h))
    keep = [structure.states.index(name) for name in ("psi", "w", "Omega", "i")]
    matrices = (np.asarray(M)[np.ix_(keep, keep)].ravel() for M in (p.E, p.phi1, p.phi2))
    arrays = [(ctypes.c_double * 16)(*m) for m in matrices]
    return CRig(
        I, COULOMB, STATIC - COULOMB, 1.0 / V_S, -VISCOUS, b, -K, 0.0, *arrays, 1.0 / L, h, LIMIT, SMOOTH, PERIOD
    )


def sweep(reference: np.ndarray, kp: np.ndarray, kd: np.ndarray, threads: int) -> np.ndarray:
    """Squared error of every gain pair."""
    cost = np.empty(len(kp))
    library().sweep(len(kp), len(reference), STEPS, ctypes.byref(of_rig()), reference, kp, kd, -1.0, cost, threads)
    return cost
