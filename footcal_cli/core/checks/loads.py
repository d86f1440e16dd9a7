"""Weights on single cells: rows off the line of all others, and readings that lag behind."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from footcal_cli.core.checks.lines import least_absolute, weighted_residual
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding, listed
from footcal_cli.core.signals import median_sd

OFF, OFF_SD = 0.06, 12.0
"""A row is an outlier from this share of the loads' range and this many robust sd of the others on:
no curve and no hysteresis of a cell is that large."""
MOST_OFF = 0.2
"""Share of the rows beyond which it is no slip of a hand."""
LAGS, LAGS_SHARE = 0.15, 0.5
"""Share of the last change of load that is lacking, and of the residual that it explains."""
OWN, OTHERS = 12.0, 4.0
"""So many robust sd is a reading off its own cell's line at least, and off the other's at most,
where two were exchanged: both are off by as much, one up and one down."""
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
    rows = _known(load_n, counts, again)
    if rows is None:
        return
    load, count, part = rows
    design = _by_session(count, part)
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


@listed
def check_exchanged(
    cells: Mapping[str, tuple[FloatArray, FloatArray, FloatArray]],
) -> Iterator[Finding]:
    """Readings of one load that stand under each other's names.

    Each is `OWN` robust sd off its own cell's line and within `OTHERS` of the other's: no curve of
    one cell is where the other one's readings are.

    Parameters
    ----------
    cells
        Channel -> loads in N, counts, and the number of the session of each row, shape (n,) each.
    """
    lines = {name: line for name, rows in cells.items() if (line := _Line.through(*rows))}
    for one, other in combinations(lines, 2):
        a, b = lines[one], lines[other]
        for load, part in sorted(a.read.keys() & b.read.keys()):
            at = (load, part)
            own = min(a.off(at, a.read[at]), b.off(at, b.read[at]))
            if own > OWN and max(a.off(at, b.read[at]), b.off(at, a.read[at])) < OTHERS:
                yield Finding(
                    "readings_exchanged", "warning", f"{one}, {other}",
                    f"the readings at {load:.4g} N lie on each other's lines, at least {own:.0f} "
                    "robust standard deviations off their own",
                    "check which reading is whose, and exchange them in the log",
                )  # fmt: skip
                return


@dataclass(frozen=True)
class _Line:
    """A cell's counts at each load of each session, and those of the line through all of them.

    Parameters
    ----------
    read, drawn
        (Load, session) -> mean counts, and counts of ``a load + b_session``.
    sd
        Robust, of the residual.
    """

    read: Mapping[tuple[float, float], float]
    drawn: Mapping[tuple[float, float], float]
    sd: float

    @classmethod
    def through(cls, load_n: FloatArray, counts: FloatArray, again: FloatArray) -> _Line | None:
        """The line of least absolute errors; None of too few rows or loads."""
        known = _known(load_n, counts, again)
        if known is None:
            return None
        load, count, part = known
        left = least_absolute(_by_session(load, part), count)
        rows = {at: (load == at[0]) & (part == at[1]) for at in zip(load, part, strict=True)}
        read = {at: float(count[mine].mean()) for at, mine in rows.items()}
        drawn = {at: float((count - left)[mine][0]) for at, mine in rows.items()}
        return cls(read, drawn, max(median_sd(left), 1e-12))

    def off(self, at: tuple[float, float], count: float) -> float:
        """How many sd a reading at a load of a session is off the line."""
        return abs(count - self.drawn[at]) / self.sd


def _known(
    load_n: FloatArray, counts: FloatArray, again: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Rows in which load and reading are known; None of too few, or a reading that never moves."""
    good = np.isfinite(load_n) & np.isfinite(counts)
    load, count, part = load_n[good], counts[good], again[good]
    if load.size < _FEWEST_ROWS or np.unique(load).size < 4 or not np.ptp(count) > 0:
        return None
    return load, count, part


def _by_session(column: FloatArray, part: FloatArray) -> FloatArray:
    """The design of a line with a zero of its own in each session, shape (n, 1 + sessions)."""
    return np.column_stack([column, *((part == s).astype(float) for s in np.unique(part))])


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
