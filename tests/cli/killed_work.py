"""Work that kills its own process, or is killed; light, since every new process imports it."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

from footcal_cli.batch.local import run_here
from footcal_cli.batch.plan import Job
from footcal_cli.commands import batch
from footcal_cli.records.batch import SessionRecord
from footcal_cli.session.interruption import Interrupted, watched
from footcal_cli.session.run_folder import whole_folder


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


def busy_long(job: Job) -> SessionRecord:
    """Work within one call that lets no other thread run; it says which process is at it."""
    (job.out / "worker").write_text(str(os.getpid()), "utf-8")
    sum(range(2_000_000_000))
    return died(job, 1)


def write_long(job: Job) -> SessionRecord:
    """A session that is a minute long about to write its run folder."""

    def long_run(job: Job) -> tuple[int, str]:
        with whole_folder(job.folder, overwrite=True, inputs=()):
            (job.out / "worker").write_text(str(os.getpid()), "utf-8")
            time.sleep(60)
        return 0, ""

    batch._run = long_run
    return batch.run_session(job)


if __name__ == "__main__":  # python -m tests.cli.killed_work WORK FOLDER
    from tests.cli import killed_work

    work, out = getattr(killed_work, sys.argv[1]), Path(sys.argv[2])
    job = Job("s", "", None, "", (), None, None, "check", 0, out, again=False)
    with watched() as interruption:
        try:
            (out / "started").touch()
            list(run_here([job], 1, work, died))
        except Interrupted:
            sys.exit(interruption.exit_code)
