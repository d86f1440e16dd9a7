"""Make the golden outputs anew: ``python -m tests.golden --why "..." [RUN ...]``.

Without a reason it only says what has moved, and ends with 1 where something has. With one, the
outputs are written, and the reason with the largest moves goes to the top of HISTORY.md.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

from footcal_cli import __version__
from tests.golden.comparing import OUTPUTS, differences, golden
from tests.golden.runs import RUNS, Cabinet

HISTORY = Path(__file__).parent / "HISTORY.md"
_SHOWN = 8
"""So many differences of a run are told, and how many there are in all."""


def run(arguments: list[str] | None = None) -> int:
    """Compare all runs, or those named; write where a reason is given."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="RUN", help=", ".join(RUNS))
    parser.add_argument("--why", default="", help="why the results are what they are now")
    given = parser.parse_args(arguments)
    told: dict[str, list[str]] = {}
    with TemporaryDirectory() as folder:
        cabinet = Cabinet(Path(folder))
        for name in given.names or RUNS:
            if RUNS[name].measured and not os.environ.get("FOOTCAL_DATA"):
                sys.stdout.write(f"{name}: no FOOTCAL_DATA, left as it is\n")
                continue
            now, before = cabinet.kept(name), golden(name)
            moved = ["new"] if before is None else differences(before, now)
            sys.stdout.write(f"{name}: {len(moved)} differences\n")
            sys.stdout.writelines(f"  {line}\n" for line in moved[:_SHOWN])
            sys.stdout.flush()
            if moved:
                told[name] = moved
            if moved and given.why:
                text = json.dumps(now, indent=1, ensure_ascii=False, sort_keys=True)
                (OUTPUTS / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    if told and given.why:
        _remember(given.why, told)
    return 1 if told and not given.why else 0


def _remember(why: str, told: dict[str, list[str]]) -> None:
    head = f"## {datetime.now(UTC):%Y-%m-%d}, footcal {__version__}\n{why}\n\n"
    lines = [
        f"- {name}: {len(moved)} differences; {'; '.join(moved[:2])}\n"
        for name, moved in told.items()
    ]
    title = "# Why golden outputs changed\n\n"
    before = HISTORY.read_text(encoding="utf-8").removeprefix(title) if HISTORY.exists() else ""
    HISTORY.write_text(title + head + "".join(lines) + "\n" + before, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(run())
