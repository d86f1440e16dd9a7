"""``python -m tests.foreign``: the fleet through every command that fits it, and its page."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.foreign.campaign import run, tasks_of
from tests.foreign.efficiency import bounds_of
from tests.foreign.kinds import DRAW, FLEET, kind_of
from tests.foreign.page import Answer, page_of


def main() -> None:
    """Run what is missing and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--makes", type=int, nargs="*", default=list(FLEET))
    parser.add_argument("--draws", type=int, nargs="*", default=[0, 1])
    parser.add_argument("--out", type=Path, default=Path("out/foreign"))
    parser.add_argument("--page", type=Path, default=Path("docs/foreign_calibration.md"))
    given = parser.parse_args()
    answers: dict[tuple[str, int], Answer] = {}
    for seed in (make + DRAW * draw for draw in given.draws for make in given.makes):
        for name in tasks_of(seed):
            answers[name, seed] = run(name, seed, given.out)
            sys.stdout.write(f"{seed} {kind_of(seed).name}: {name}\n")
            sys.stdout.flush()
    bounds = {key: bounds_of(*key, given.out) for key in answers}
    given.page.write_text(page_of(answers, bounds), encoding="utf-8")


if __name__ == "__main__":
    main()
