"""How many stances it takes: the error on the stance that follows one, two, five, ten."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.static_init import StanceRows, fit_static

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
