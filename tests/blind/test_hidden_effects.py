"""A few blind trials: hidden effects are found, or honestly not found.

The whole bench is ``make blind``. Seeds come from a counter, chosen before anything was diagnosed,
and stay. Every test run has one or two trials per experiment, which must all be right; the others
(``make studies``) are judged by what so few trials can tell. Nothing but the logs, the recipe and
the kind of experiment reaches the diagnosis.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from scipy import stats

from footcal_cli.core.diagnosis.evidence_table import AS_GOOD
from tests.blind.bench import ask
from tests.blind.diagnosing import diagnosed
from tests.blind.ledger import open_ledger
from tests.blind.plan import Cell
from tests.blind.scoring import Score, Verdict, judge
from tests.blind.trials import make_trial

RIGHT, WRONG = 0.75, 0.01
"""Share of right answers below, and of wrong names above which a diagnosis is of no use."""
RARELY = 0.01

CELLS = {
    "weights": (
        Cell("null", "weights"),
        Cell("single", "weights", ("hysteresis/bouc_wen",), 1.0),
        Cell("single", "weights", ("creep/two_stage",), 1.0),
        Cell("single", "weights", ("nonlinearity/table",), 1.0),
        Cell("single", "weights", ("temperature_bias/table",), 1.0),
        Cell("pair", "weights", ("hysteresis/bouc_wen", "temperature_bias/table"), 1.0),
        Cell("unseen", "weights", ("unseen/mains_hum",), 1.5),
        Cell("left_out", "weights", ("creep/table",), 1.0, left_out="creep creep_slow"),
        Cell("underpowered", "weights", ("hysteresis/table",), 1.0),
    ),
    "placements": (
        Cell("null", "placements"),
        Cell("single", "placements", ("cell_position/belief",), 1.0),
        Cell("single", "placements", ("crosstalk/neighbour",), 1.0),
        Cell("single", "placements", ("nonlinearity/table",), 1.0),
        Cell("pair", "placements", ("cell_position/belief", "nonlinearity/exponential"), 1.0),
        Cell("unseen", "placements", ("unseen/edge_contact",), 1.5),
    ),
    "walk": (
        Cell("null", "walk"),
        Cell("single", "walk", ("crosstalk/neighbour",), 1.0),
        Cell("single", "walk", ("hysteresis/bouc_wen",), 1.0),
        Cell("alias", "walk", ("delay/jittered",), 1.0),
        Cell("unseen", "walk", ("unseen/mains_hum",), 1.5),
    ),
    "walk, drifting": (
        Cell("null", "walk", drift=True),
        Cell("single", "walk", ("cell_position/belief",), 1.0, drift=True),
        Cell("single", "walk", ("hanging_plate/uneven",), 1.0, drift=True),
        Cell("untestable", "walk", ("mass/belief",), drift=True),
    ),
    "stand": (
        Cell("null", "stand"),
        Cell("alias", "stand", ("com_offset/standing",), 1.0),
        Cell("single", "stand", ("nonlinearity/table",), 1.0),
    ),
    "hang": (
        Cell("null", "hang"),
        Cell("single", "hang", ("offset_drift/linear",), 1.0),
        Cell("single", "hang", ("cable_drag/spring",), 1.0),
        Cell("unseen", "hang", ("unseen/leg_hum",), 1.5),
    ),
    "pose": (
        Cell("null", "pose"),
        Cell("alias", "pose", ("scale_matrix/standing",), 1.0),
        Cell("alias", "pose", ("robot_weight/belief",), 1.0),
        Cell("single", "pose", ("cable_drag/spring",), 1.0),
    ),
}

QUICK = {
    "weights": (0, 1),
    "placements": (0, 1),
    "walk": (1,),
    "walk, drifting": (0,),
    "stand": (0,),
}
"""Trials by number: the cheap ones of every test run, of walks one effect; the clean one that
drifts is slow. What stands and legs hide is looked for by
`tests.core.test_diagnosis_stances`, `tests.core.test_diagnosis_legs` and `tests.cli`, hangings and
poses without an effect by `tests.cli.test_shipped_pipeline`."""


def _scores(group: str, numbers: Sequence[int], folder: Path) -> list[Score]:
    counter = open_ledger(folder / "ledger", "development")
    scores = []
    for number in numbers:
        cell = CELLS[group][number]
        logs = folder / str(number)
        truth = make_trial(cell, counter.seed(f"in every test run: {group} {number}"), logs)
        ask(logs, cell.experiment, cell.left_out)
        record = diagnosed(logs, folder / "run")
        if record["verdict"] == "not available":
            pytest.skip(f"no diagnosis of {cell.experiment}")
        assert record["verdict"] != "error", record["said"]
        assert not _contradictions(record)
        scores.append(judge(truth, Verdict.read(record)))
    return scores


def _contradictions(record: dict[str, Any]) -> list[str]:
    """Where the evidence table says of a cause something else than the sentence does."""
    rows = {row["effect"]: row for row in record["effects"]}
    told = []
    for cause in record["causes"]:
        tied = rows[cause["effect"]]["reason"].startswith(AS_GOOD)
        if tied != bool(cause["rivals"]):
            told.append(f"{cause['effect']}: rivals {cause['rivals']}, {rows[cause['effect']]}")
    return told


@pytest.mark.parametrize(
    "group",
    [pytest.param(g, marks=[pytest.mark.slow] if g == "walk, drifting" else []) for g in QUICK],
)
def test_a_clear_effect_is_named_and_a_clean_log_is_not(group: str, tmp_path: Path) -> None:
    for number, score in zip(QUICK[group], _scores(group, QUICK[group], tmp_path), strict=True):
        told = f"{CELLS[group][number].hidden} -> {score.verdict}"
        assert not score.wrong, told
        assert score.right, told


@pytest.mark.slow
@pytest.mark.parametrize("group", CELLS)
def test_hidden_effects_are_found_or_honestly_not_found(group: str, tmp_path: Path) -> None:
    cells = CELLS[group]
    scores = _scores(group, range(len(cells)), tmp_path)
    told = [f"{c.hidden} -> {s.verdict}" for c, s in zip(cells, scores, strict=True)]
    most_wrong = int(stats.binom.ppf(1.0 - RARELY, len(scores), WRONG))
    fewest_right = int(stats.binom.ppf(RARELY, len(scores), RIGHT))
    assert sum(s.wrong for s in scores) <= most_wrong, told
    assert sum(s.right for s in scores) >= fewest_right, told


def test_exchanged_cells_of_a_stand_stop_the_diagnosis(tmp_path: Path) -> None:
    """What is left of the balance looks like no effect; the wiring is looked at first."""
    cell = Cell("switch", "stand", ("channel_swap/wires",))
    make_trial(cell, 9700, tmp_path / "logs")
    ask(tmp_path / "logs", "stand")
    record = diagnosed(tmp_path / "logs", tmp_path / "run")
    assert record["verdict"] == "bad-data"
    assert "exchanged_channels" in {finding["code"] for finding in record["findings"]}
