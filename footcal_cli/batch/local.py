"""Sessions on this machine: one process per worker, imports done once in each."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.process import BaseProcess

from footcal_cli.batch.plan import Died, Job, Work
from footcal_cli.records.batch import SessionRecord

ATTEMPTS = 2
"""A session over which a worker died is tried once more."""


def run_here(jobs: Sequence[Job], workers: int, work: Work, died: Died) -> Iterator[SessionRecord]:
    """Run sessions in processes of their own, in the order in which they end.

    Every worker is a pool of one process: when one dies it is known over which session, nothing
    else is lost, and a new one takes its place.

    Parameters
    ----------
    work
        What is done with each; a function that a new process can import.
    died
        Makes the row of a session over which all workers died.
    """
    waiting = [(job, 1) for job in reversed(jobs)]
    pools: list[ProcessPoolExecutor] = []
    busy: dict[Future[SessionRecord], tuple[int, Job, int]] = {}
    free = list(range(max(min(workers, len(jobs)), 1)))
    try:
        pools += (_worker() for _ in free)
        while waiting or busy:
            while waiting and free:
                slot, (job, attempt) = free.pop(), waiting.pop()
                busy[pools[slot].submit(work, job)] = (slot, job, attempt)
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                slot, job, attempt = busy.pop(future)
                free.append(slot)
                try:
                    row = future.result()
                except BrokenProcessPool:
                    pools[slot].shutdown(wait=False)
                    pools[slot] = _worker()
                    if attempt < ATTEMPTS:
                        waiting.append((job, attempt + 1))
                        continue
                    row = died(job, attempt)
                yield row.model_copy(update={"attempts": attempt})
    finally:
        for pool in pools:
            pool.shutdown(wait=not busy, cancel_futures=True)
        if busy:  # interrupted: what is half done is thrown away, and done again next time
            for process in multiprocessing.active_children():
                process.terminate()


def _worker() -> ProcessPoolExecutor:
    # a fresh interpreter on every system: a fork of a process with threads may hang
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(1, mp_context=context, initializer=_of_parent)


def _of_parent() -> None:
    """A worker ends with the process that started it, however that one ends, and not before.

    Ctrl-C goes to all processes of a terminal; the first one ends the others. A worker that went
    on after it was killed would write beside the next run.
    """
    with suppress(ValueError):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(
        target=_end_with, args=(multiprocessing.parent_process(),), daemon=True
    ).start()


def _end_with(parent: BaseProcess | None) -> None:
    if parent is not None:
        parent.join()
        os._exit(1)
