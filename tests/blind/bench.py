"""Hide, diagnose, follow up, open: the steps of a run, which meet only through files.

``root/logs/<name>`` holds logs and recipe, ``root/commitments.json`` what was sealed, and
``root/verdicts/<name>.json`` what footcal said. The truth is in the ledger's own folder, whose
place the processes that diagnose are never told.
"""

from __future__ import annotations

import contextlib
import json
import random
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from tests.blind.diagnosing import REPOSITORY, commit, rules_digest
from tests.blind.followup import left_open, make_followup, wants_followup
from tests.blind.ledger import Ledger
from tests.blind.plan import Planned
from tests.blind.scoring import Score, Verdict, judge, judge_followup
from tests.blind.trials import make_trial
from tests.blind.yardstick import UnreachableError

LOOK_EVERY_S = 1.0


@dataclass(frozen=True)
class Bench:
    """Where a run lies."""

    root: Path
    ledger: Ledger

    def __post_init__(self) -> None:
        logs, ledger = self.root.resolve(), self.ledger.folder.resolve()
        if ledger.is_relative_to(logs) or logs.is_relative_to(ledger):
            raise ValueError("the ledger must not lie with the logs")

    @property
    def commitments_file(self) -> Path:
        """What was sealed, beside the logs."""
        return self.root / "commitments.json"

    def commitments(self) -> dict[str, Any]:
        """Content of the commitments, those of an empty run before the first trial is hidden."""
        if self.commitments_file.is_file():
            content: dict[str, Any] = json.loads(self.commitments_file.read_text(encoding="utf-8"))
            return content
        return {
            "stream": self.ledger.stream,
            "sealed_at": datetime.now(UTC).isoformat(timespec="seconds"),
            "rules_sha256": rules_digest(),
            "commit": commit(),
            "trials": {},
            "unreachable": [],
            "followups": {},
        }

    def keep(self, content: Mapping[str, Any], *, complete: bool = True) -> None:
        """Write the commitments, and the names alone as the queue of the workers."""
        queue = {
            # what was proposed first: it waits for nothing, and the time is limited
            "names": [*content["followups"].values(), *content["trials"]],
            "complete": complete,
        }
        _replace(self.commitments_file, json.dumps(content, indent=1))
        _replace(self.root / "queue.json", json.dumps(queue))

    def verdict(self, name: str) -> dict[str, Any] | None:
        """What was said of a trial, None while it waits."""
        path = self.root / "verdicts" / f"{name}.json"
        if not path.is_file():
            return None
        record: dict[str, Any] = json.loads(path.read_text("utf-8"))
        return record


def hide(bench: Bench, trials: Sequence[Planned], *, show: bool = True) -> None:
    """Step 1: write the logs of all trials of a plan, and commit to their truths.

    Neighbours change places by the ledger's secret, so that the order tells nothing.
    """
    content = bench.commitments()
    order = list(trials)
    near = 40
    for start in range(0, len(order), near):
        part = order[start : start + near]
        random.Random(bench.ledger.seed(f"order {start}")).shuffle(part)
        order[start : start + near] = part
    for number, planned in enumerate(_shown(order, "hiding", show)):
        name = bench.ledger.name(planned.trial)
        if name in content["trials"] or name in content["unreachable"]:
            continue
        _hide_one(bench, content, name, planned)
        if number % near == near - 1:
            bench.keep(content, complete=False)
    bench.keep(content)


def _hide_one(bench: Bench, content: dict[str, Any], name: str, planned: Planned) -> None:
    """The first of the choices that some robot can hold."""
    folder = bench.root / "logs" / name
    for number, cell in enumerate(planned.choices):
        shutil.rmtree(folder, ignore_errors=True)
        try:
            truth = make_trial(cell, bench.ledger.seed(f"{planned.trial} {number}"), folder)
        except UnreachableError:
            continue
        ask(folder, cell.experiment, cell.left_out)
        content["trials"][name] = bench.ledger.write(name, truth)
        return
    content["unreachable"].append(name)


