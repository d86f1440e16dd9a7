"""Tests that take long, chosen by a recorded run: ``python -m tests.thorough DURATIONS``.

`make test` leaves them to `make test-thorough`, so that it ends within four minutes on two cores.
DURATIONS is what ``pytest -vv --durations=0`` printed. Contracts, layers, names, words, faults and
the start of the command line stay, however long they take.
"""

from __future__ import annotations

import re
import sys
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

LIST = Path(__file__).with_suffix(".txt")
LONG_S = 1.2
"""CPU seconds of a test function, all its parameters and what is made for it first together."""
_STAY = (
    "tests/contract/", "tests/language/", "tests/docs", "tests/faults/", "tests/test_layers",
    "tests/test_names", "tests/cli/test_start",
)  # fmt: skip
_LINE = re.compile(r"(?P<seconds>[\d.]+)s (?:call|setup|teardown)\s+(?P<test>[^\[\s]+)")


def long_ones(lines: Iterable[str]) -> list[str]:
    """Test functions that take long and may be left to another run, in the order of their names.

    >>> long_ones(["3.10s call     tests/core/test_a.py::test_b[1]", "0.20s call tests/c.py::d"])
    ['tests/core/test_a.py::test_b']
    """
    taken: dict[str, float] = defaultdict(float)
    for found in filter(None, map(_LINE.match, lines)):
        taken[found["test"]] += float(found["seconds"])
    return sorted(t for t, s in taken.items() if s > LONG_S and not t.startswith(_STAY))


def listed() -> frozenset[str]:
    """Test functions that `make test-thorough` runs."""
    return frozenset(LIST.read_text("utf-8").split())


if __name__ == "__main__":
    LIST.write_text("\n".join(long_ones(Path(sys.argv[1]).read_text("utf-8").splitlines())) + "\n")
