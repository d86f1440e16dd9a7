"""`offline-fit` on placements of a foot in a world that it does not know."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.bench.cop_study import FootStudy, study_cop
from footcal_cli.core.bench.placement_rows import PlacementRows, holes_of
from footcal_cli.sheets.placements import misplaced_cells
from tests.foreign import CELLS, draw_biped, placements


def left_foot(seed: int, moved_m: np.ndarray | None = None) -> FootStudy:
    """The left foot's placements, its scales and zeros known from weights."""
    robot = draw_biped(seed)
    frame = placements(seed, moved_m=moved_m).logs["placements"]
    one = frame[frame["foot"] == "left"]
    counts = one[[f"{cell}_counts" for cell in CELLS]].to_numpy()
    hole = one[["hole_x_m", "hole_y_m"]].to_numpy()
    rows = PlacementRows(
        tuple(f"left_{cell}" for cell in CELLS), (counts - robot.zero[:4]) * robot.scale[:4],
        robot.cells_m, hole, one["load_n"].to_numpy(), holes_of(hole),
    )  # fmt: skip
    return FootStudy("left", rows, study_cop(rows))


def test_one_cell_twelve_millimetres_off_is_found_by_placements_and_no_other() -> None:
    moved = np.zeros((8, 2))
    moved[1] = [0.012, 0.0]
    found = misplaced_cells(left_foot(41, moved))
    assert [one.where for one in found] == ["left_fr"]
    said = float(found[0].sentence.split("(x ")[1].split(",")[0])
    assert said == pytest.approx(12.0, abs=2.0)
    assert not misplaced_cells(left_foot(41))
