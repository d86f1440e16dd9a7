"""The bench in the foreign world: ``python -m tests.blind.abroad_bench``; it goes on where it was.

Development seeds are for looking at, sealed ones for the page; both are fixed by a word, so that
two versions of footcal are compared on the same logs.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scipy import stats

from tests.blind.abroad import TRIALS as OF_USUAL
from tests.blind.abroad import Abroad, make
from tests.blind.abroad_fleet import fleet_trials, mixed
from tests.blind.classes import classes_of
from tests.blind.diagnosing import FINE, calibration_of, footcal
from tests.blind.scoring import Verdict

TRIALS: Mapping[str, Abroad] = {**OF_USUAL, **fleet_trials()}
"""By name; those of the fleet run where their names are asked for."""
ANSWERS = (
    "right", "set", "wrong set", "unknown", "none", "underpowered", "bad-data", "WRONG", "error",
)  # fmt: skip


REFUSED = 3
"""Exit code of a log that no answer can be given on."""


def seed_of(stream: str, name: str, number: int) -> int:
    """The seed of one trial."""
    return int(hashlib.sha256(f"{stream} {name} {number}".encode()).hexdigest()[:6], 16)


def diagnosed(trial: Abroad, seed: int, folder: Path) -> dict[str, Any]:
    """Write a trial, calibrate, diagnose; ``diagnosis.json`` and the seconds it took."""
    make(trial, seed, folder)
    began, record = time.process_time(), {"verdict": "error"}
    for command in _commands(trial.experiment, folder):
        at = command.index("--parameters") if "--parameters" in command else -1
        if at > 0 and not Path(command[at + 1]).is_file():  # a calibration of bad data leaves none
            left = (calibration_of(folder / of) for of in ("calibration", "hung"))
            before = next((path for path in left if path.is_file()), None)
            given: list[str | Path] = [] if before is None else ["--parameters", before]
            command = [*command[:at], *given, *command[at + 2 :]]
        code, said = footcal([*command, "--recipe", folder / "recipe.toml"])
        if code not in FINE:
            return {"verdict": "error", "said": said[-800:], "step": command[0]}
    path = folder / "diagnosis" / "diagnosis.json"
    if path.is_file():
        record = json.loads(path.read_text("utf-8"))
    elif code == REFUSED:
        record = {"verdict": "refused", "said": said[-800:]}
    return {**record, "seconds": time.process_time() - began}


def _commands(experiment: str, folder: Path) -> list[list[str | Path]]:
    """The ordinary calibration of an experiment, then its diagnosis."""

    on_ankles = {"ankles": "walk", "stance": "stand"}.get(experiment)

    experiment = {"fleet hang": "hang", "fleet pose": "pose", "wrist": "hang"}.get(
        experiment, experiment
    )

    def log(role: str) -> Path:
        return folder / f"{role}.parquet"

    given: list[str | Path] = ["--parameters", folder / "calibration" / "parameters.json"]
    out: list[str | Path] = ["--out", folder / "calibration"]
    logs = {"walk": ["cells", "body"], "stand": ["cells", "body"], "pose": ["poses"]}
    if on_ankles:  # nothing calibrates a foot's transducer before it stands
        return [["diagnose", *map(log, logs["walk"]), "--experiment", on_ankles, "--no-pictures",
                 "--out", folder / "diagnosis"]]  # fmt: skip
    judged = [log(role) for role in logs.get(experiment, [experiment])]
    diagnosis = ["diagnose", *judged, "--experiment", experiment, *given, "--no-pictures",
                 "--out", folder / "diagnosis"]  # fmt: skip
    if experiment == "hang":
        return [["hang-calib", log("hang"), *out], diagnosis]
    if experiment == "pose":
        hung = folder / "hung"
        before: list[str | Path] = ["--parameters", hung / "parameters.json"]
        return [
            ["hang-calib", log("hang"), "--out", hung],
            ["pose-calib", log("poses"), *before, *out],
            diagnosis,
        ]
    return [["offline-fit", log("weights"), *out], diagnosis]


def answer(trial: Abroad, record: Mapping[str, Any]) -> str:
    """One of `ANSWERS`; a refusal that sends its reader to the plugs is one of wrong wiring."""
    if record["verdict"] == "refused":
        return "right" if trial.wiring and "which plug" in record["said"] else "error"
    if record["verdict"] in ("error", "not available"):
        return "error"
    said, right = Verdict.read(record), frozenset(trial.right)
    true = right | frozenset(trial.also)
    if said.names - true:
        return "WRONG"
    if said.verdict == "ambiguous" and not any(group & true for group in said.rivals):
        return "wrong set"
    if not right:
        own = said.verdict in ("named", "ambiguous") and bool(trial.also)
        return "right" if said.verdict == "none" or own else said.verdict
    if said.verdict == "bad-data":
        return "right" if trial.wiring else "bad-data"
    if said.names & right:
        return "right"
    held = [group for group in said.rivals if group & right]
    if not held and said.verdict in ("named", "ambiguous"):  # what is true, not what was hidden
        return "none"
    if held:
        return "right" if held[0] <= right | trial.beside else "set"
    return "unknown" if said.verdict == "named+unknown" else said.verdict


def run(arguments: list[str] | None = None) -> None:
    """Make, diagnose and count what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.abroad_bench", description=__doc__)
    parser.add_argument("--stream", choices=("development", "sealed"), default="development")
    parser.add_argument("--out", type=Path, default=Path("out/abroad"))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=1, help="of each kind of trial")
    parser.add_argument("--only", default="", help="kinds that begin so")
    parser.add_argument("--mix", action="store_true", help="of the fleet: each cause on one make")
    given = parser.parse_args(arguments)
    kept = given.out / given.stream
    kept.mkdir(parents=True, exist_ok=True)
    for number in range(given.first, given.first + given.count):
        for name, trial in TRIALS.items():
            file = kept / f"{name.replace(' ', '_')}_{number}.json"
            fleet = name.startswith("fleet ")
            if not name.startswith(given.only) or file.is_file() or (fleet and not given.only):
                continue
            if fleet and given.mix and not mixed(name, number):
                continue
            folder = Path(tempfile.mkdtemp())
            record = diagnosed(trial, seed_of(given.stream, name, number), folder)
            shutil.rmtree(folder)
            file.write_text(json.dumps(record), "utf-8")
            names = [c["effect"] for c in record.get("causes", ())]
            sys.stdout.write(
                f"{name} {number}: {answer(trial, record)} ({record['verdict']} {names}, "
                f"{record.get('seconds', 0.0):.0f} s)\n"
            )
            sys.stdout.flush()
    sys.stdout.write(counted(kept))


