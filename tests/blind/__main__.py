"""Run the bench: ``python -m tests.blind``; interrupt it and call it again, it goes on."""

from __future__ import annotations

import argparse
import random
from pathlib import Path

from tests.blind.bench import Bench, diagnose_all, hide, opened
from tests.blind.ledger import open_ledger
from tests.blind.page import write_page
from tests.blind.trials import EXPERIMENTS, Kind, plan_cells


def run(arguments: list[str] | None = None) -> None:
    """Hide, diagnose, open, write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/blind"), help="logs and verdicts")
    parser.add_argument("--ledger", type=Path, default=Path("out/blind-ledger"), help="the truth")
    parser.add_argument("--stream", choices=("development", "sealed"), default="sealed")
    parser.add_argument("--rounds", type=int, default=30, help="trials per line of the plan")
    parser.add_argument("--experiments", nargs="+", choices=EXPERIMENTS, default=EXPERIMENTS)
    parser.add_argument("--kinds", nargs="+", help=f"of {Kind}")
    parser.add_argument("--minutes", type=float, default=0.0, help="stop diagnosing after so long")
    parser.add_argument("--page", type=Path, default=Path("docs/blind_bench.md"))
    given = parser.parse_args(arguments)
    given.out.mkdir(parents=True, exist_ok=True)
    bench = Bench(given.out, open_ledger(given.ledger, given.stream))
    cells = [c for c in plan_cells(given.experiments) if not given.kinds or c.kind in given.kinds]
    # every round in an order of its own, so that an interrupted run is no worse for the last lines
    shuffled = []
    for number in range(given.rounds):
        order = list(cells)
        random.Random(number).shuffle(order)
        shuffled += order
    hide(bench, shuffled)
    diagnose_all(bench, until_s=60.0 * given.minutes)
    scores, content = opened(bench)
    write_page(scores, content, given.page)


if __name__ == "__main__":
    run()
