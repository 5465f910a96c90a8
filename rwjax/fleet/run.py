"""A plan carried out: jobs to a cluster, rows to a store as they come, what fails once more in the end."""

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rwjax.fleet.cluster import connected
from rwjax.fleet.plan import FleetPlan, Job
from rwjax.fleet.store import REPORTS, Store
from rwjax.fleet.work import carried_out, failed

if TYPE_CHECKING:
    import polars as pl
    from distributed import Client

AHEAD = 4
"""Jobs that wait for each worker, so that none is idle and the client holds few."""
ROWS, SECONDS = 500, 5.0
"""Rows that are written together at most, and how long a row waits for others at most [s]."""
MOST_LOST = 5
"""How often the scheduler may be lost before a run gives up."""


def run(
    plan: FleetPlan,
    folder: Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    memory: str = "auto",
    progress: Callable[[str], None] = lambda text: None,
) -> "pl.DataFrame":
    """The command of a plan for every rig of it that is not done yet.

    Args:
        plan: The plan.
        folder: Folder of the results (`rwjax.fleet.store`); workers write reports of diagnoses into it, and read the logs, so that they
            have to see the same disk.
        scheduler: Address of a Dask scheduler; None for a cluster of this machine's own.
        workers: Processes of an own cluster, as many as there are processors without it [1].
        memory: Memory of each, as "2GiB" or "auto".
        progress: Hears how far the run is.

    Returns:
        All rows, those of earlier runs as well, by `rwjax.fleet.store.schema`.

    Raises:
        InputError: No cluster is there, or the folder cannot be written.
    """
    store = Store(folder, plan)
    said = _Progress(progress)
    for turn in ("", "failed ones once more, "):
        jobs, lost = store.left(plan.jobs), 0
        said.begin(turn, len(jobs))
        while jobs:
            with connected(scheduler, workers, memory) as client:
                rest = _carried_out(client, plan, jobs, store, said)
            lost += bool(rest)
            if lost > MOST_LOST:
                store.add([failed(job, plan.command, "the scheduler was lost again and again") for job in rest])
                break
            jobs = rest
    return store.gathered()


def _carried_out(client: "Client", plan: FleetPlan, jobs: Sequence[Job], store: Store, said: "_Progress") -> list[Job]:
    """Jobs that a lost scheduler has taken along; all others have a row."""
    from distributed import as_completed

    work = partial(
        carried_out, command=plan.command, options=plan.options, folder=str((store.folder / REPORTS).resolve())
    )
    waiting, running, lost = iter(jobs), {}, []
    batch = _Batch(store)

    def submitted(count: int) -> Iterator[Any]:
        for job in islice(waiting, count):
            future = client.submit(work, job, key=f"{job.rig} {job.when} {time.monotonic_ns()}", pure=False)
            running[future.key] = job
            yield future

    try:
        workers = max(len(client.scheduler_info(n_workers=-1)["workers"]), 1)
        done = as_completed(list(submitted(AHEAD * workers)), loop=client.loop)
        for future in done:
            job = running.pop(future.key)
            if future.status == "finished":
                batch.add(future.result())
                said.one_done()
            elif future.status == "error":
                batch.add(failed(job, plan.command, _why(future.exception())))
                said.one_done()
            else:
                lost.append(job)
            future.release()
            if not lost:
                for further in submitted(1):
                    done.add(further)
    except OSError:  # the scheduler is gone, and with it what it had
        lost += running.values()
    finally:
        batch.write()
    return [*lost, *waiting] if lost else []


def _why(error: BaseException | None) -> str:
    """Why a job came to nothing of which no row came back."""
    if type(error).__name__ == "KilledWorker":
        return "its worker was killed again and again; it may need more memory (--memory)"
    return f"{type(error).__name__}: {error}"


class _Batch:
    """Rows on their way to the store."""

    def __init__(self, store: Store) -> None:
        self.store, self.rows, self.since = store, [], time.monotonic()

    def add(self, row: dict[str, Any]) -> None:
        self.rows.append(row)
        if len(self.rows) >= ROWS or time.monotonic() - self.since > SECONDS:
            self.write()

    def write(self) -> None:
        self.store.add(self.rows)
        self.rows, self.since = [], time.monotonic()


class _Progress:
    """How far a run is, in words."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self.tell = tell
        self.begin("", 0)

    def begin(self, what: str, whole: int) -> None:
        self.what, self.whole, self.done, self.since = what, whole, 0, time.monotonic()

    def one_done(self) -> None:
        self.done += 1
        left = (self.whole - self.done) * (time.monotonic() - self.since) / self.done
        self.tell(f"{self.what}{self.done} of {self.whole} jobs, about {left:.0f} s left")
