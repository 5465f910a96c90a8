"""What a fleet costs: `python -m experiments.fleet.scale [speed] [size] [kill] [restart] [bytes] [growth] [--rigs 500]`

speed: the same rigs by one worker and by two. size: seconds and memory against the number of rigs. kill: the whole command is killed midway
and begun again, and a worker is killed; rigs that are lost or done twice. restart: the same of the scheduler of a cluster. bytes: the rows of
two workers against those of this process alone. growth: memory of a process over 1000 fits. Rigs are those of `experiments.fleet.draw`, one
session of each.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import polars as pl
import psutil

from experiments.fleet.draw import SESSIONS, write_fleet
from experiments.speed.table import machine, show
from rwjax.fleet.plan import FleetPlan, read_plan
from rwjax.fleet.run import run
from rwjax.fleet.store import PARTS, RESULTS, schema
from rwjax.fleet.work import carried_out

SIZES = (10, 50, 200, 500, 1000, 2000)
FITS = 1000
TIMES = ("seconds",)
"""Columns that differ from run to run."""


def of_one_session(folder: Path) -> FleetPlan:
    """The plan of the fits of the first session alone."""
    plan = read_plan(folder / "fit.toml")
    return plan._replace(jobs=tuple(job for job in plan.jobs if job.when == SESSIONS[0]))


def speed(folder: Path, rigs: int) -> None:
    """One worker against two, in turn; the first of each warms up."""
    plan = of_one_session(folder)
    took: dict[int, list[float]] = {1: [], 2: []}
    for turn in range(3):
        for workers, times in took.items():
            begin = time.perf_counter()
            run(plan, folder / f"speed_{workers}_{turn}", workers=workers)
            times.append(time.perf_counter() - begin)
    rows = [
        [f"{workers}", ", ".join(f"{t:.1f}" for t in times), f"{min(took[1][1:]) / min(times[1:]):.2f}"]
        for workers, times in took.items()
    ]
    show(f"{rigs} rigs; {machine()}", ["workers", "time, cold and then warm [s]", "faster than one by"], rows)


def size(folder: Path, rigs: int) -> None:
    """Seconds and memory of the client against the number of rigs."""
    plan, rows = of_one_session(folder), []
    for count in (n for n in SIZES if n <= rigs):
        begin = time.perf_counter()
        run(plan._replace(jobs=plan.jobs[:count]), folder / f"size_{count}", workers=2)
        took, own = time.perf_counter() - begin, psutil.Process().memory_info().rss
        rows.append([f"{count}", f"{took:.1f}", f"{1e3 * took / count:.0f}", f"{own / 2**20:.0f}"])
    show(machine(), ["rigs", "time [s]", "a rig [ms]", "memory of the client [MiB]"], rows)


def kill(folder: Path, rigs: int) -> None:
    """The command is killed midway, then a worker of the second one."""
    out, own = folder / "killed", folder / "killed.toml"
    own.write_text((folder / "fit.toml").read_text().replace("{when}", SESSIONS[0]))
    call = [sys.executable, "-m", "rwjax", "fleet", str(own), "-o", str(out), "--workers", "2", "--quiet"]
    for what in ("command", "worker"):
        begun = subprocess.Popen(call, start_new_session=True, stdout=subprocess.DEVNULL)
        before = len(list((out / PARTS).glob("*.parquet"))) if out.exists() else 0
        while begun.poll() is None and len(list((out / PARTS).glob("*.parquet"))) < before + 1:
            time.sleep(0.2)
        if what == "command":
            os.killpg(begun.pid, signal.SIGKILL)
        else:
            workers = [
                p for p in psutil.Process(begun.pid).children(recursive=True) if "spawn_main" in " ".join(p.cmdline())
            ]
            workers[-1].kill()
        begun.wait()
    _lost_or_twice("command, then a worker", out, rigs)


def restart(folder: Path, rigs: int) -> None:
    """The scheduler of a cluster is killed midway, and another one begins at the same address with a worker of its own."""
    out, own, address = folder / "restarted", folder / "restarted.toml", "tcp://127.0.0.1:18786"
    own.write_text((folder / "fit.toml").read_text().replace("{when}", SESSIONS[0]))

    def cluster() -> list[subprocess.Popen]:
        scheduler = ("scheduler", "--host", "127.0.0.1", "--port", "18786", "--no-dashboard")
        worker = ("worker", address, "--nworkers", "2", "--nthreads", "1", "--no-dashboard")
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True, "cwd": folder}
        return [subprocess.Popen([sys.executable, "-m", "dask", *call], **quiet) for call in (scheduler, worker)]

    def end(processes: list[subprocess.Popen]) -> None:
        for process in processes:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    first = cluster()
    call = [sys.executable, "-m", "rwjax", "fleet", str(own), "-o", str(out), "--scheduler", address, "--quiet"]
    begun = subprocess.Popen(call, stdout=subprocess.DEVNULL)
    while begun.poll() is None and not list((out / PARTS).glob("*.parquet")):
        time.sleep(0.2)
    end(first)
    second = cluster()
    begun.wait()
    end(second)
    _lost_or_twice("scheduler", out, rigs)


def _lost_or_twice(what: str, out: Path, rigs: int) -> None:
    """Prints how many rigs have no result, and how many have two."""
    rows = pl.read_parquet(out / RESULTS)
    lost, twice = rigs - rows.filter(status="done")["rig"].n_unique(), rows.height - rows["rig"].n_unique()
    show(
        f"{rigs} rigs; {machine()}",
        ["killed", "rigs lost", "rigs twice in the result"],
        [[what, f"{lost}", f"{twice}"]],
    )


def same_bytes(folder: Path, rigs: int) -> None:
    """The rows of two workers against those of this process."""
    plan = of_one_session(folder)
    by_cluster = run(plan, folder / "bytes", workers=2)
    alone = pl.DataFrame([carried_out(job, plan.command, plan.options, "") for job in plan.jobs], schema=schema())
    same = by_cluster.drop(TIMES).equals(alone.sort("rig", "when").drop(TIMES))
    show(
        f"{rigs} rigs; {machine()}",
        ["two workers against this process, but for times"],
        [["the same bytes" if same else "differ"]],
    )


def growth(folder: Path, rigs: int) -> None:
    """Memory of this process over fits of the rigs in turn."""
    plan, sizes = of_one_session(folder), []
    for k in range(FITS):
        carried_out(plan.jobs[k % len(plan.jobs)], "fit", {}, "")
        if k + 1 in (FITS // 10, FITS // 2, FITS):
            sizes.append((k + 1, psutil.Process().memory_info().rss / 2**20))
    show(
        machine(),
        ["fits", "memory [MiB]", "against the first tenth"],
        [[f"{k}", f"{m:.0f}", f"{100 * (m / sizes[0][1] - 1):+.1f} %"] for k, m in sizes],
    )


PARTS_OF_IT: dict[str, Callable[[Path, int], None]] = {
    "speed": speed,
    "size": size,
    "kill": kill,
    "restart": restart,
    "bytes": same_bytes,
    "growth": growth,
}


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS_OF_IT))
    parser.add_argument("--rigs", type=int, default=500)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write_fleet(Path(folder), a.rigs)
        for part in a.parts or PARTS_OF_IT:
            PARTS_OF_IT[part](Path(folder), a.rigs)


if __name__ == "__main__":
    main()
