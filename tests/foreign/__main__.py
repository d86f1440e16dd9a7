"""``python -m tests.foreign``: the campaign of `tests.foreign.campaign` and its page."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from tests.foreign.campaign import TASKS, run
from tests.foreign.page import Answers, page_of, summary_of

BEFORE = Path(__file__).parent / "before.json"
"""Summary of the same campaign on version 54b3c9a, before the causes were mended."""


def main() -> None:
    """Run what is missing and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=900)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--out", type=Path, default=Path("out/foreign"))
    parser.add_argument("--page", type=Path, default=Path("docs/foreign_calibration.md"))
    given = parser.parse_args()
    answers: Answers = {}
    for seed in range(given.first, given.first + given.seeds):
        for name in TASKS:
            answers.setdefault(name, []).append(run(name, seed, given.out))
            sys.stdout.write(f"seed {seed}: {name}\n")
    before = json.loads(BEFORE.read_text(encoding="utf-8"))
    given.page.write_text(page_of(summary_of(answers), before), encoding="utf-8")


if __name__ == "__main__":
    main()
