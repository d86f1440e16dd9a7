"""Work that kills its own process; light, since every new process imports it."""

from __future__ import annotations

import os
import signal
import time

from footcal_cli.batch.plan import Job
from footcal_cli.records.batch import SessionRecord


def died(job: Job, attempts: int) -> SessionRecord:
    return SessionRecord(
        session=job.name, robot="", date=None, operator="", command=job.command, logs=(),
        outcome="refused", exit_code=137, reason="died", digest="", attempts=attempts, seconds=0.0,
        rows=0,
    )  # fmt: skip


def kill_once(job: Job) -> SessionRecord:
    """Work during which the process is killed over session 5 once, over session 7 always."""
    mark = job.out / f"{job.name}.seen"
    first = not mark.exists()
    mark.touch()
    if job.name == "s07" or (job.name == "s05" and first):
        os.kill(os.getpid(), signal.SIGKILL)
    return died(job, 1).model_copy(update={"outcome": "done"})


def sleep_long(job: Job) -> SessionRecord:
    """Work that takes a minute; it says which process is at it."""
    (job.out / "worker").write_text(str(os.getpid()), "utf-8")
    time.sleep(60)
    return died(job, 1)
