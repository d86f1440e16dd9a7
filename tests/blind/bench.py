"""Hide, diagnose, open: a run of the bench in three steps that meet only through files.

``root/logs/<name>`` holds logs and recipe, ``root/commitments.json`` what was sealed, and
``root/verdicts/<name>.json`` what footcal said. The truth is in the ledger's own folder.
"""

from __future__ import annotations

import contextlib
import io
import json
import shutil
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from unittest import mock

from rich.progress import track

from footcal_cli.app import main
from footcal_cli.commands import diagnose as diagnose_command
from footcal_cli.report import Picture
from tests.blind.ledger import Ledger, code_digest
from tests.blind.scoring import Score, Verdict, judge
from tests.blind.trials import Cell, make_trial
from tests.blind.yardstick import UnreachableError

REPOSITORY = Path(__file__).resolve().parents[2]
DECIDING = (
    "footcal_cli/core/diagnosis",
    "footcal_cli/core/evidence.py",
    "footcal_cli/core/effects",
)
"""What a sealed run freezes: thresholds, procedure, table of effects."""


@dataclass(frozen=True)
class Bench:
    """Where a run lies."""

    root: Path
    ledger: Ledger

    def __post_init__(self) -> None:
        logs, ledger = self.root.resolve(), self.ledger.folder.resolve()
        if ledger.is_relative_to(logs) or logs.is_relative_to(ledger):
            raise ValueError("the ledger must not lie with the logs")

    @property
    def commitments_file(self) -> Path:
        """What was sealed, beside the logs."""
        return self.root / "commitments.json"

    def commitments(self) -> dict[str, Any]:
        """Content of the commitments, empty before the first trial is hidden."""
        if not self.commitments_file.is_file():
            return {}
        content: dict[str, Any] = json.loads(self.commitments_file.read_text(encoding="utf-8"))
        return content


def rules_digest() -> str:
    """Digest of every file that decides a diagnosis."""
    files: dict[str, Path] = {}
    for place in DECIDING:
        path = REPOSITORY / place
        for file in [path] if path.is_file() else sorted(path.rglob("*.py")):
            files[file.relative_to(REPOSITORY).as_posix()] = file
    return code_digest(files)


def hide(bench: Bench, cells: Sequence[Cell], *, show: bool = True) -> None:
    """Step 1: write the logs of all trials of a plan, and commit to their truths."""
    content = bench.commitments() or {
        "stream": bench.ledger.stream,
        "sealed_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "rules_sha256": rules_digest(),
        "trials": {},
        "unreachable": [],
    }
    for number, cell in _shown(list(enumerate(cells)), "hiding", show):
        trial = f"{number} {cell}"
        name = bench.ledger.name(trial)
        if name in content["trials"] or name in content["unreachable"]:
            continue
        folder = bench.root / "logs" / name
        shutil.rmtree(folder, ignore_errors=True)
        try:
            truth = make_trial(cell, bench.ledger.seed(trial), folder)
        except UnreachableError:
            content["unreachable"].append(name)
        else:
            (folder / "ask.json").write_text(
                json.dumps({"experiment": cell.experiment, "left_out": cell.left_out}), "utf-8"
            )
            content["trials"][name] = bench.ledger.write(name, truth)
        bench.commitments_file.write_text(json.dumps(content, indent=1, sort_keys=True), "utf-8")


def diagnose_all(
    bench: Bench, *, show: bool = True, keep_logs: bool = False, until_s: float = 0.0
) -> int:
    """Step 2: diagnose what has no verdict yet; returns how many were done.

    Trials are taken in the order of their names, which is random; `until_s` > 0 stops after so
    many seconds, and the next call goes on from there.
    """
    verdicts = bench.root / "verdicts"
    verdicts.mkdir(exist_ok=True)
    waiting = [
        n for n in sorted(bench.commitments()["trials"]) if not (verdicts / f"{n}.json").is_file()
    ]
    began, done = time.monotonic(), 0
    for name in _shown(waiting, "diagnosing", show):
        if 0 < until_s < time.monotonic() - began:
            break
        folder = bench.root / "logs" / name
        record = diagnosed(folder, bench.root / "runs" / name)
        record["rules_sha256"] = rules_digest()
        partial = verdicts / f".{name}.part"
        partial.write_text(json.dumps(record), "utf-8")
        partial.rename(verdicts / f"{name}.json")
        done += 1
        if not keep_logs:
            shutil.rmtree(folder, ignore_errors=True)
        shutil.rmtree(bench.root / "runs" / name, ignore_errors=True)
    return done