def named_sets(trial: Abroad, record: Mapping[str, Any]) -> list[tuple[bool, int]]:
    """Of a name or a set of rivals that was given: whether it holds the cause, and its classes."""
    if not trial.right or record["verdict"] not in ("named", "named+unknown", "ambiguous"):
        return []
    said, right = Verdict.read(record), frozenset(trial.right)
    groups = [frozenset([name]) for name in said.names] + list(said.rivals)
    best = next((group for group in groups if group & right), None) or next(iter(groups), None)
    return [] if best is None else [(bool(best & right), classes_of(best))]


def records(kept: Path) -> list[tuple[Abroad, dict[str, Any]]]:
    """Every trial that was diagnosed, with its record."""
    found = []
    for name, trial in TRIALS.items():
        for file in sorted(kept.glob(f"{name.replace(' ', '_')}_[0-9]*.json")):
            found.append((trial, json.loads(file.read_text("utf-8"))))
    return found


def sets_counted(found: Sequence[tuple[Abroad, dict[str, Any]]]) -> str:
    """How many names and sets hold the cause, and of how many classes those are."""
    sets = [one for trial, record in found for one in named_sets(trial, record)]
    sizes = [size for held, size in sets if held]
    if not sizes:
        return ""
    return (
        f"names and sets that hold the cause: {share_words([held for held, _ in sets])}, "
        f"{sum(sizes) / len(sizes):.2f} classes on average\n"
    )


def counted(kept: Path) -> str:
    """A table of answers by experiment, clean logs apart, and what the sets of rivals hold."""
    diagnosed = records(kept)
    found = [(trial, answer(trial, record)) for trial, record in diagnosed]
    lines = [f"| trials | n | {' | '.join(ANSWERS)} |", f"|---|---|{'---|' * len(ANSWERS)}"]
    kinds = list(dict.fromkeys((t.experiment, bool(t.right)) for t, _ in found))
    for kind in [*kinds, ("all", False), ("all", True)]:
        alike = [(t, a) for t, a in found if bool(t.right) == kind[1]]
        mine = [a for t, a in alike if kind[0] in (t.experiment, "all")]
        if mine:
            share = Counter(mine)
            words = " | ".join(str(share[a]) for a in ANSWERS)
            name = f"{kind[0]}, {'a cause hidden' if kind[1] else 'clean'}"
            lines.append(f"| {name} | {len(mine)} | {words} |")
    return "\n".join(lines) + "\n" + sets_counted(diagnosed)


def share_words(hits: Sequence[bool]) -> str:
    """``80 % [68, 88] (40/50)``, Wilson's 95 % interval."""
    if not hits:
        return "–"
    interval = stats.binomtest(sum(hits), len(hits)).proportion_ci(method="wilson")
    low, high = 100.0 * interval.low, 100.0 * interval.high
    return f"{100 * sum(hits) / len(hits):.0f} % [{low:.0f}, {high:.0f}] ({sum(hits)}/{len(hits)})"


if __name__ == "__main__":
    run()
