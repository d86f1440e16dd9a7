"""Jobs in processes of their own, forked from one that has imported the package; resumable."""

from __future__ import annotations

import importlib
import json
import multiprocessing
import pkgutil
import resource
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from itertools import count
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

import footcal_cli

PROCESSOR_LIMIT_S = 90
"""Processor time of a job: one that computes for longer is taken for endless."""
WAITING_LIMIT_S = 900.0
"""Time on the clock, however busy the machine: one that takes longer waits for something."""


@dataclass(frozen=True)
class Outcome:
    """How a job ended; `violations` are the promises that were broken.

    Parameters
    ----------
    key
        The job in one line.
    part, family
        ``input``, ``kill``, ``machine``, ``race`` or ``relation``, and the class within it.
    exit_code, sentence, level
        How the command ended, what it said, its verdict.
    cpu_s
        Processor time of the job with all its processes.
    """

    key: str
    part: str
    family: str
    exit_code: int
    sentence: str
    level: str
    violations: tuple[str, ...]
    cpu_s: float = 0.0


@dataclass(frozen=True)
class Job:
    """Something to try in an empty folder."""

    key: str
    part: str
    family: str
    run: Callable[[Path], Outcome]


def load_package() -> None:
    """Import all modules once, so that forked processes need not."""
    for module in pkgutil.walk_packages(footcal_cli.__path__, "footcal_cli."):
        if not module.name.endswith("__main__"):
            with suppress(ImportError):  # an extra that is not installed
                importlib.import_module(module.name)


def outcomes(
    jobs: Sequence[Job], folder: Path, workers: int, kept: Path | None = None,
    end: float | None = None,
) -> Iterator[Outcome]:  # fmt: skip
    """Yield what became of every job; those that `kept` (JSON lines) holds are not run again.

    From the time `end` of the monotonic clock on, no job is started any more.
    """
    before = _kept(kept)
    yield from (before[job.key] for job in jobs if job.key in before)
    waiting = [job for job in jobs if job.key not in before][::-1]
    running: list[_Running] = []
    try:
        while waiting or running:
            if end is not None and time.monotonic() > end:
                waiting.clear()
            while waiting and len(running) < workers:
                free = next(i for i in count() if all(i != each.place for each in running))
                running.append(_Running(waiting.pop(), folder, free))
            wait([each.pipe for each in running], timeout=0.5)
            for each in list(running):
                outcome = each.outcome()
                if outcome is None:
                    continue
                running.remove(each)
                if kept is not None:
                    with kept.open("a", encoding="utf-8") as stream:
                        stream.write(json.dumps(asdict(outcome)) + "\n")
                yield outcome
    finally:
        for each in running:
            each.end()


def broken_before(path: Path) -> list[Outcome]:
    """Outcomes that broke a promise and were forgotten since, each job's first."""
    return list(_kept(_forgotten(path)).values())


def _forgotten(path: Path) -> Path:
    return path.with_name(f"{path.stem}_broken{path.suffix}")


def _kept(path: Path | None) -> dict[str, Outcome]:
    if path is None or not path.is_file():
        return {}
    rows = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
    return {r["key"]: Outcome(**{**r, "violations": tuple(r["violations"])}) for r in rows}


def forget_broken(path: Path) -> None:
    """Set those that broke a promise apart from the kept outcomes, so that they are tried again."""
    every, first = _kept(path).values(), _kept(_forgotten(path))
    broken = {o.key: o for o in every if o.violations} | first
    for where, those in ((path, [o for o in every if not o.violations]),
                         (_forgotten(path), [*broken.values()])):  # fmt: skip
        where.write_text("".join(json.dumps(asdict(o)) + "\n" for o in those), "utf-8")


class _Running:
    """A job in its process."""

    def __init__(self, job: Job, folder: Path, place: int) -> None:
        self._job, self._since, self.place = job, time.monotonic(), place
        context = multiprocessing.get_context("fork")
        self.pipe, theirs = context.Pipe(duplex=False)
        self._process: BaseProcess = context.Process(
            target=_work, args=(job, folder / f"worker_{place}", theirs)
        )
        self._process.start()
        theirs.close()

    def outcome(self) -> Outcome | None:
        """What became of it, None while it runs."""
        fault = ""
        if self.pipe.poll():
            with suppress(EOFError):
                found = self.pipe.recv()
                self.end()
                return found if isinstance(found, Outcome) else None
            self._process.join()
            fault = f"the process died with {self._process.exitcode}"
            if self._process.exitcode == -24:
                fault = f"runs longer than {PROCESSOR_LIMIT_S} s"
        elif time.monotonic() - self._since > WAITING_LIMIT_S:
            fault = "waits for ever"
        if not fault:
            return None
        self.end()
        return Outcome(self._job.key, self._job.part, self._job.family, -1, "", "", (fault,))

    def end(self) -> None:
        """Kill the process."""
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _work(job: Job, folder: Path, pipe: Connection) -> None:
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_LIMIT_S, hard))
    outcome = job.run(folder)
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    pipe.send(replace(outcome, cpu_s=round(sum(u.ru_utime + u.ru_stime for u in used), 2)))
