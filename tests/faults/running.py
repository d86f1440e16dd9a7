"""Cases in worker processes, each with a limit of time; one that hangs is killed and counted."""

from __future__ import annotations

import json
import multiprocessing
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from tests.faults.judging import Case, Outcome, attempt

LIMIT_S = 60.0


def outcomes(
    cases: Sequence[Case], inputs: Path, folder: Path, workers: int, kept: Path | None = None
) -> Iterator[Outcome]:
    """Yield what became of every case; those that `kept` (JSON lines) holds are not run again."""
    before = _kept(kept)
    yield from (before[case.number] for case in cases if case.number in before)
    waiting = [case for case in cases if case.number not in before][::-1]
    pool = [_Worker(inputs, folder / f"worker_{i}") for i in range(workers)]
    try:
        while waiting or any(worker.case for worker in pool):
            for worker in pool:
                if worker.case is None and waiting:
                    worker.give(waiting.pop())
            wait([worker.pipe for worker in pool if worker.case], timeout=0.5)
            for worker in pool:
                outcome = worker.take()
                if outcome is not None:
                    if kept is not None:
                        with kept.open("a", encoding="utf-8") as stream:
                            stream.write(json.dumps(asdict(outcome)) + "\n")
                    yield outcome
    finally:
        for worker in pool:
            worker.end()


def _kept(path: Path | None) -> dict[int, Outcome]:
    if path is None or not path.is_file():
        return {}
    rows = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
    return {
        row["number"]: Outcome(**{**row, "violations": tuple(row["violations"])}) for row in rows
    }


class _Worker:
    """A process that runs cases one by one."""

    def __init__(self, inputs: Path, folder: Path) -> None:
        self._inputs, self._folder = inputs, folder
        self.case: Case | None = None
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("fork")
        self.pipe, theirs = context.Pipe()
        self.process: BaseProcess = context.Process(
            target=_work, args=(theirs, self._inputs, self._folder), daemon=True
        )
        self.process.start()
        theirs.close()

    def give(self, case: Case) -> None:
        """Start a case."""
        # mutations hold functions, which do not pass through a pipe: the worker draws by number
        self.case, self._since = case, time.monotonic()
        self.pipe.send((case.base.name, case.file, case.mutation.name, case.number, case.seed))

    def take(self) -> Outcome | None:
        """The outcome of a case that ended, died or took too long."""
        if self.case is None:
            return None
        number, fault = self.case.number, ""
        if self.pipe.poll():
            with suppress(EOFError):
                outcome = self.pipe.recv()
                self.case = None
                return outcome if isinstance(outcome, Outcome) else None
            fault = "the process died"
        elif time.monotonic() - self._since > LIMIT_S:
            fault = f"runs longer than {LIMIT_S:.0f} s"
        if not fault:
            return None
        self.end()
        self._start()
        self.case = None
        return Outcome(number, -1, "", "", (fault,))

    def end(self) -> None:
        """Kill the process."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _work(pipe: Connection, inputs: Path, folder: Path) -> None:
    from tests.faults.bases import BASES
    from tests.faults.corpus import possible

    known = {(base, file, m.name): m for base, file, m in possible()}
    while True:
        base, file, name, number, seed = pipe.recv()
        case = Case(number, BASES[base], file, known[base, file, name], seed)
        pipe.send(attempt(case, inputs, folder))
