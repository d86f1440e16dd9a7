"""Which stance to add to those in hand, and what it would teach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.inference.observability import NextStep, rank_candidates
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.static_init import FORCE_SD_N, MOMENT_SD_NM, SWING_SD_N, StanceRows

MENU: Mapping[str, tuple[float, float, float]] = {
    "shift weight left": (0.0, 0.6, 0.0),
    "shift weight right": (0.0, -0.6, 0.0),
    "shift weight front": (0.6, 0.0, 0.0),
    "shift weight back": (-0.6, 0.0, 0.0),
    "squat": (0.0, 0.0, 1.0),
}
"""Stances that keep the feet: CoP forward and left as a share of the way to the edge, squat."""
REPLACED = {"left": "re-place the left foot", "right": "re-place the right foot"}
ONE_FOOT = {"left": "stand on the right foot only", "right": "stand on the left foot only"}


def next_stances(
    rows: StanceRows,
    cells_w_m: FloatArray,
    feet: Sequence[Sequence[int]],
    foot_names: Sequence[str],
    weight_n: float,
    belief: Belief,
) -> list[NextStep]:
    """Which stance to add next, and what it would bring, best first.

    Parameters
    ----------
    rows
        The stances in hand.
    cells_w_m
        Positions of the cells in the last stance, shape (c, 2).
    feet
        Columns of each foot's cells.
    foot_names
        Their names (left, right).
    weight_n
        Body weight.
    belief
        For the channels and the units.
    """
    feet_columns = [np.asarray(f) for f in feet]
    candidates = {
        name: _imagined(rows, cells_w_m, feet_columns, weight_n, belief, ahead, left)
        for name, (ahead, left, _) in MENU.items()
    }
    for k, foot in enumerate(foot_names):
        moved = cells_w_m.copy()
        middle = moved[feet_columns[k]].mean(axis=0)
        turn = np.array([[0.955, -0.296], [0.296, 0.955]])  # 0.3 rad, and 4 cm ahead
        moved[feet_columns[k]] = (moved[feet_columns[k]] - middle) @ turn.T + middle
        moved[feet_columns[k], 0] += 0.04
        name = REPLACED.get(foot, f"re-place the {foot} foot")
        candidates[name] = _imagined(rows, moved, feet_columns, weight_n, belief, 0.0, 0.0)
        if len(foot_names) > 1:
            candidates[ONE_FOOT.get(foot, f"lift the {foot} foot")] = _imagined(
                rows, cells_w_m, feet_columns, weight_n, belief, 0.0, 0.0, lifted=k
            )
    return rank_candidates(rows.whitened, rows.prior_correlation, candidates, rows.names)


def _imagined(
    rows: StanceRows,
    cells: FloatArray,
    feet: Sequence[IntArray],
    weight_n: float,
    belief: Belief,
    ahead: float,
    left: float,
    lifted: int | None = None,
) -> FloatArray:
    """Whitened rows (k, p) of a stance with these cells and this CoP."""
    c = len(belief.channels)
    share = np.full(len(feet), 1.0 / len(feet))
    if len(feet) == 2:
        share = np.array([0.5 + left / 2.0, 0.5 - left / 2.0])
    if lifted is not None:
        share = np.where(np.arange(len(feet)) == lifted, 0.0, 1.0)
    force = np.zeros(c)
    for k, columns in enumerate(feet):
        offset = cells[columns, 0] - cells[columns, 0].mean()
        lean = 1.0 + ahead * offset / max(np.abs(offset).max(), 1e-9)
        force[columns] = share[k] * weight_n * lean / lean.sum()
    cop = force @ cells / force.sum()
    arms = cells - cop
    per_force = np.stack([np.ones(c), arms[:, 1], -arms[:, 0]])
    h = np.concatenate([per_force * force, per_force], axis=1)
    sd = [FORCE_SD_N, MOMENT_SD_NM, MOMENT_SD_NM]
    if lifted is not None:
        swing = np.zeros((feet[lifted].size, 2 * c))
        swing[np.arange(feet[lifted].size), c + feet[lifted]] = 1.0
        h = np.concatenate([h, swing])
        sd += [SWING_SD_N] * feet[lifted].size
    return np.asarray(h * rows.prior_sd / np.array(sd)[:, None])
