"""A stand of cells called in one word (LFSENSOR0), with roll, pitch and yaw of both soles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.several import parts_of

CELLS = np.array([[0.12, 0.05], [0.12, -0.05], [-0.09, 0.05], [-0.09, -0.05]])


def plan_of_stand(folder: Path, word: str, tilt: float) -> LogPlan:
    """One stance of 570 N, 10 s at 50 Hz; the soles pitch by a mean angle in rad."""
    rng = np.random.default_rng(7)
    n = 500
    table = np.vstack([np.ones(4), CELLS.T])
    share = np.linalg.lstsq(table, 285.0 * np.array([1.0, 0.01, 0.0]), rcond=None)[0]
    feet = []
    for y in (0.1, -0.1):
        place = np.array([0.0, y, 0.0])[:, None] + rng.normal(0, 3e-4, (3, n))
        turned = np.array([0.0, tilt, 0.0])[:, None] + rng.normal(0, 2e-3, (3, n))
        feet += [*place, *turned]
    com = np.array([[0.01], [0.0], [0.66]]) + rng.normal(0, 3e-4, (3, n))
    cells = [*np.tile(share[:, None], (2, n)) + rng.normal(0, 0.5, (8, n))]
    poses = [f"{s}FOOT_{a}" for s in "LR" for a in ("x", "y", "z", "roll", "pitch", "yaw")]
    head = ["time", *(f"{s}{word}{i}" for s in "LR" for i in range(4)), "comX", "comY", "comZ"]
    body = np.column_stack([np.arange(n) / 50, *cells, *com, *feet])
    lines = ["# " + " ".join([*head, *poses]), *(" ".join(f"{v:.5f}" for v in row) for row in body)]
    path = folder / "stand.log"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    [part] = parts_of([guess_file(path)])[0]
    return part.plan


@pytest.mark.parametrize("word", ["FSENSOR", "FCELL", "fsensor"])
def test_each_cell_is_of_its_foot(word: str, tmp_path: Path) -> None:
    plan = plan_of_stand(tmp_path, word, 0.01)
    assert len(plan.channels) == 8
    assert sorted({name.partition("_")[0] for name in plan.channels}) == ["left", "right"]
    for side in ("left", "right"):
        for angle in ("roll", "pitch", "yaw"):
            entry = plan.entries[f"{side}_foot_{angle}_rad"]
            assert entry.column is not None
            assert entry.column.column == f"{side[0].upper()}FOOT_{angle}"


def test_angles_that_are_no_soles_are_left(tmp_path: Path) -> None:
    plan = plan_of_stand(tmp_path, "FSENSOR", 1.4)
    assert "left_foot_pitch_rad" not in plan.entries
    assert "left_foot_yaw_rad" in plan.entries


@pytest.mark.parametrize(
    ("name", "side"), [("LHSENSOR0", ""), ("LFLEG", ""), ("RFSENSOR", "right")]
)
def test_hands_and_legs_are_no_feet(name: str, side: str) -> None:
    assert name_guess(name).side == side
