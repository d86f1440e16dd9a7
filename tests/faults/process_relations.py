"""Relations of the process: threads, the order of hashes and the locale must not matter."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import partial
from pathlib import Path

from tests.conftest import REPOSITORY
from tests.faults.bases import Base
from tests.faults.facts import differences, facts_of
from tests.faults.judging import laid_out, spoken, words_in
from tests.faults.relations import EXACT, bases_of, unchanged
from tests.faults.running import Job, Outcome

SETTINGS = {
    "one thread": {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    "four threads": {"OMP_NUM_THREADS": "4", "OPENBLAS_NUM_THREADS": "4"},
    "hashes of [NAO]": {"PYTHONHASHSEED": "1"},
    "hashes of [Wu]": {"PYTHONHASHSEED": "2"},
    "locale C": {"LC_ALL": "C", "LANG": "C", "PYTHONUTF8": "0"},
    "locale of Turkey": {"LC_ALL": "tr_TR.UTF-8", "LANG": "tr_TR.UTF-8"},
}


def process_relations(inputs: Path) -> list[Job]:
    """Commands of every kind in a process of their own, each setting by itself."""
    return [
        Job(f"{base.name} | {name}", "relation", "process", partial(_run, base, name, inputs))
        for base in bases_of("weights", "together", "stand", "apply", "check_walk", "hang")
        for name in SETTINGS
    ]


def _run(base: Base, name: str, inputs: Path, folder: Path) -> Outcome:
    was = unchanged(base, inputs, folder)
    laid_out(base, inputs, folder)
    out = folder / base.out
    words = [*words_in(base, folder), "--no-pictures", "--out", str(out)]
    ended = subprocess.run(
        [sys.executable, "-m", "footcal_cli", *words],
        capture_output=True, text=True, check=False, cwd=folder,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY), **SETTINGS[name]},
    )  # fmt: skip
    broken = spoken(ended.returncode, ended.stderr)
    if out.is_dir():
        broken += differences(was, facts_of(out), sds=EXACT)
    else:
        broken.append(f"exit code {ended.returncode}: {ended.stderr.strip()[:200]}")
    return Outcome(
        f"{base.name} | {name}", "relation", "process", ended.returncode, "", "", tuple(broken[:3])
    )
