r"""Channels of which only the zero moves from session to session: one scale, a zero for each.

Room: bench (`footcal_cli.core.bench`); asked by the sheets of weights.

.. math:: S = b F + a_g, \qquad z_g = -a_g / b

with the reading S under the load F in session g. A cell that was mounted anew or tared between two
ladders has such zeros: no curve, loop or creep, and no line of the whole, describes it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.regression import AffineFit, fit_affine
from footcal_cli.core.parameters import FloatArray

_LEAST_ROWS = 3
"""Rows of a session that show its zero."""


@dataclass(frozen=True)
class MovedZeros:
    """Zeros of a channel in its sessions, and the line that is left without their moves.

    Parameters
    ----------
    zero_n
        What the readings of each session are off by, about their mean, shape (g,).
    fit
        Of readings less the move of their session's zero.
    """

    zero_n: FloatArray
    fit: AffineFit

    @property
    def span_n(self) -> float:
        """How far the zero moves."""
        return float(np.ptp(self.zero_n))


def moved_zeros(record: BenchRecord) -> MovedZeros | None:
    """Zeros of each session of a channel under one scale; None of fewer than two sessions."""
    known = record.known
    load, reading = record.load_n[known], record.reading[known]
    names, at, rows = np.unique(record.session[known], return_inverse=True, return_counts=True)
    if names.size < 2 or rows.min() < _LEAST_ROWS:
        return None

    def about(values: FloatArray) -> FloatArray:
        return np.asarray(values - (np.bincount(at, values) / rows)[at])

    within = about(load)
    if not within @ within > 0.0:
        return None
    slope = float(within @ about(reading)) / float(within @ within)
    if slope == 0.0:
        return None
    zero = np.bincount(at, reading - slope * load) / rows
    moved = zero - zero.mean()
    fit = fit_affine(record.channel, load, reading - moved[at])
    return MovedZeros(moved / slope, fit)
