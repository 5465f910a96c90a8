"""What a process of its own takes: time to the fitted numbers, time until a structure's programs answer, most memory held."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from experiments.speed import diagnosis
from experiments.speed.lowering import XLA, by_xla
from experiments.speed.problem import COUNT, EFFECTS, STRIBECK, log, rig, with_effects
from experiments.speed.table import ratio, seconds, show, timed
from rwjax import write_log
from rwjax.cache_folder import VARIABLE
from rwjax.logs.log import Log
from rwjax.rig.model import Rig
from rwjax.rig.write import write_rig

OURS = "rwjax"
STRUCTURES: dict[str, Callable[[Path], object]] = {
    "platform, Coulomb friction": lambda folder: put(folder, rig(), log()),
    "platform, Stribeck friction": lambda folder: put(folder, with_effects(STRIBECK)[0], log()),
    f"platform, {len(EFFECTS)} effects": lambda folder: put(folder, with_effects(*EFFECTS)[0], log()),
    "reaction": lambda folder: diagnosis.write(diagnosis.REACTION, folder),
    "wheel": lambda folder: diagnosis.write(diagnosis.WHEEL, folder),
}
"""Rigs with their logs; each writes its files into a folder."""


def put(folder: Path, believed: Rig, record: Log) -> None:
    """Writes a rig and a log of the benchmark's problem."""
    counts = np.rint(record.outputs["yaw_rad"] / COUNT).astype(int)
    write_log(folder / "log.csv", {"time_s": record.time, "voltage_V": record.command, "yaw_counts": counts})
    (folder / "rig.toml").write_text(write_rig(believed))


def answer(cache: Path, module: str, *arguments: str) -> dict:
    """What a module prints as JSON, in a process with a cache of its own."""
    environment = os.environ | {VARIABLE: str(cache)}
    command = [sys.executable, "-m", module, *arguments]
    done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def ways(call: Callable[..., dict]) -> dict[str, Callable[..., dict]]:
    """A call as it is and with the yardstick's programs."""
    return {OURS: call, XLA: by_xla(call)}


@contextmanager
def caches(names: Sequence[str]) -> Iterator[tuple[Path, dict[str, Path]]]:
    """A folder, and an empty one in it for the programs of each name."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder), {name: Path(folder) / f"cache{k}" for k, name in enumerate(names)}


def fresh(rounds: int = 5) -> None:
    """From a process's start to the fitted numbers, by stages, with a cold and a warm cache of compiled programs."""

    def once(folder: Path, cache: Path) -> dict:
        begin = time.monotonic()
        spent, found = timed(answer, cache, "experiments.speed.fresh", str(folder))
        return found | {"start to numbers": found.pop("fitted at") - begin, "process": spent}

    calls = ways(once)
    with caches([*calls]) as (folder, cache):
        put(folder, rig(), log())
        found = {name: [call(folder, cache[name])] for name, call in calls.items()}
        for _ in range(rounds):
            for name, call in calls.items():
                found[name].append(call(folder, cache[name]))
    stages = [name for name in found[OURS][0] if name != "cost"]
    rows = []
    for name, (cold, *warm) in found.items():
        middle = {stage: float(np.median([w[stage] for w in warm])) for stage in stages}
        rows += [
            [name, kind, *(seconds(s[stage]) for stage in stages)] for kind, s in (("cold", cold), ("warm", middle))
        ]
    numbers = {name: [w["start to numbers"] for w in warm] for name, (_, *warm) in found.items()}
    show("Fresh process (its whole time holds a second fit)", ["programs", "cache", *stages], rows)
    print(f"warm, from start to numbers: {ratio(numbers[OURS], numbers[XLA]):.2f} times the time with {XLA}\n")


def compile(rounds: int = 3, names: Sequence[str] = tuple(STRUCTURES)) -> None:
    """Time from nothing to a structure's first results, in a process without a cache; what a second call takes is taken off."""
    rows = []
    for structure in names:
        found: dict[str, list[dict]] = {}
        for _ in range(rounds):
            for name, call in ways(answer).items():
                with caches([name]) as (folder, cache):
                    STRUCTURES[structure](folder)
                    found.setdefault(name, []).append(call(cache[name], "experiments.speed.first_result", str(folder)))
        row = [structure]
        for program in found[OURS][0]:
            times = {name: [one[program] for one in each] for name, each in found.items()}
            row += [seconds(float(np.median(t))) for t in times.values()]
            row.append(f"{ratio(times[OURS], times[XLA]):.2f}")
        rows.append(row)
    programs = ("free runs", "sensitivities")
    head = [f"{program}{kind}" for program in programs for kind in ("", f", {XLA}", ", ratio")]
    show("From nothing to the first result of a structure, without imports", ["structure", *head], rows)


def memory(lengths: Sequence[float], diagnosed: Sequence[str] = ("reaction, Coulomb friction",)) -> None:
    """Most memory of processes that fit logs of several lengths, and that diagnose."""
    rows = []
    for length in lengths:
        with caches([OURS, XLA]) as (folder, cache):
            put(folder, rig(), log(length))
            command = ["experiments.speed.fresh", str(folder)]
            rows.append([f"`fit`, {length:g} s", *_peaks(command, folder, cache)])
    for name in diagnosed:
        with caches([OURS, XLA]) as (folder, cache):
            files = [str(folder / file) for file in diagnosis.write(diagnosis.CASES[name], folder)]
            command = ["rwjax", "diagnose", str(folder / "rig.toml"), *files, "--quiet", "-o", str(folder / "out")]
            rows.append([f"`diagnose`: {name}", *_peaks(command, folder, cache)])
    head = ["process", *(f"{name}, {state} [MiB]" for state in ("cold", "warm") for name in (OURS, XLA))]
    show("Most memory of a process", head, rows)


def _peaks(command: list[str], folder: Path, cache: dict[str, Path]) -> list[str]:
    """Memory of a process that runs a module: cold and then warm, each way in turn."""
    note = folder / "peak"

    def once(cache: Path) -> dict:
        call = [sys.executable, "-m", "experiments.speed.peak", str(note), *command]
        subprocess.run(call, env=os.environ | {VARIABLE: str(cache)}, check=True, stdout=subprocess.DEVNULL)
        return {"MiB": float(note.read_text())}

    return [f"{call(cache[name])['MiB']:.0f}" for _ in ("cold", "warm") for name, call in ways(once).items()]
