"""How well wrenches of two feet balance the motion, offsets left free, and which axis reads amiss.

Room: core.pose; asked by turned and intake. An axis of turned sign, or two that are exchanged,
spoils one sum or two and leaves the others as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.experiments.walk import balance, feet_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding

LEVER_M = 0.1
"""Moments count as forces at this lever."""
_SUMS = 5
"""Three forces and two moments about the floor."""
_MOST_ROWS, _FEWEST_ROWS = 400, 20
_LEFT, _SPOILT = 0.35, 0.15
"""Share of a sum's squared misfit that is left where an axis is put right; by how much of that gain
others may grow."""
_CLEARLY = 0.5
"""And at most this share of what the next best one leaves; closer ones are named together."""


@dataclass(frozen=True)
class FeetBalance:
    """Some rows of a stand or a walk on six-axis feet.

    Parameters
    ----------
    log
        The rows.
    use
        Those whose sums are all known, shape (n,).
    seen
        What offsets do to the sums, orthonormal, shape (5 rows, k).
    """

    log: Log
    use: BoolArray
    seen: FloatArray

    def misfit(self, readings: FloatArray) -> FloatArray:
        """Squared misfit of each sum in N², offsets left free, shape (5,)."""
        error = _errors(self.log, readings)[self.use].ravel()
        rest = error - self.seen @ (self.seen.T @ error)
        return np.asarray((rest.reshape(-1, _SUMS) ** 2).sum(axis=0))


def _errors(log: Log, readings: FloatArray) -> FloatArray:
    to_newtons = np.array([1.0, 1.0, 1.0, 1.0 / LEVER_M, 1.0 / LEVER_M])
    return np.asarray(balance(log.with_readings(readings)).error[:, :_SUMS] * to_newtons)


def balance_of_feet(log: Log) -> FeetBalance | None:
    """Rows of a log in which all is known; None where they are too few."""
    good = np.isfinite(log.readings).all(axis=1) & np.isfinite(log.known["com_m"]).all(axis=1)
    good &= np.isfinite(log.known["com_acc_mps2"]).all(axis=1)
    good &= np.isfinite(log.known["foot_rot_wt"]).all(axis=(1, 2, 3))
    rows = np.flatnonzero(good)
    if rows.size < _FEWEST_ROWS:
        return None
    log = log.at(rows[:: max(rows.size // _MOST_ROWS, 1)])
    use = np.asarray(balance(log).valid[:, :_SUMS].all(axis=1))
    if use.sum() < _FEWEST_ROWS:
        return None
    start = _errors(log, log.readings)
    unit = np.eye(log.readings.shape[1])
    moved = [(_errors(log, log.readings + one) - start)[use].ravel() for one in unit]
    left, size, _ = np.linalg.svd(np.stack(moved, axis=1), full_matrices=False)
    return FeetBalance(log, use, np.asarray(left[:, size > 1e-6 * size[0]]))


def check_axes_of_feet(feet: FeetBalance) -> list[Finding]:
    """Find an axis of a foot that reads with the sign turned, or two that are exchanged."""
    given = feet.misfit(feet.log.readings)
    tried = []
    for k, foot in enumerate(feet_of(feet.log)):
        for own in (*((a,) for a in range(6)), *combinations(range(3), 2),
                    *combinations(range(3, 6), 2)):  # fmt: skip
            readings, at = feet.log.readings.copy(), [6 * k + a for a in own]
            readings[:, at] = readings[:, at[::-1]] if len(at) > 1 else -readings[:, at]
            left = feet.misfit(readings)
            more, less = np.maximum(left - given, 0.0).sum(), np.maximum(given - left, 0.0).sum()
            share = left / given
            # offsets that took a part of the moments up spoil forces a little
            if share.min() < _LEFT and more < _SPOILT * less:
                tried.append((float(share.min()), foot, own, float(left.sum())))
    if not tried:
        return []
    best = min(tried, key=lambda one: one[3])
    alike = [one for one in tried if one[3] <= best[3] / _CLEARLY]
    said = [f"{' and '.join(AXES[a] for a in own)} of {foot}" for _, foot, own, _ in alike]
    exchanged = len(best[2]) > 1
    where = " or ".join(dict.fromkeys(foot for _, foot, _, _ in alike))
    names = " or ".join(dict.fromkeys(said[i] for i in np.argsort([one[3] for one in alike])))
    what = "look exchanged" if exchanged else "reads with the sign reversed"
    return [
        Finding(
            "axes_exchanged" if exchanged else "axis_turned", "alarm", where,
            f"{names} {what}: put right, {best[0]:.0%} of the squared misfit of one sum over the "
            "feet remains",
            f"correct the wiring or the axes of {where} in [columns], then calibrate again",
        )
    ]  # fmt: skip
