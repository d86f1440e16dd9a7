"""The page from verdicts made by hand: each demand counted on its own trials."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blind.demands import DEMANDS
from tests.blind.hidden import CATALOGUE
from tests.blind.page import write_page
from tests.blind.plan import Cell, lines
from tests.blind.scoring import Score, Verdict, judge
from tests.blind.trials import LIMITED

RUN = {
    "stream": "development", "sealed_at": "2026-01-01T00:00:00+00:00", "rules_sha256": "0" * 64,
    "commit": "1234abcd", "rules_changed": 0, "hidden": 1000, "unreachable": [],
}  # fmt: skip


def plan_cells() -> list[Cell]:
    """Every cell of every line once."""
    return [cell for line in lines() for cell in line.cells]


def _truth(cell: Cell, *, resolved: bool = False, oracle: bool = True) -> dict[str, Any]:
    effects = [
        {
            "key": key, "right": list(CATALOGUE[key].right), "alias": list(CATALOGUE[key].alias),
            "size": 1.0, "unit": "N", "parameter": CATALOGUE[key].parameter,
            "foreign": CATALOGUE[key].foreign, "matters": 3.0,
        }
        for key in cell.hidden
    ]  # fmt: skip
    few = [1.0] * len(cell.hidden)
    limit = {"d0": few, "d1": few, "nearest": ["creep"] * len(few), "right": 0.9, "exact": 0.4}
    known = {"limit": limit if cell.kind in LIMITED else None} if oracle else {}
    return {
        **known,
        "kind": cell.kind, "experiment": cell.experiment, "drift": cell.drift, "rho": cell.rho,
        "left_out": cell.left_out,
        "effects": effects, "seconds": 1.0, "gain": {"force": 0.3},
        "resolved": resolved if cell.kind == "alias" else None,
    }  # fmt: skip


def _oracle(cell: Cell) -> dict[str, Any]:
    """What a perfect diagnosis says."""
    hidden = [CATALOGUE[key] for key in cell.hidden]
    rows: list[dict[str, Any]] = []
    if cell.kind in ("null", "small", "untestable"):
        rows = [{"effect": i.right[0], "status": "not_testable"} for i in hidden]
        return {"verdict": "none", "effects": rows}
    if cell.kind == "underpowered":
        return {"verdict": "underpowered"}
    if cell.kind in ("unseen", "left_out"):
        return {"verdict": "unknown"}
    groups = [list(i.alias) for i in hidden if i.alias]
    causes = [
        {
            "effect": i.right[0], "size": 1.0, "ci95": [0.9, 1.1], "p": 1e-3,
            "held_out_gain": {"quantity": "force", "ci95": [0.2, 0.4]},
        }
        for i in hidden
        if not i.alias
    ]  # fmt: skip
    return {"verdict": "ambiguous" if groups else "named", "causes": causes, "rivals": groups}


def test_a_perfect_diagnosis_meets_every_demand(tmp_path: Path) -> None:
    scores = [judge(_truth(c, resolved=True), Verdict.read(_oracle(c))) for c in plan_cells()]
    assert [d.score for d in DEMANDS if not d.share(scores).trials] == []
    assert [(d.trial, d.score) for d in DEMANDS if not d.met(scores)] == []
    write_page(scores, RUN, tmp_path / "page.md")
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "Every demand that was run is met" in text
    assert "No wrong name" in text
    assert all((tmp_path / "figures" / f"blind_{n}.png").is_file() for n in ("power", "risk"))


def test_the_page_says_what_an_oracle_reaches_where_the_ledger_knows(tmp_path: Path) -> None:
    for oracle in (True, False):
        scores = [judge(_truth(c, oracle=oracle), Verdict.read(_oracle(c))) for c in plan_cells()]
        page = tmp_path / str(oracle) / "page.md"
        page.parent.mkdir()
        write_page(scores, RUN, page)
        text = page.read_text(encoding="utf-8")
        cells = "40 %" if oracle else ""
        assert f"| single, ρ 1 | exact name | ≥ 95 % | {cells} |" in text
        assert "| null | false name | ≤ 1 % |  |" in text
        assert ("*single, ρ 1, exact name* (demanded ≥ 95 %, oracle 40 %)" in text) is oracle
        assert (tmp_path / str(oracle) / "figures" / "blind_limits.png").is_file() is oracle


def _always(verdict: dict[str, Any]) -> list[Score]:
    return [judge(_truth(c), Verdict.read(verdict)) for c in plan_cells()]


@pytest.mark.parametrize(
    ("verdict", "met"),
    [
        # silence is never wrong, and never right where something is there
        ({"verdict": "none"}, {"false name", "any alarm", "confident wrong name",
                               "wrong extra name", "named all the same"}),
        ({"verdict": "unknown"}, {"false name", "confident wrong name", "wrong extra name",
                                  "unknown or flagged", "named all the same"}),
        ({"verdict": "named", "causes": [{"effect": "creep"}]}, set()),
    ],
)  # fmt: skip
def test_a_blind_diagnosis_fails_what_it_should(verdict: dict[str, Any], met: set[str]) -> None:
    scores = _always(verdict)
    assert {d.score for d in DEMANDS if d.share(scores).trials and d.met(scores)} == met


@pytest.mark.slow
def test_random_verdicts_fill_every_panel(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    cells = plan_cells()
    scores = []
    for cell in cells * 3:
        other = cells[int(rng.integers(len(cells)))]
        said = _oracle(cell if rng.random() < 0.3 + 0.6 * min(cell.rho, 1) else other)
        scores.append(judge(_truth(cell), Verdict.read(said)))
    write_page(scores, RUN, tmp_path / "page.md")
    assert (tmp_path / "figures" / "blind_confusion.png").stat().st_size > 20_000
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "**A clean log.**" in text
    missed = (tmp_path / "page_misses.md").read_text(encoding="utf-8")
    assert missed.count("\n| ") > 100
