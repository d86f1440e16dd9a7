"""Run the drawn mutants: ``python -m tests.mutations``; interrupt it and call it again."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from tests.conftest import REPOSITORY
from tests.mutations.running import Reach, reached, verdict
from tests.mutations.sites import Mutant, drawn

MUTANTS = Path(__file__).parent / "mutants.json"


def run(arguments: list[str] | None = None) -> int:
    """Say of every mutant which test catches it; 1 where one survives that used to be caught."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutations", description=__doc__)
    parser.add_argument("--draw", type=int, metavar="N", help="draw N new mutants first")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--limit", type=float, default=300.0, help="CPU seconds of tests per mutant"
    )
    parser.add_argument("--out", type=Path, default=Path("out/mutations"))
    given = parser.parse_args(arguments)
    given.out.mkdir(parents=True, exist_ok=True)
    if given.draw:
        rows = [{**asdict(m), "verdict": ""} for m in drawn(REPOSITORY, given.draw, given.seed)]
        _write(MUTANTS, rows)
    rows = json.loads(MUTANTS.read_text(encoding="utf-8"))
    mutants = [Mutant(**{k: v for k, v in row.items() if k != "verdict"}) for row in rows]
    reach = _reach(given.out.resolve(), mutants, given.workers)
    kept = given.out / "verdicts.json"
    found: dict[str, str] = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    for index, mutant in enumerate(mutants):
        if str(index) not in found:
            files = reach.files.get(index, ())
            found[str(index)] = verdict(REPOSITORY, given.out.resolve(), mutant, files, given.limit)
            _write(kept, found)
        sys.stdout.write(f"{index:3d} {mutant.file}: {mutant.before} -> {mutant.after}: ")
        sys.stdout.write(f"{found[str(index)]}\n")
        sys.stdout.flush()
    caught = sum(v.startswith("caught") for v in found.values())
    sys.stdout.write(f"{caught} of {len(mutants)} mutants are caught.\n")
    lost = [
        row for i, row in enumerate(rows)
        if row["verdict"].startswith("caught") and not found[str(i)].startswith(("caught", "gone"))
    ]  # fmt: skip
    _write(MUTANTS, [{**row, "verdict": found[str(i)]} for i, row in enumerate(rows)])
    return 1 if lost else 0


def _reach(out: Path, mutants: list[Mutant], workers: int) -> Reach:
    """The recording run, kept until its file is deleted."""
    kept = out / "reach.json"
    if kept.exists():
        told = json.loads(kept.read_text(encoding="utf-8"))
        return Reach({int(k): v for k, v in told["files"].items()}, told["seconds"])
    reach = reached(REPOSITORY, out, mutants, workers)
    _write(kept, asdict(reach))
    return reach


def _write(path: Path, content: object) -> None:
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(run())
