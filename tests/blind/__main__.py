"""Run the bench: ``python -m tests.blind``; interrupt it and call it again, it goes on."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from tests.blind.bench import Bench, diagnosing, follow, hide, opened
from tests.blind.ledger import open_ledger
from tests.blind.page import write_page
from tests.blind.plan import EXPERIMENTS, ROUNDS, Kind, Planned, planned

SECONDS = {"weights": 1.9, "placements": 2.1, "walk": 6.0, "hang": 15.0, "pose": 13.0, "stand": 4.0}
"""One trial on one core of a small server, hiding not counted, for the forecast."""


def run(arguments: list[str] | None = None) -> None:
    """Hide, diagnose, carry out what was proposed, open, write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/blind"), help="logs and verdicts")
    parser.add_argument("--ledger", type=Path, default=Path("out/blind-ledger"), help="the truth")
    parser.add_argument("--stream", choices=("development", "sealed"), default="sealed")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help=f"{ROUNDS}: a full run")
    parser.add_argument("--first-round", type=int, default=0)
    parser.add_argument("--experiments", nargs="+", choices=EXPERIMENTS, default=EXPERIMENTS)
    parser.add_argument("--kinds", nargs="+", help=f"of {Kind}", default=())
    parser.add_argument("--workers", type=int, default=2, help="processes that diagnose")
    parser.add_argument("--minutes", type=float, default=0.0, help="stop diagnosing after so long")
    parser.add_argument("--more-minutes", type=float, default=0.0, help="the same for proposals")
    parser.add_argument("--notes", type=Path, help="JSON: notes and why, sentences each")
    parser.add_argument("--page", type=Path, default=Path("docs/blind_bench.md"))
    given = parser.parse_args(arguments)
    trials = planned(given.rounds, given.experiments, given.kinds, given.first_round)
    sys.stdout.write(forecast(trials, given.workers) + "\n")
    given.out.mkdir(parents=True, exist_ok=True)
    bench = Bench(given.out, open_ledger(given.ledger, given.stream))
    with diagnosing(bench, workers=given.workers, until_s=60.0 * given.minutes):
        hide(bench, trials)
    if follow(bench):
        with diagnosing(bench, workers=given.workers, until_s=60.0 * given.more_minutes):
            pass
    scores, content = opened(bench)
    notes = json.loads(given.notes.read_text("utf-8")) if given.notes else {}
    write_page(scores, {**content, **notes}, given.page)


def forecast(trials: tuple[Planned, ...], workers: int) -> str:
    """How many trials are planned, and how long they take."""
    seconds = sum(SECONDS[t.choices[0].experiment] for t in trials) / workers
    return f"{len(trials)} trials, about {seconds / 60.0:.0f} min on {workers} cores"


if __name__ == "__main__":
    run()
