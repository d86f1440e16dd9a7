"""Run one case in this process and judge what it left: the promises that hold for every input."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import shutil
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from footcal_cli.app import main
from footcal_cli.records.files import Versioned
from footcal_cli.records.results import ParametersRecord, RmseRecord, RunRecord
from tests.faults.bases import Base
from tests.faults.mutations import Mutation

LARGEST_SHIFT_SD = 4.0
_RECORDS: dict[str, type[Versioned]] = {
    "run.json": RunRecord, "parameters.json": ParametersRecord, "rmse.json": RmseRecord,
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A base case, one of its files, and what is done to it."""

    number: int
    base: Base
    file: str
    mutation: Mutation
    seed: int

    @property
    def words(self) -> str:
        """The case in one line."""
        bent = f"{self.file}: {self.mutation.family}, {self.mutation.name}"
        return f"{self.base.name} | {bent} | seed {self.seed}"


@dataclass(frozen=True)
class Outcome:
    """How a case ended; `violations` are the promises it broke."""

    number: int
    exit_code: int
    sentence: str
    level: str
    violations: tuple[str, ...]


def attempt(case: Case, inputs: Path, folder: Path) -> Outcome:
    """Bend the inputs in a folder of their own, run the command, judge, clean up."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in case.base.files:
        shutil.copy(inputs / name, folder / name)
    case.mutation.bend(folder / case.file, np.random.default_rng(case.seed))
    out = folder / "out"
    words = [str(folder / w) if w in case.base.files else w for w in case.base.words]
    before = _fingerprint(folder)
    code, _, err = call([*words, "--out", str(out)])
    broken = [f"input touched: {n}" for n in _changed(before, _fingerprint(folder))]
    broken += _spoken(code, err)
    if code not in case.mutation.codes and code != 70:
        broken.append(f"exit code {code}, acceptable {sorted(case.mutation.codes)}")
    strange = sorted(p.name for p in folder.iterdir() if p.name not in {*case.base.files, "out"})
    broken += [f"left behind: {name}" for name in strange]
    level = ""
    if out.exists():
        run, faults = _read_back(out)
        broken += faults
        if run is not None:
            alarmed = any(f.severity != "note" for f in run.findings)
            level = "warning" if alarmed and run.verdict.level == "good" else run.verdict.level
            if run.exit_code != code:
                broken.append(f"run.json says exit code {run.exit_code}, the shell {code}")
            if code == 0 and level == "good":
                broken += _silent(case, inputs, out)
    elif code in (0, 1):
        broken.append("no run folder")
    shutil.rmtree(folder, ignore_errors=True)
    said = err.strip().splitlines()[0] if err.strip() else ""
    return Outcome(case.number, code, said.replace(f"{folder}/", ""), level, tuple(broken))


def call(words: list[str]) -> tuple[int, str, str]:
    """Exit code, standard output and standard error, as the shell has them."""
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("always", RuntimeWarning)
        try:
            main(words)
            code = 0
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
    return code, out.getvalue(), err.getvalue()


def _spoken(code: int, err: str) -> list[str]:
    """What is wrong with what a user reads."""
    lines = [line for line in err.splitlines() if line.strip()]
    broken = []
    if "Traceback" in err:
        broken.append("a traceback")
    if code == 70:
        broken.append(f"exit code 70: {lines[-1][:200] if lines else ''}")
    if any("Warning:" in line for line in lines):
        shown = next(line for line in lines if "Warning:" in line)
        broken.append(f"a warning of the interpreter: {shown.split('footcal_cli/')[-1][:120]}")
    elif (code == 3 and len(lines) > 1) or (code == 2 and len(lines) != 1 and "Usage:" not in err):
        broken.append(f"{len(lines)} lines of error")
    return broken


def _read_back(out: Path) -> tuple[RunRecord | None, list[str]]:
    """Records against their models; markup of inputs in the report."""
    broken = [f"no {n}" for n in ("run.json", "report.html") if not (out / n).is_file()]
    run = None
    for name, model in _RECORDS.items():
        if not (out / name).is_file():
            continue
        try:
            record = model.model_validate_json((out / name).read_text("utf-8"))
        except ValidationError as error:
            broken.append(f"{name}: {error.errors()[0]['msg']}")
            continue
        run = record if isinstance(record, RunRecord) else run
    page = out / "report.html"
    if page.is_file() and "<script>alert(1)" in page.read_text("utf-8"):
        broken.append("markup of the input is not escaped")
    return run, broken


def _silent(case: Case, inputs: Path, out: Path) -> list[str]:
    """A good verdict without a finding: nothing may be wrong, and no number may have moved."""
    if case.mutation.wrong:
        return ["wrong data are called good"]
    reference = inputs / "references" / f"{case.base.name}.json"
    if not case.base.calibrates or not reference.is_file():
        return []
    if not (out / "parameters.json").is_file():
        return ["no parameters.json"]
    was, now = (
        json.loads(path.read_text("utf-8"))["parameters"]
        for path in (reference, out / "parameters.json")
    )
    broken = []
    for name in sorted(was.keys() & now.keys()):
        sd = float(np.hypot(was[name]["sd"] or 0.0, now[name]["sd"] or 0.0))
        shift = abs(now[name]["value"] - was[name]["value"])
        if shift > LARGEST_SHIFT_SD * sd + 1e-9 * abs(was[name]["value"]):
            broken.append(f"moved in silence: {name} by {shift:.3g} {was[name]['unit']}")
    return broken[:1]


def _fingerprint(folder: Path) -> dict[str, tuple[str, int]]:
    found = {}
    for path in folder.iterdir():
        if path.name != "out" and path.is_file():
            found[path.name] = (
                hashlib.sha256(path.read_bytes()).hexdigest(), path.stat().st_mtime_ns
            )  # fmt: skip
    return found


def _changed(
    before: dict[str, tuple[str, int]], after: dict[str, tuple[str, int]]
) -> list[str]:  # fmt: skip
    return [name for name, print_ in before.items() if after.get(name) != print_]
