"""From the noise of the channels to white residuals of a balance.

A balance mixes channels, and one channel may enter several of its outputs (a swinging cell is in
the total and stands for itself), so its errors are correlated. Here each row is whitened with its
full covariance ``Σ = A diag(σ²) Aᵀ``, A = d error / d readings.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

_RANK_TOLERANCE = 1e-9


def whitening(experiment: Experiment, log: Log, channel_sd: FloatArray) -> FloatArray:
    """Matrices W (n, k, k) with ``W Σ Wᵀ = 1`` on the valid errors of each row, 0 elsewhere.

    Parameters
    ----------
    log
        Without distortions; the balance must be linear in its readings.
    channel_sd
        White noise of each channel, shape (c,), in its unit (N, Nm).
    """
    found = experiment.balance(log)
    derivative = np.empty((*found.error.shape, len(log.channels)))
    for i in range(len(log.channels)):
        moved = log.readings.copy()
        moved[:, i] += 1.0
        derivative[:, :, i] = experiment.balance(log.with_readings(moved)).error - found.error
    spread = derivative * channel_sd * found.valid[..., None]
    size = np.sqrt(np.sum(spread**2, axis=-1, keepdims=True))
    unit = spread / np.where(size > 0.0, size, 1.0)
    variance, axes = np.linalg.eigh(unit @ unit.transpose(0, 2, 1))
    seen = variance > _RANK_TOLERANCE
    shrink = np.where(seen, 1.0 / np.sqrt(np.where(seen, variance, 1.0)), 0.0)
    inverse_size = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
    white: FloatArray = shrink[..., None] * axes.transpose(0, 2, 1) * inverse_size[:, None, :, 0]
    return white


def white_errors(balance: Balance, whitener: FloatArray) -> FloatArray:
    """Errors of a balance in units of their noise, flattened, shape (n k,); invalid ones are 0."""
    error = np.where(balance.valid, balance.error, 0.0)
    white: FloatArray = np.einsum("nij,nj->ni", whitener, error).ravel()
    return white