def ask(folder: Path, experiment: str, left_out: str = "") -> None:
    """What a worker is told beside the logs."""
    question = {"experiment": experiment, "left_out": left_out}
    (folder / "ask.json").write_text(json.dumps(question), "utf-8")


def follow(bench: Bench) -> int:
    """Step 3: carry out the experiments that were proposed for designed aliases; how many."""
    content = bench.commitments()
    made = 0
    for name in list(content["trials"]):
        said = bench.verdict(name)
        if said is None or name in content["followups"]:
            continue
        truth = json.loads((bench.ledger.folder / f"{name}.json").read_bytes())
        if not wants_followup(truth, said):
            continue
        after = bench.ledger.name(f"after {name}")
        folder = bench.root / "logs" / after
        shutil.rmtree(folder, ignore_errors=True)
        proposal = said["next_experiment"]
        ask(make_followup(truth, said, bench.ledger.seed(f"after {name}"), folder),
            proposal["kind"])  # fmt: skip
        content["followups"][name] = after
        made += 1
    bench.keep(content)
    return made


@contextlib.contextmanager
def diagnosing(bench: Bench, *, workers: int, until_s: float = 0.0) -> Iterator[None]:
    """Step 2, beside what is done meanwhile: processes that diagnose what is hidden.

    On leaving, they are waited for until nothing waits or their time is over.
    """
    content = bench.commitments()
    bench.keep(content, complete=False)
    (bench.root / "verdicts").mkdir(exist_ok=True)
    # what an interrupted run was at is begun anew
    shutil.rmtree(bench.root / "claims", ignore_errors=True)
    (bench.root / "claims").mkdir()
    command = [sys.executable, "-m", "tests.blind.worker", str(bench.root.resolve())]
    running = [
        subprocess.Popen([*command, "--seconds", str(until_s)], cwd=REPOSITORY)
        for _ in range(workers)
    ]
    try:
        yield
        bench.keep(bench.commitments())
        _watch(bench, running)
    finally:
        for process in running:
            process.terminate()
            process.wait()


def _watch(bench: Bench, running: Sequence[subprocess.Popen[bytes]]) -> None:
    content = bench.commitments()
    total = len(content["trials"]) + len(content["followups"])
    with _bar(show=True) as bar:
        task = bar.add_task("diagnosing", total=total)
        while any(process.poll() is None for process in running):
            time.sleep(LOOK_EVERY_S)
            done = sum(1 for _ in (bench.root / "verdicts").glob("*.json"))
            bar.update(task, completed=done)


def opened(bench: Bench) -> tuple[list[Score], dict[str, Any]]:
    """Step 4: open the ledger, check it against the commitments, judge every verdict.

    Raises
    ------
    BrokenSealError
        A truth was changed.
    """
    content = bench.commitments()
    truths = bench.ledger.open(content["trials"])
    scores = []
    changed = unavailable = 0
    for name, truth in truths.items():
        record = bench.verdict(name)
        if record is None:
            continue
        if record["verdict"] == "not available":
            unavailable += 1
            continue
        changed += record["rules_sha256"] != content["rules_sha256"]
        verdict = Verdict.read(record)
        after = bench.verdict(content["followups"].get(name, "none"))
        resolved = False if left_open(truth, record) else None
        if after is not None:
            resolved = judge_followup(truth, verdict, Verdict.read(after))
        seconds = record.get("seconds", 0.0)
        scores.append(judge({**truth, "seconds": seconds, "resolved": resolved}, verdict))
    counts = {"rules_changed": changed, "hidden": len(truths), "unavailable": unavailable}
    return scores, {**content, **counts}


def _replace(file: Path, text: str) -> None:
    """Write a file that others read at any time."""
    partial = file.with_name(f".{file.name}.part")
    partial.write_text(text, "utf-8")
    partial.rename(file)


def _bar(show: bool) -> Progress:
    return Progress(
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
        TimeRemainingColumn(), disable=not show,
    )  # fmt: skip


def _shown(items: Sequence[Any], what: str, show: bool) -> Iterator[Any]:
    with _bar(show) as bar:
        yield from bar.track(items, description=what)
