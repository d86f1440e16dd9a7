"""One fault of each law that `check` asks logs for, and that clean logs keep all of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults.bases import BASES, Base
from tests.faults.corpus import prepared
from tests.faults.judging import call, laid_out, words_in
from tests.faults.unseen import (
    BODIES,
    HANGS,
    IN_POSES,
    PLACED,
    PLACEMENTS,
    POSES,
    STANDS,
    WALKS,
    WEIGHTS,
    unseen_jobs,
)  # fmt: skip


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    bases = [BASES[name] for name in ("check_weights", "check_walk", "check_hang")]
    return prepared(tmp_path_factory.mktemp("unseen") / "inputs", bases)


_QUICK = ("holes mirrored", "bit lost", "touched the stand", "contact inverted", "load mistyped",
          "cells exchanged midway")  # fmt: skip
_NAMES = dict.fromkeys(
    change.__name__.replace("_", " ")
    for changes in (WEIGHTS, PLACEMENTS, STANDS, WALKS, BODIES, HANGS, IN_POSES)
    for change in changes
)


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=() if name in _QUICK else pytest.mark.slow)
    for name in _NAMES
])  # fmt: skip
def test_a_log_that_breaks_a_law_is_no_clean_one(name: str, inputs: Path, tmp_path: Path) -> None:
    job = next(job for job in unseen_jobs(inputs, 4) if f": {name} |" in job.key)
    assert job.run(tmp_path / "case").violations == ()


@pytest.mark.parametrize("base", [PLACED, POSES, BASES["check_walk"], BASES["check_hang"]],
                         ids=lambda base: base.name)  # fmt: skip
def test_clean_logs_keep_all_of_them(base: Base, inputs: Path, tmp_path: Path) -> None:
    folder = tmp_path / "case"
    laid_out(base, inputs, folder)
    code, said, err = call(
        [*words_in(base, folder), "--strict-findings", "--out", str(tmp_path / "o")]
    )
    assert (code, err) == (0, ""), said
