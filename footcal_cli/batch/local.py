"""Sessions on this machine: one process per worker, imports done once in each."""

from __future__ import annotations

import atexit
import ctypes
import gc
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.process import BaseProcess

from footcal_cli.batch.plan import Died, Job, Work
from footcal_cli.records.batch import SessionRecord

_PR_SET_PDEATHSIG = 1
_OBJECTS = 200_000
"""New objects between two searches for garbage: imports make many and leave none."""
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
                busy[_submitted(pools[slot], work, job)] = (slot, job, attempt)
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                slot, job, attempt = busy.pop(future)
                free.append(slot)
                try:
                    row = future.result()
                except (BrokenProcessPool, SystemExit):  # killed, or asked to end
                    pools[slot].shutdown(wait=False)
                    pools[slot] = _worker()
                    if attempt < ATTEMPTS:
                        waiting.append((job, attempt + 1))
                        continue
                    row = died(job, attempt)
                yield row.model_copy(update={"attempts": attempt})
    except BaseException:  # what is half done is thrown away, and done again next time
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    finally:
        for pool in pools:
            pool.shutdown(cancel_futures=True)


def _worker() -> ProcessPoolExecutor:
    # a fresh interpreter on every system: a fork of a process with threads may hang
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(1, mp_context=context, initializer=_of_parent)


def _submitted(pool: ProcessPoolExecutor, work: Work, job: Job) -> Future[SessionRecord]:
    """Give a worker its job.

    A process that starts for it inherits that Ctrl-C is not heard: it goes to all processes of a
    terminal, and the first one ends the others.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        return pool.submit(work, job)
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return pool.submit(work, job)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _of_parent() -> None:
    """A worker ends with the process that started it, however that one ends.

    One that went on after its parent was killed would write beside the next run. Linux kills it at
    once; elsewhere a thread does, as soon as the work lets it.
    """
    gc.set_threshold(_OBJECTS)
    atexit.register(gc.freeze)  # an end without a search for garbage
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    threading.Thread(
        target=_end_with, args=(multiprocessing.parent_process(),), daemon=True
    ).start()


def _end_with(parent: BaseProcess | None) -> None:
    if parent is not None:
        parent.join()
        os._exit(1)
