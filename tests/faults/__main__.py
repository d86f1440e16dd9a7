"""Run the corpus: ``python -m tests.faults``; interrupt it and call it again, it goes on."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track

from tests.faults.corpus import drawn, prepared
from tests.faults.injected import kills, machine_faults, races
from tests.faults.judging import job_of
from tests.faults.log_relations import log_relations
from tests.faults.page import write_page
from tests.faults.process_relations import process_relations
from tests.faults.relations import relation_jobs
from tests.faults.running import broken_before, forget_broken, load_package, outcomes
from tests.faults.seen import seen_jobs
from tests.faults.unseen import unseen_jobs
from tests.faults.world_relations import world_relations

SLOW = frozenset({"pose", "walk", "stream_ladder", "placements_ladder", "diagnose_walk", "batch"})
"""Base cases that take many seconds."""


def run(arguments: list[str] | None = None) -> int:
    """Run the jobs, write the page; 1 where a promise was broken."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__)
    parser.add_argument("--cases", type=int, default=1200, help="bad inputs")
    parser.add_argument(
        "--parts",
        nargs="*",
        default=["input", "kill", "machine", "race", "relation", "seen", "unseen"],
        help="what to try",
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/faults"))
    parser.add_argument("--page", type=Path, default=Path("docs/reliability.md"))
    parser.add_argument("--minutes", type=float, help="stop then; go on when called again")
    parser.add_argument("--again", action="store_true", help="first forget what broke a promise")
    given = parser.parse_args(arguments)
    given.out.mkdir(parents=True, exist_ok=True)
    load_package()
    inputs = prepared((given.out / "inputs").resolve())
    made = {
        "input": lambda: [job_of(case, inputs) for case in drawn(given.cases, given.seed)],
        "kill": lambda: kills(inputs, given.seed),
        "machine": lambda: machine_faults(inputs, given.seed),
        "race": lambda: races(inputs, given.seed),
        "relation": lambda: [
            *process_relations(inputs),
            *relation_jobs((*log_relations(), *world_relations()), inputs),
        ],
        "seen": lambda: seen_jobs(inputs, given.seed),
        "unseen": lambda: unseen_jobs(inputs, given.seed),
    }
    jobs = [job for part in given.parts for job in made[part]()]
    # in an order drawn by seed, slow commands last: wherever it is stopped, much was tried
    jobs = [jobs[i] for i in np.random.default_rng(given.seed).permutation(len(jobs))]
    jobs.sort(key=lambda job: job.key.split(" | ")[0] in SLOW)
    end = None if given.minutes is None else time.monotonic() + 60 * given.minutes
    kept = given.out / f"outcomes_{given.seed}.jsonl"
    if given.again:
        forget_broken(kept)
    console = Console(stderr=True)
    found = list(
        track(
            outcomes(jobs, given.out.resolve(), given.workers, kept, end),
            "faults", total=len(jobs), console=console, disable=not console.is_terminal,
        )
    )  # fmt: skip
    drawn_by = f"--cases {given.cases} --seed {given.seed}"
    write_page(found, [job.key for job in jobs], given.page, broken_before(kept), drawn_by)
    broken = sum(bool(outcome.violations) for outcome in found)
    sys.stdout.write(f"{len(found)} tried, {broken} broke a promise: {given.page}\n")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(run())
