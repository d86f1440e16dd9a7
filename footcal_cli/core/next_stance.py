"""Which stance to add to those in hand, and what it would teach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.observability import NextStep, rank_candidates
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.stances import StanceRows
from footcal_cli.core.static_init import fit_static

COUNTS = (1, 2, 5, 10)


@dataclass(frozen=True)
class CurvePoint:
    """CoP error on the next stance after so many.

    Parameters
    ----------
    stances, rank
        Stances used, and directions they see (median over where one starts to count).
    before_m, after_m, least_squares_m
        RMS over all runs of so many successive stances, with the prior alone, with it and the
        stances, and by least squares of eq. (13) without a prior.
    tried
        How many runs there are.
    """

    stances: int
    rank: int
    before_m: float
    after_m: float
    least_squares_m: float
    tried: int


def stance_curve(rows: StanceRows, belief: Belief, weight_n: float) -> list[CurvePoint]:
    """Fit runs of successive stances and predict the CoP of the stance after each.

    Nothing where there are fewer than two stances or no CoP to compare with.
    """
    count = int(rows.stance.max(initial=-1)) + 1
    if not {"mx", "my"} <= set(rows.output):
        return []
    found = []
    for used in COUNTS:
        if used >= count:
            break
        errors, ranks = [], []
        for first in range(count):
            # after the last stance comes the first: all are as good a start as any
            taken = (first + np.arange(used)) % count
            part = rows.only(np.isin(rows.stance, taken))
            fit = fit_static(part, belief)
            ours = np.concatenate([fit.gain, fit.bias_n])
            after = rows.only(rows.stance == (first + used) % count)
            errors.append(
                [_cop_m(after, v, weight_n) for v in (0.0 * ours, ours, fit.least_squares)]
            )
            ranks.append(fit.observability.rank)
        before, ours_m, plain = (float(v) for v in np.sqrt(np.mean(np.square(errors), axis=0)))
        found.append(CurvePoint(used, int(np.median(ranks)), before, ours_m, plain, len(errors)))
    return found


def _cop_m(rows: StanceRows, values: FloatArray, weight_n: float) -> float:
    """Distance of a stance's CoP from where it belongs."""
    left = rows.error + rows.h @ (values / rows.prior_sd)
    moments = [left[i] for i, name in enumerate(rows.output) if name in ("mx", "my")]
    return float(np.linalg.norm(moments) / weight_n)


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
    total, moment, swinging = rows.floors
    sd = [total, moment, moment]
    if lifted is not None:
        swing = np.zeros((feet[lifted].size, 2 * c))
        swing[np.arange(feet[lifted].size), c + feet[lifted]] = 1.0
        h = np.concatenate([h, swing])
        sd += [swinging] * feet[lifted].size
    return np.asarray(h * rows.prior_sd / np.array(sd)[:, None])
