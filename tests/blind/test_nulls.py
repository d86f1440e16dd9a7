"""Two hundred clean benches of each kind: no name, and hardly an alarm. Minutes long.

Weights come with five families of noise (white, two autoregressive, growing with the load, gains
and offsets of each day), placements with the three that single placements can have.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from scipy import stats

from tests.blind.bench import ask
from tests.blind.diagnosing import diagnosed
from tests.blind.ledger import open_ledger
from tests.blind.plan import Cell
from tests.blind.scoring import Score, Verdict, judge
from tests.blind.trials import make_trial

NULLS = 200
FALSE_NAMES, ALARMS = 0.01, 0.03
RARELY = 0.01
"""Chance with which a diagnosis that is just good enough fails here."""


@pytest.mark.slow
@pytest.mark.parametrize("experiment", ["weights", "placements"])
def test_clean_benches_get_no_name_and_hardly_an_alarm(experiment: str, tmp_path: Path) -> None:
    counter = open_ledger(tmp_path / "ledger", "development")
    scores: list[Score] = []
    for number in range(NULLS):
        logs = tmp_path / str(number)
        cell = Cell("null", experiment)
        truth = make_trial(cell, counter.seed(f"clean {experiment} {number}"), logs)
        ask(logs, experiment, cell.left_out)
        record = diagnosed(logs, tmp_path / "run")
        assert record["verdict"] != "error", record["said"]
        scores.append(judge(truth, Verdict.read(record)))
        shutil.rmtree(logs)
    told = [str(s.verdict) for s in scores if s.alarm]
    assert sum(s.wrong for s in scores) <= stats.binom.ppf(1.0 - RARELY, NULLS, FALSE_NAMES), told
    assert sum(s.alarm for s in scores) <= stats.binom.ppf(1.0 - RARELY, NULLS, ALARMS), told
