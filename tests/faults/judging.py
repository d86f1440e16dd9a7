"""Run one case in this process and judge what it left: the promises that hold for every input."""

from __future__ import annotations

import contextlib
import hashlib
import io
import shutil
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import ValidationError
from scipy import stats

from footcal_cli.app import main
from footcal_cli.records.files import Versioned
from footcal_cli.records.results import ParametersRecord, RmseRecord, RunRecord
from footcal_cli.report import Drawn, Picture
from tests.faults.bases import Base
from tests.faults.mutations import Mutation
from tests.faults.running import Job, Outcome

_CHANCE = 6e-5
"""That numbers of the same truth lie so far apart: 4 sd of a single one."""
_LEAST_VARIANCE = 1e-8
"""Of a combination of parameters, as a share of theirs: rounding of what was written."""
DRAWN_ONE_IN = 4
_RECORDS: dict[str, type[Versioned]] = {
    "run.json": RunRecord, "parameters.json": ParametersRecord, "rmse.json": RmseRecord,
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A base case, one of its files, and what is done to it."""

    base: Base
    file: str
    mutation: Mutation
    seed: int

    @property
    def words(self) -> str:
        """The case in one line."""
        bent = f"{self.file}: {self.mutation.family}, {self.mutation.name}"
        return f"{self.base.name} | {bent} | seed {self.seed}"


def job_of(case: Case, inputs: Path) -> Job:
    """The case as a job."""
    return Job(case.words, "input", case.mutation.family, lambda f: attempt(case, inputs, f))


def attempt(case: Case, inputs: Path, folder: Path) -> Outcome:
    """Bend the inputs in a folder of their own, run the command, judge, clean up."""
    laid_out(case.base, inputs, folder)
    case.mutation.bend(folder / case.file, np.random.default_rng(case.seed))
    out = folder / case.base.out
    before = fingerprint(folder)
    with contextlib.nullcontext() if case.seed % DRAWN_ONE_IN == 0 else not_drawn():
        code, _, err = call([*words_in(case.base, folder), "--out", str(out)])
    broken = touched(case.base, folder, before)
    broken += spoken(code, err)
    if code not in case.mutation.codes and code != 70:
        broken.append(f"exit code {code}, acceptable {sorted(case.mutation.codes)}")
    level = ""
    if out.is_dir() and case.base.folder:
        run, faults = read_back(out)
        broken += faults
        if run is not None:
            alarmed = any(f.severity != "note" for f in run.findings)
            level = "warning" if alarmed and run.verdict.level == "good" else run.verdict.level
            if run.exit_code != code:
                broken.append(f"run.json says exit code {run.exit_code}, the shell {code}")
            if code == 0 and level == "good":
                broken += _silent(case, inputs, out)
    elif code in (0, 1) and not out.exists():
        broken.append("no run folder")
    elif code not in (0, 1) and out.exists():
        broken.append("half a result")
    shutil.rmtree(folder, ignore_errors=True)
    said = err.strip().splitlines()[0] if err.strip() else ""
    said = said.replace(f"{folder}/", "")
    return Outcome(case.words, "input", case.mutation.family, code, said, level, tuple(broken))


def laid_out(base: Base, inputs: Path, folder: Path) -> None:
    """Copy the base case's files into an empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in base.files:
        shutil.copy(inputs / name, folder / name)


def words_in(base: Base, folder: Path) -> list[str]:
    """The command line, with its files in a folder."""
    return [str(folder / word) if word in base.files else word for word in base.words]


def touched(base: Base, folder: Path, before: Mapping[str, tuple[str, int]]) -> list[str]:
    """Inputs that changed, and what lies beside them."""
    after = fingerprint(folder)
    broken = [f"input touched: {name}" for name, was in before.items() if after.get(name) != was]
    strange = sorted(p.name for p in folder.iterdir() if p.name not in {*base.files, base.out})
    return broken + [f"left behind: {name}" for name in strange]


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


@contextlib.contextmanager
def not_drawn() -> Iterator[None]:
    """Make figures, but do not render them: that takes most of the time of a small case."""

    def built(picture: Picture) -> Drawn:
        picture.draw().clear()
        return Drawn(b"")

    drawn, Picture.drawn = Picture.drawn, built  # type: ignore[method-assign, assignment]
    try:
        yield
    finally:
        Picture.drawn = drawn  # type: ignore[method-assign]


def spoken(code: int, err: str) -> list[str]:
    """What is wrong with what a user reads."""
    said = err.partition("\nfor example:\n")[0]  # what a log looks like, after the sentence
    lines = [line for line in said.splitlines() if line.strip()]
    broken = []
    if "Traceback" in err:
        broken.append("a traceback")
    if code == 70:
        broken.append(f"exit code 70: {lines[-1][:200] if lines else ''}")
    if any("Warning:" in line for line in lines):
        shown = next(line for line in lines if "Warning:" in line)
        broken.append(f"a warning of the interpreter: {shown.split('footcal_cli/')[-1][:120]}")
    elif (code == 3 and len(lines) > 1 and not _gates(lines)) or (
        code == 2 and len(lines) != 1 and "Usage:" not in err
    ):
        broken.append(f"{len(lines)} lines of error")
    return broken


def _gates(lines: Sequence[str]) -> bool:
    """A run that finished says each gate that it missed, one a line."""
    return all(line.startswith("GATE NOT MET") for line in lines)


def read_back(out: Path) -> tuple[RunRecord | None, list[str]]:
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
        ParametersRecord.model_validate_json(path.read_text("utf-8"))
        for path in (reference, out / "parameters.json")
    )
    return _moved(was, now)


def _moved(was: ParametersRecord, now: ParametersRecord) -> list[str]:
    """The first channel whose parameters moved, all of them together, by more than chance.

    One by one they would hide it: the bias of a cell whose zero lies far from its readings is known
    far worse than the forces are.
    """
    common = [name for name in was.parameters if name in now.parameters]
    for owner in dict.fromkeys(name.partition(".")[0] for name in common):
        names = tuple(name for name in common if name.partition(".")[0] == owner)
        shift = np.array([now.value(n) - was.value(n) for n in names])
        covariance = was.covariance_of(names) + now.covariance_of(names)
        size = 1e-9 * np.array([abs(was.value(n)) for n in names]) + 1e-12
        sd = np.sqrt(np.diag(covariance) + size**2)
        values, vectors = np.linalg.eigh((covariance + np.diag(size**2)) / np.outer(sd, sd))
        along = vectors.T @ (shift / sd) / np.sqrt(np.maximum(values, _LEAST_VARIANCE))
        if along @ along > stats.chi2.isf(_CHANCE, len(names)):
            most = names[int(np.argmax(np.abs(shift) / sd))]
            by = now.value(most) - was.value(most)
            return [f"moved in silence: {most} by {by:.3g} {was.parameters[most].unit}"]
    return []


def fingerprint(folder: Path) -> dict[str, tuple[str, int]]:
    """Content and time of change of every file."""
    found = {}
    for path in folder.iterdir():
        if path.is_file():
            found[path.name] = (
                hashlib.sha256(path.read_bytes()).hexdigest(), path.stat().st_mtime_ns
            )  # fmt: skip
    return found
