"""Run the suite's tests that reach a mutant, until one of them fails."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tests.mutations.sites import Mutant, apply, instrument

COSTS = "tests.mutations.costs"
_PYTEST = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not slow")


@dataclass(frozen=True)
class Reach:
    """Files of tests that reach each mutant, and the CPU time each file takes (s)."""

    files: Mapping[int, Sequence[str]]
    seconds: Mapping[str, float]


def copied(repository: Path, tree: Path) -> Path:
    """Copy what git knows of the repository, as it lies there now."""
    shutil.rmtree(tree, ignore_errors=True)
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"],
        cwd=repository, check=True, capture_output=True, text=True,
    )  # fmt: skip
    for name in listed.stdout.splitlines():
        source = repository / name
        if source.is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, tree / name)
    return tree


def reached(repository: Path, out: Path, mutants: list[Mutant], workers: int) -> Reach:
    """Run the whole suite once with every site recording, mutating nothing."""
    tree = copied(repository, out / "tree")
    instrument(tree, mutants)
    hits, costs = out / "hits.tsv", out / "costs.tsv"
    hits.write_text("", encoding="utf-8")
    costs.write_text("", encoding="utf-8")
    _pytest(tree, hits, ["-n", str(workers), "--dist", "worksteal", "-p", COSTS], None)
    files: dict[int, set[str]] = {}
    for line in hits.read_text(encoding="utf-8").splitlines():
        index, test = line.split("\t")
        if "::" in test:
            files.setdefault(int(index), set()).add(test.split("::")[0])
    seconds: dict[str, float] = {}
    for line in costs.read_text(encoding="utf-8").splitlines():
        test, cpu_s = line.split("\t")
        file = test.split("::")[0]
        seconds[file] = seconds.get(file, 0.0) + float(cpu_s)
    return Reach({k: sorted(v, key=lambda f: seconds.get(f, 0)) for k, v in files.items()}, seconds)


def verdict(
    repository: Path, out: Path, mutant: Mutant, files: Sequence[str], limit_s: float
) -> str:
    """Run the mutant against the files that reach it: caught (by what), survived, or gone."""
    tree = copied(repository, out / "tree")
    if not apply(tree, mutant):
        return "gone"
    if not files:
        return "not reached"
    done = _pytest(tree, out / "hits.tsv", ["-x", *files], limit_s)
    if done.returncode == -signal.SIGKILL:
        return f"survived {limit_s:.0f} s of tests"
    if done.returncode == 0:
        return "survived"
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return f"caught by {failed[0].split(' ')[1]}" if failed else "caught"


def _pytest(
    tree: Path, hits: Path, arguments: Sequence[str], limit_s: float | None
) -> subprocess.CompletedProcess[str]:
    environment = {
        **os.environ, "PYTHONPATH": str(tree), "MUTATION_HITS": str(hits.resolve()),
        "TEST_COSTS": str(hits.resolve().with_name("costs.tsv")),
        "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip
    return subprocess.run(
        [sys.executable, *_PYTEST, *arguments],
        cwd=tree, env=environment, capture_output=True, text=True, check=False,
        preexec_fn=None if limit_s is None else partial(_limit_cpu, int(limit_s)),
    )  # fmt: skip


def _limit_cpu(limit_s: int) -> None:
    """Let the process end itself after so many seconds of work, whatever else the machine does."""
    resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s))
