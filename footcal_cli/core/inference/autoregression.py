"""Autocorrelated sensor noise: an autoregressive model, and how many samples it leaves.

Neighbouring samples of a slow drift say the same thing twice. A fit that counts them as
independent claims intervals that are too short: with 2 s of memory they cover 62 % instead of 95 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from footcal_cli.core.parameters import FloatArray

MAX_LAGS = 30
"""Longest autoregression tried; enough for slow noise on top of white noise."""
_SAMPLES_PER_LAG = 10
_ROUNDS = 3
_PATIENCE = 8


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of one channel, ``n_t = Σ_j a_j n_{t−j} + e_t``.

    Parameters
    ----------
    ar
        The ``a_j``, shape (p,); empty for white noise.
    innovation_sd
        Standard deviation of e, in the channel's unit.
    sd
        Standard deviation of n, in the channel's unit.
    """

    ar: FloatArray
    innovation_sd: float
    sd: float

    @property
    def samples_per_effective(self) -> float:
        """Samples that weigh as much as one independent sample in the mean of a long record."""
        if self.sd == 0.0:
            return 1.0
        return float((self.innovation_sd / (self.sd * (1.0 - self.ar.sum()))) ** 2)

    def whitened(self, columns: FloatArray) -> FloatArray:
        """Columns (n, c) as the innovations see them, in units of their sd, shape (n − p, c)."""
        order = self.ar.size
        if order == 0:
            return columns / self.innovation_sd
        rows = columns.shape[0]
        filtered = columns[order:].copy()
        for lag, weight in enumerate(self.ar, start=1):
            filtered -= weight * columns[order - lag : rows - lag]
        return np.asarray(filtered / self.innovation_sd)


def fit_noise(
    residuals: Sequence[FloatArray], regressors: Sequence[FloatArray], max_lags: int = MAX_LAGS
) -> tuple[ChannelNoise, ...]:
    """Noise per channel from what is left of several records after a linear fit of each.

    Yule-Walker with the order of the lowest information criterion of Akaike (efficient where no
    finite order is true: Shibata, Ann. Stat. 8, 1980): slow noise under much white noise, which a
    stricter one leaves out, is what the mean of a long record suffers from. The fit took away
    noise along its regressors, most of all slow noise; what it took is put back:
    ``E Σ_i e_i e_{i+k} ≈ (n − k) γ_k − Σ_a S_a c_a(k)`` with S_a the noise spectrum seen by the
    orthonormal regressor a and c_a its autocorrelation.

    Parameters
    ----------
    residuals
        Per record, shape (n, c).
    regressors
        Per record, what was fitted to it, shape (n, d).
    """
    shortest = min(residual.shape[0] for residual in residuals)
    lags = int(min(max_lags, shortest // _SAMPLES_PER_LAG))
    total = sum(residual.shape[0] for residual in residuals)
    count = np.array([sum(r.shape[0] - k for r in residuals) for k in range(lags + 1)])
    products = _lag_products(residuals, lags)
    taken = sum(z.shape[1] for z in regressors)
    white = products / count[:, None] * (total / max(total - taken, 1))
    first = [_levinson(gamma, total) for gamma in white.T]
    coloured = any(ar.size for ar, _ in first)
    shares = [_RegressorShare.of(z, lags) for z in regressors] if coloured else []
    channels = []
    for raw, gamma, (ar, variance) in zip(products.T, white.T, first, strict=True):
        for _ in range(_ROUNDS if ar.size else 0):
            gamma = (raw + sum(share.taken(ar, variance) for share in shares)) / count
            ar, variance = _levinson(gamma, total)
        channels.append(ChannelNoise(ar, float(np.sqrt(variance)), float(np.sqrt(gamma[0]))))
    return tuple(channels)


def _lag_products(records: Sequence[FloatArray], lags: int) -> FloatArray:
    """``Σ_i e_i e_{i+k}`` over records (n, c) for k = 0 … lags, shape (lags + 1, c)."""
    if lags == 0:
        return np.asarray(sum(np.sum(r**2, axis=0, keepdims=True) for r in records))
    length = next_fast_len(max(r.shape[0] for r in records) + lags, real=True)
    power = np.zeros((records[0].shape[1], length // 2 + 1))
    for record in records:
        # Single precision is plenty for the statistics of noise, and twice as fast.
        seen = rfft(np.ascontiguousarray(record.T, dtype=np.float32), length)
        power += seen.real**2 + seen.imag**2
    return np.asarray(irfft(power, length)[:, : lags + 1].T)


def _levinson(gamma: FloatArray, samples: int) -> tuple[FloatArray, float]:
    """Autoregression and innovation variance from autocovariances, order by AIC."""
    ar = np.empty(0)
    variance = float(gamma[0])
    best = (samples * np.log(variance) if variance > 0.0 else -np.inf, ar, variance)
    for order in range(1, gamma.size):
        if variance <= 0.0 or order > best[1].size + _PATIENCE:
            break
        reflection = (gamma[order] - ar @ gamma[order - 1 : 0 : -1]) / variance
        if abs(reflection) >= 1.0:
            break
        ar = np.concatenate([ar - reflection * ar[::-1], [reflection]])
        variance *= 1.0 - reflection**2
        score = samples * np.log(variance) + 2.0 * order
        if score < best[0]:
            best = (score, ar, variance)
    return best[1], best[2]


@dataclass(frozen=True)
class _RegressorShare:
    """What a fit takes out of one record.

    Parameters
    ----------
    rows
        Length n of the record.
    spectrum
        Power of each orthonormal regressor over the frequencies 0 … Nyquist, shape (n/2 + 1, d).
    products
        Their autocorrelations c_a(k), shape (lags + 1, d).
    """

    rows: int
    spectrum: FloatArray
    products: FloatArray

    @classmethod
    def of(cls, regressors: FloatArray, lags: int) -> _RegressorShare:
        basis, rows = np.linalg.qr(regressors)[0], regressors.shape[0]
        spectrum = np.abs(np.fft.rfft(basis, axis=0)) ** 2
        spectrum[1 : (rows + 1) // 2] *= 2.0
        return cls(rows, spectrum, _lag_products([basis], lags))

    def taken(self, ar: FloatArray, variance: float) -> FloatArray:
        """``Σ_a S_a c_a(k)``, shape (lags + 1,)."""
        response = np.fft.rfft(np.concatenate([[1.0], -ar]), self.rows)
        seen = (variance / np.abs(response) ** 2) @ self.spectrum / self.rows
        return np.asarray(self.products @ seen)
