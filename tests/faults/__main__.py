"""Run the corpus: ``python -m tests.faults``; interrupt it and call it again, it goes on."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rich.console import Console
from rich.progress import track

from tests.faults.corpus import drawn, prepared
from tests.faults.page import write_page
from tests.faults.running import outcomes


def run(arguments: list[str] | None = None) -> int:
    """Run the cases, write the page; 1 where a promise was broken."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__)
    parser.add_argument("--cases", type=int, default=1345)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/faults"))
    parser.add_argument("--page", type=Path, default=Path("docs/reliability.md"))
    given = parser.parse_args(arguments)
    given.out.mkdir(parents=True, exist_ok=True)
    inputs = prepared((given.out / "inputs").resolve())
    cases = drawn(given.cases, given.seed)
    kept = given.out / f"outcomes_{given.seed}.jsonl"
    console = Console(stderr=True)
    found = list(
        track(
            outcomes(cases, inputs, given.out.resolve(), given.workers, kept),
            "bad inputs", total=len(cases), console=console, disable=not console.is_terminal,
        )
    )  # fmt: skip
    write_page(cases, found, given.page)
    broken = sum(bool(outcome.violations) for outcome in found)
    sys.stdout.write(f"{len(found)} bad inputs, {broken} broke a promise: {given.page}\n")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(run())
