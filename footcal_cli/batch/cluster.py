"""Sessions on an existing Dask cluster (``pip install 'footcal[cluster]'``).

Workers must see the logs and the batch's folder under the same paths, and have footcal installed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from footcal_cli.batch.plan import Died, Job, Work
from footcal_cli.errors import MachineError, missing_library
from footcal_cli.records.batch import SessionRecord


def run_on_cluster(
    jobs: Sequence[Job], scheduler: str, work: Work, died: Died
) -> Iterator[SessionRecord]:
    """Run sessions on the workers of a scheduler, in the order in which they end.

    A session whose worker died is given to another by Dask itself; one over which several died
    becomes a row.

    Parameters
    ----------
    jobs
        The sessions; their paths as the workers see them.
    scheduler
        Its address, ``tcp://host:8786``.
    work, died
        As `footcal_cli.batch.local.run_here`.

    Raises
    ------
    UsageError
        Dask is not installed.
    MachineError
        The scheduler does not answer, or has no workers.
    """
    try:
        from distributed import Client, KilledWorker, as_completed
    except ImportError as error:
        raise missing_library(
            "distributed", error, "--scheduler needs Dask", "pip install 'footcal[cluster]'"
        ) from None
    try:
        client: Any = Client(scheduler, timeout="10s", set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, TimeoutError, ValueError) as error:
        raise MachineError(
            f"no Dask scheduler answers at {scheduler}", value=type(error).__name__,
            remedy="start one with 'dask scheduler', or leave --scheduler out",
        ) from None  # fmt: skip
    with client:
        if not client.scheduler_info()["workers"]:
            raise MachineError(
                f"the scheduler at {scheduler} has no workers",
                remedy=f"start some with 'dask worker {scheduler} --nthreads 1'",
            )
        tasks = {
            client.submit(work, job, key=f"footcal-{job.name}-{i}", pure=False): job
            for i, job in enumerate(jobs)
        }
        for task in as_completed(tasks, loop=client.loop):  # type: ignore[no-untyped-call]
            try:
                yield task.result()
            except KilledWorker:
                yield died(tasks[task], 2)
            task.release()
