"""A weight that is written as another one: one load at which a cell reads what it reads at another.

Room: core, checks; asked by the inspection of bench logs.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding

_FEWEST, _MOST = 8, 300
"""Loads put on, one after the other: fewer show no rule, and more are a reference that moves."""
_FAR_SD, _FAR_SPAN = 8.0, 0.02
"""How far a wrong one lies from the line of all: in their usual distance, and of their span."""
_LIKE_SD, _LIKE = 4.0, 0.1
"""How near it reads to another load: in the same, and of how far it is from its own."""
_BESIDE = 0.3
"""Of how far a wrong one lies off: less than its neighbours in time do."""
_RARE = 0.2
_NORMAL = 1.4826  # sd of a normal variable over its median |x|


def check_labels(load_n: FloatArray, counts: FloatArray, channel: str) -> list[Finding]:
    """Find loads that were written down wrongly.

    A robust straight line (Theil and Sen: the median of the slopes between all pairs) through the
    level at each load that was put on shows the ones that lie far off. Such a load is a wrong label
    if the cell reads what it reads at another load, and its own label is right elsewhere, or is
    written there alone. A curve, a jump and a drift move neighbours in load or time as well, and
    to no other label.

    Parameters
    ----------
    load_n, counts
        Of one session, in the order they were taken, shape (n,).
    channel
        For the finding.
    """
    good = np.flatnonzero(np.isfinite(load_n) & np.isfinite(counts))
    first = np.flatnonzero(np.diff(load_n[good], prepend=np.nan) != 0.0)
    if not _FEWEST <= first.size <= _MOST:
        return []
    ends = np.append(first[1:], good.size)
    load = load_n[good[first]]
    level = np.array([
        np.median(counts[good[(start + end) // 2 : end]])
        for start, end in zip(first, ends, strict=True)
    ])  # fmt: skip
    seems, sd = _read_as(load, level)
    moved = seems - load
    off = np.abs(moved)
    # what comes and goes in time moves the load before it or after it the same way
    padded = np.concatenate([[0.0], moved, [0.0]])
    beside = np.maximum(np.sign(moved) * padded[:-2], np.sign(moved) * padded[2:])
    far = off > np.maximum(_FAR_SD * sd, _FAR_SPAN * np.ptp(load))
    if not 0 < far.sum() <= _RARE * load.size:
        return []
    found = []
    for at in np.flatnonzero(far & (beside < _BESIDE * off)).tolist():
        like = _label_of(at, load, seems, far, min(_LIKE_SD * sd, _LIKE * float(off[at])))
        if like is not None:
            rows = good[first[at]] + 1, good[ends[at] - 1] + 1
            found.append(_finding(channel, rows, float(load[at]), like, load, far))
    return found


def _read_as(load: FloatArray, level: FloatArray) -> tuple[FloatArray, float]:
    """The load that each level stands for on the robust line, and the usual distance from it."""
    one, other = np.triu_indices(load.size, 1)
    apart = load[one] != load[other]
    slopes = (level[one] - level[other])[apart] / (load[one] - load[other])[apart]
    slope = float(np.median(slopes)) if slopes.size else 0.0
    if slope == 0.0:
        return load, np.inf
    seems = (level - float(np.median(level - slope * load))) / slope
    usual = _NORMAL * float(np.median(np.abs(seems - load)))
    return seems, max(usual, 1e-4 * float(np.ptp(load)))


def _label_of(
    at: int, load: FloatArray, seems: FloatArray, far: BoolArray, near: float
) -> float | None:
    """The other load at which the cell reads the same, None where there is none."""
    alone = np.sum(load == load[at]) == 1
    right = bool(np.any((load == load[at]) & ~far))
    labels = np.unique(load[~far & (load != load[at])])
    if not (alone or right) or not labels.size:
        return None
    read = np.array([np.median(seems[~far & (load == label)]) for label in labels])
    nearest = int(np.argmin(np.abs(read - seems[at])))
    return float(labels[nearest]) if abs(read[nearest] - seems[at]) <= near else None


def _finding(
    channel: str,
    rows: tuple[int, int],
    written_n: float,
    like_n: float,
    load: FloatArray,
    far: BoolArray,
) -> Finding:
    times = int(np.sum((load == like_n) & ~far))
    often = "once" if times == 1 else f"{times} times"
    where = f"row {rows[0]}" if rows[0] == rows[1] else f"rows {rows[0]} to {rows[1]}"
    return Finding(
        "wrong_label",
        "alarm",
        channel,
        f"the load of {where} is written as {written_n:.5g} N, but the cell reads what it reads at "
        f"{like_n:.5g} N ({often} elsewhere)",
        f"correct the load of {where}, or leave the {'row' if rows[0] == rows[1] else 'rows'} out",
    )
