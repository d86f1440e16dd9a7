"""The side of the bench that sees logs only: calibrate, diagnose, keep what was said.

Nothing here knows the plan or the ledger; a worker process imports this module and footcal.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import shutil
import subprocess
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from unittest import mock

from footcal_cli.app import main
from footcal_cli.report import Drawn, Picture
from footcal_cli.session.request import REJECTED
from footcal_cli.sheets import bench, hang

REPOSITORY = Path(__file__).resolve().parents[2]
BEFORE = "before.json"
"""The diagnosis that proposed an experiment, beside its logs."""
ADDED = ("step", "seconds", "rules_sha256")
"""What a kept verdict has beside the content of ``diagnosis.json``."""
FINE = (0, 1, 3)
"""Exit codes of a command that did its work: done, found something, cannot tell."""


def rules_digest() -> str:
    """SHA-256 over the names and contents of footcal's modules: what a sealed run freezes."""
    total = hashlib.sha256()
    for file in sorted((REPOSITORY / "footcal_cli").rglob("*.py")):
        name = file.relative_to(REPOSITORY).as_posix()
        total.update(name.encode() + b"\0" + file.read_bytes() + b"\0")
    return total.hexdigest()


def commit() -> str:
    """Short name of the commit whose code runs; empty where there is no repository."""
    git = shutil.which("git")
    if git is None:
        return ""
    command = [git, "-C", str(REPOSITORY), "rev-parse", "--short=8", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


def diagnosed(folder: Path, run: Path) -> dict[str, Any]:
    """Calibrate with the ordinary command, diagnose with the public one; what came out.

    The code under test sees the logs, the recipe and the kind of experiment, nothing else.
    """
    ask = json.loads((folder / "ask.json").read_text("utf-8"))
    shutil.rmtree(run, ignore_errors=True)  # what an interrupted run left
    began = time.process_time()
    code, said, step = 0, "", ""
    for command in _commands(ask, folder, run):
        step = str(command[0])
        code, said = footcal(command)
        if code not in FINE:
            break
    path = run / "diagnosis" / "diagnosis.json"
    record: dict[str, Any] = {"verdict": "error", "exit_code": code, "said": said[-2000:]}
    if code in FINE and path.is_file():
        record = json.loads(path.read_text("utf-8"))
    elif "not available" in said:
        record["verdict"] = "not available"
    return {**record, "step": step, "seconds": time.process_time() - began}


def _commands(ask: dict[str, str], folder: Path, run: Path) -> Iterator[list[str | Path]]:
    """The calibration to start from, then the diagnosis, each when those before it are done."""
    yield from _calibrations(ask["experiment"], folder, run)
    experiment = ask["experiment"]
    diagnosis: list[str | Path] = ["diagnose", *_logs(folder, experiment)]
    diagnosis += ["--experiment", experiment, "--recipe", folder / "recipe.toml"]
    diagnosis += ["--parameters", calibration_of(run / "calibration")]
    diagnosis += ["--out", run / "diagnosis", "--no-pictures"]
    if (folder / BEFORE).is_file():
        diagnosis += ["--after", folder / BEFORE]
    for left_out in ask["left_out"].split():
        diagnosis += ["--without", left_out]
    yield diagnosis


def calibration_of(folder: Path) -> Path:
    """What a command left: a diagnosis starts from a rejected calibration too, as it says."""
    kept = [folder / name for name in ("parameters.json", REJECTED)]
    return next((path for path in kept if path.is_file()), kept[0])


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
    """Calibrations without their figures, which take longer than the calibration itself."""
    with (
        mock.patch.object(bench, "_pictures", return_value=()),
        mock.patch.object(hang, "_pictures", return_value=()),
        mock.patch.object(Picture, "drawn", return_value=Drawn(b"", "")),
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
