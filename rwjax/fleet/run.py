"""A plan carried out: jobs to a cluster, rows to a store as they come, what fails once more in the end."""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rwjax.errors import InputError, one_line
from rwjax.fleet.cluster import connected
from rwjax.fleet.plan import FleetPlan, Job
from rwjax.fleet.store import REPORTS, Store
from rwjax.fleet.work import failed, on_worker
from rwjax.rig.read import read_rig

if TYPE_CHECKING:
    import polars as pl
    from distributed import Client, Future

AHEAD = 4
"""Jobs that wait for each worker, so that none is idle and the client holds few."""
ROWS, SECONDS = 500, 5.0
"""Rows of quick jobs that are written together at most, and for how long they are gathered [s]; that of a job that took as long is written
at once."""
MOST_LOST = 5
"""How often the scheduler may be lost before a run gives up."""


def run(
    plan: FleetPlan,
    folder: Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    memory: str | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> "pl.DataFrame":
    """The command of a plan for every rig of it that is not done yet.

    Args:
        plan: The plan.
        folder: Folder of the results (`rwjax.fleet.store`); workers write reports of diagnoses into it, and read the logs, so that they
            have to see the same disk.
        scheduler: Address of a Dask scheduler; None for a cluster of this machine's own.
        workers: Processes of an own cluster, as many as there are processors without it [1].
        memory: Memory of each, as "2GiB"; its share of what there is without it.
        progress: Hears how far the run is.

    Returns:
        All rows, those of earlier runs as well, by `rwjax.fleet.store.schema`.

    Raises:
        InputError: No cluster is there, the folder cannot be written, or the one rig file does not fit the plan.
    """
    said = _Progress(progress)
    if len(files := {job.rig_file for job in plan.jobs}) == 1:
        _check(plan, files.pop())  # what is wrong with it is said once
    with Store(folder, plan) as store:
        for turn in ("", "failed ones once more, "):
            jobs, lost = store.left(plan.jobs), 0
            said.begin(turn or _before(len(plan.jobs) - len(jobs)), len(jobs))
            while jobs and lost <= MOST_LOST:
                with connected(scheduler, workers, memory) as client:
                    jobs = _carried_out(client, plan, jobs, store, said)
                lost += 1
            store.add([failed(job, plan.command, "the scheduler was lost again and again") for job in jobs])
        return store.gathered()


def _check(plan: FleetPlan, rig_file: str) -> None:
    """Raises `InputError` where the rig file of all rigs is wrong, or leaves none of a number that they are to share to be estimated."""
    rig = read_rig(rig_file)
    for name in plan.shared:
        if name in rig.per_run:
            raise InputError(
                f"`shared` holds {name}, of which every run has a value of its own (`fit.per_run` in {rig_file})"
            )
        if name not in rig.free:
            free = ", ".join(rig.free) or "nothing"
            raise InputError(f"`shared` holds {name}, which {rig_file} does not leave free; it leaves free {free}")


def _before(count: int) -> str:
    """What was done by an earlier run, in words."""
    return f"{count} were done before; " if count else ""


def _carried_out(client: "Client", plan: FleetPlan, jobs: Sequence[Job], store: Store, said: "_Progress") -> list[Job]:
    """Jobs that a lost scheduler has taken along; all others have a row."""
    from distributed import as_completed
    from distributed.client import ClosedClientError

    folder = str((store.folder / REPORTS).resolve())
    work = partial(on_worker, command=plan.command, options=plan.options, folder=folder)
    waiting, running, batch = iter(jobs), {}, _Batch(store)

    def submitted(ahead: int) -> "Iterator[Future]":
        for job in islice(waiting, max(ahead - len(running), 0)):
            key = f"{job.rig} {job.when} {time.monotonic_ns()}"
            running[key] = job
            yield client.submit(work, job, key=key, pure=False)

    try:
        ahead, asked = _ahead(client), time.monotonic()
        done = as_completed(submitted(ahead), loop=client.loop)
        for future in done:
            batch.add(_row(future, running[future.key], plan.command))
            del running[future.key]
            future.release()
            said.one_done()
            if time.monotonic() - asked > SECONDS:  # workers come and go
                ahead, asked = _ahead(client), time.monotonic()
            done.update(submitted(ahead))
    except (CancelledError, ClosedClientError, OSError):  # the scheduler is gone, and with it what it had
        pass
    finally:
        batch.write()
    return [*running.values(), *waiting]


def _ahead(client: "Client") -> int:
    """Jobs that may be submitted at a time."""
    return AHEAD * max(len(client.scheduler_info(n_workers=-1)["workers"]), 1)


def _row(future: "Future", job: Job, command: str) -> dict[str, Any]:
    """The row of a job that has ended; waits for one whose worker was lost with it. Raises where the scheduler is lost."""
    if future.status != "error":
        return future.result()
    error = future.exception()
    if type(error).__name__ == "KilledWorker":
        return failed(job, command, "its worker was killed again and again; it may need more memory (--memory)")
    return failed(job, command, one_line(f"{type(error).__name__}: {error}"))


class _Batch:
    """Rows on their way to the store."""

    def __init__(self, store: Store) -> None:
        self.store, self.rows, self.since = store, [], time.monotonic()

    def add(self, row: dict[str, Any]) -> None:
        self.rows.append(row)
        if max(time.monotonic() - self.since, row["seconds"] or SECONDS) >= SECONDS or len(self.rows) >= ROWS:
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
