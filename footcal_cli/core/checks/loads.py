"""Weights on single cells: rows off the line of all others, and readings that lag behind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from footcal_cli.core.checks.lines import least_absolute, weighted_residual
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding, listed
from footcal_cli.core.signals import median_sd

OFF, OFF_SD = 0.06, 12.0
"""A row is off by this share of the loads' range, and so many robust sd of the others: no curve and
no loop of a cell makes it."""
MOST_OFF = 0.2
"""Of more rows it is no slip."""
LAGS, LAGS_SHARE = 0.15, 0.5
"""Share of the last change of load that is lacking, and of the residual that it explains."""
_FEWEST_ROWS = 12


@listed
def check_line(
    channel: str, load_n: FloatArray, counts: FloatArray, again: FloatArray
) -> Iterator[Finding]:
    """Rows against the line that the others lie on.

    Parameters
    ----------
    load_n, counts
        In the order they were taken, shape (n,).
    again
        Number of the session of each row, shape (n,): its zero is its own.
    """
    good = np.isfinite(load_n) & np.isfinite(counts)
    load, count, part = load_n[good], counts[good], again[good]
    if load.size < _FEWEST_ROWS or np.unique(load).size < 4 or not np.ptp(count) > 0:
        return
    sessions = np.unique(part)
    design = np.column_stack([count, *((part == s).astype(float) for s in sessions)])
    residual = least_absolute(design, load)
    sd = median_sd(residual)
    kept = np.abs(residual) < max(OFF * float(np.ptp(load)), OFF_SD * sd)
    residual = weighted_residual(design, load, kept.astype(float))
    out = np.flatnonzero(~kept)
    if out.size and out.size <= MOST_OFF * load.size:
        worst = int(out[np.argmax(np.abs(residual[out]))])
        yield Finding(
            "rows_off_the_line", "warning", channel,
            f"{out.size} of {load.size} rows lie far off the line of the others, the furthest "
            f"{load[worst]:.4g} N where its reading shows {load[worst] - residual[worst]:.4g} N",
            "check the load that was written down, and whose reading stands there",
        )  # fmt: skip
        return
    yield from _lag(channel, load, residual, part)


def _lag(
    channel: str, load: FloatArray, residual: FloatArray, part: FloatArray
) -> Iterator[Finding]:
    """Readings that lack a share of the last change of load: taken too early, or hysteresis."""
    change = np.diff(load) * (np.diff(part) == 0)
    left = residual[1:] - residual[1:].mean()
    if not change @ change > 0 or not left @ left > 0:
        return
    lacking = float(change @ left) / float(change @ change)
    explained = (lacking**2) * float(change @ change) / float(left @ left)
    if lacking > LAGS and explained > LAGS_SHARE:
        yield Finding(
            "readings_lag", "warning", channel,
            f"readings lack {100 * lacking:.0f} % of the last change of the load",
            "wait longer before each reading; if it does not help, the cell has hysteresis: record "
            "loads going up and going down",
        )  # fmt: skip