def diagnosed(folder: Path, run: Path) -> dict[str, Any]:
    """Calibrate with the ordinary command, diagnose with the public one; what came out.

    The code under test sees the logs, the recipe and the kind of experiment, nothing else.
    """
    ask = json.loads((folder / "ask.json").read_text("utf-8"))
    recipe = folder / "recipe.toml"
    shutil.rmtree(run, ignore_errors=True)  # what an interrupted run left
    began = time.monotonic()
    parameters = run / "calibration" / "parameters.json"
    steps = _calibrations(ask["experiment"], folder, run)
    diagnosis = [
        "diagnose",
        *_logs(folder, ask["experiment"]),
        "--experiment",
        ask["experiment"],
        "--recipe",
        recipe,
        "--parameters",
        parameters,
        "--out",
        run / "diagnosis",
    ]
    for left_out in ask["left_out"].split():
        diagnosis += ["--without", left_out]
    steps.append(diagnosis)
    for step in steps:
        code, said = footcal(step)
        if code not in (0, 1, 3):
            return {
                "verdict": "error",
                "exit_code": code,
                "said": said[-2000:],
                "step": str(step[0]),
            }
    path = run / "diagnosis" / "diagnosis.json"
    if not path.is_file():
        return {"verdict": "error", "exit_code": code, "said": said[-2000:], "step": "diagnose"}
    record: dict[str, Any] = json.loads(path.read_text("utf-8"))
    record["seconds"] = time.monotonic() - began
    return record


def _calibrations(experiment: str, folder: Path, run: Path) -> list[list[str | Path]]:
    """The ordinary commands that make the calibration to start from; the last one's counts."""
    recipe: list[str | Path] = ["--recipe", folder / "recipe.toml"]
    out: list[str | Path] = ["--out", run / "calibration"]
    if experiment == "hang":
        return [["hang-calib", _one(folder, "hang"), *recipe, *out]]
    if experiment == "pose":
        hung = run / "hang"
        given: list[str | Path] = ["--parameters", hung / "parameters.json"]
        return [
            ["hang-calib", _one(folder, "hang"), *recipe, "--out", hung],
            ["pose-calib", _one(folder, "poses"), *recipe, *given, *out],
        ]
    log = _one(folder, "weights" if experiment == "weights" else "bench")
    return [["offline-fit", log, *recipe, *out]]


def _logs(folder: Path, experiment: str) -> list[Path]:
    roles = {"walk": ("cells", "body"), "stand": ("cells", "body"), "pose": ("poses",)}
    return [_one(folder, role) for role in roles.get(experiment, (experiment,))]


def _one(folder: Path, stem: str) -> Path:
    return next(folder.glob(f"{stem}.[cp]*"))


@contextlib.contextmanager
def _undrawn() -> Iterator[None]:
    """Commands without their figures, which take longer than the diagnosis itself."""
    with (
        mock.patch.object(diagnose_command, "_pictures", return_value=()),
        mock.patch.object(Picture, "png", return_value=b""),
    ):
        yield


def footcal(arguments: Sequence[str | Path]) -> tuple[int, str]:
    """Run footcal as the shell does, quietly; exit code and what it said."""
    said = io.StringIO()
    with _undrawn(), contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            main([*(str(a) for a in arguments), "--quiet"])
        except SystemExit as end:
            return end.code if isinstance(end.code, int) else 1, said.getvalue()
    return 0, said.getvalue()


def opened(bench: Bench) -> tuple[list[Score], dict[str, Any]]:
    """Step 3: open the ledger, check it against the commitments, judge every verdict.

    Raises
    ------
    BrokenSealError
        A truth was changed, or the rules changed between sealing and diagnosing a sealed run.
    """
    content = bench.commitments()
    truths = bench.ledger.open(content["trials"])
    scores = []
    changed = 0
    for name, truth in sorted(truths.items()):
        path = bench.root / "verdicts" / f"{name}.json"
        if path.is_file():
            record = json.loads(path.read_text("utf-8"))
            changed += record["rules_sha256"] != content["rules_sha256"]
            seconds = record.get("seconds", 0.0)
            scores.append(judge({**truth, "seconds": seconds}, Verdict.read(record)))
    return scores, {**content, "rules_changed": changed, "hidden": len(truths)}


def _shown(items: Sequence[Any], what: str, show: bool) -> Iterator[Any]:
    if not show:
        yield from items
        return
    yield from track(items, what)
