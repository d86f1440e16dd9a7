"""How long an error of a running recording lasts: across loads, or until the next one is put on.

Room: core, bench; asked by its study. Drift goes on whatever the load is; how a weight stands, and
what the cell remembers of the last one, is another error with each load. Rows under one load are
then one piece of evidence for the scale, however many they are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.inference.blocks import autoregression, correlation_time
from footcal_cli.core.parameters import FloatArray, IntArray

_FEWEST_LOADINGS = 4
"""A line through fewer leaves nothing to see an error of the loads by."""
_RATIOS = np.logspace(-3.0, 10.0, 131)
"""Variances of a load's error over that of a row, among which the likeliest is looked for."""


def with_law_of_noise(record: BenchRecord) -> BenchRecord:
    """The record, `renewed` where that is the likelier law of what a straight line leaves.

    Both laws have a correlation time; an error of each load has a variance besides, which must be
    worth its half logarithm of the number of rows (BIC).

    Parameters
    ----------
    record
        Means of a running recording of one session: sessions have errors of their own.
    """
    known = record.known
    loading = record.loadings()
    if np.unique(record.session[known]).size > 1 or loading[-1] + 1 < _FEWEST_LOADINGS:
        return record
    line = np.column_stack([record.load_n[known], np.ones(loading.size)])
    reading = record.reading[known]
    left = reading - line @ np.linalg.lstsq(line, reading, rcond=None)[0]
    time_s, session = record.time_s[known], record.session[known]
    going_on = _log_likelihood(left, time_s, session, np.zeros(1))
    of_loads = _log_likelihood(left, time_s, loading, _RATIOS)
    return replace(record, renewed=bool(of_loads - going_on > 0.5 * np.log(left.size)))


def _log_likelihood(
    left: FloatArray, time_s: FloatArray, block: IntArray, ratios: FloatArray
) -> float:
    """The largest of ``−½ (n ln Q + Σ ln(1 + λ c'c)) − Σ ln w`` over the variance λ of the blocks.

    ``Q = Σ z'z − λ (c'z)² / (1 + λ c'c)``; z are the rows of a block, whitened from an
    autoregression that starts anew with each, w the share of each row that is its own, and c what
    an offset of the block is in them.
    """
    size = np.bincount(block - block.min())
    mean = np.bincount(block - block.min(), weights=left) / np.maximum(size, 1)
    inside = left - mean[block - block.min()] if ratios.any() else left
    own, z, c = np.ones_like(left), left, np.ones_like(left)
    memory_s = correlation_time(inside, time_s, block)
    if memory_s > 0.0:
        rho, own = autoregression(time_s, block, memory_s)
        z, c = (left - rho * np.roll(left, 1)) / own, (1.0 - rho) / own
    square, cross = (np.bincount(block - block.min(), weights=x) for x in (c * c, c * z))
    grown = 1.0 + ratios[:, None] * square
    energy = float(z @ z) - np.sum(ratios[:, None] * cross**2 / grown, axis=1)
    fits = left.size * np.log(np.maximum(energy, 1e-300)) + np.sum(np.log(grown), axis=1)
    return float(-0.5 * fits.min() - np.sum(np.log(own)))
