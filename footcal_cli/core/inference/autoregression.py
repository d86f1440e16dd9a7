"""Autocorrelated sensor noise: an autoregressive model, and how many samples it leaves.

Neighbouring samples of a slow drift say the same thing twice. A fit that counts them as
independent claims intervals that are too short: with 2 s of memory they cover 62 % instead of 95 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize
from scipy.fft import irfft, next_fast_len, rfft
from scipy.linalg import qr

from footcal_cli.core import chances
from footcal_cli.core.parameters import FloatArray

MAX_LAGS = 30
"""Longest autoregression tried; what lasts longer has a slow part of its own."""
_SAMPLES_PER_LAG = 10
_ROUNDS = 3
_PATIENCE = 8
_MEMORIES = 12
"""Memories of the slow part that are tried, from a few of the longest lags to the record."""
_SEEN = 0.5
"""Share of a frequency's power that the regressors may take; of others they tell too little."""
_FEWEST = 12
"""Frequencies that must be left to judge by."""
_SURE = float(chances.chi2_isf(0.001, 3))
_UNEVEN = 1.22
"""Of Bartlett's cumulative periodogram: its largest distance from even, times √n, at 10 %."""
_LEAST = 1e-6
"""Of the mean power, so that logs without noise have a logarithm."""
_STEADY = 1e-9


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of one channel, ``n_t = Σ_j a_j n_{t−j} + e_t + s_t``, ``s_t = φ s_{t−1} + d_t``.

    Parameters
    ----------
    ar
        The ``a_j``, shape (p,); empty for white noise.
    innovation_sd
        Standard deviation of e, in the channel's unit.
    sd
        Standard deviation of n, in the channel's unit.
    slow
        Variance of s over that of e, and φ: what wanders for longer than the lags reach.
    """

    ar: FloatArray
    innovation_sd: float
    sd: float
    slow: tuple[float, float] = (0.0, 0.0)

    @property
    def samples_per_effective(self) -> float:
        """Samples that weigh as much as one independent sample in the mean of a long record."""
        if self.sd == 0.0:
            return 1.0
        variance, memory = self.slow
        whole = 1.0 + variance * (1.0 + memory) / (1.0 - memory)
        return float(whole * (self.innovation_sd / (self.sd * (1.0 - self.ar.sum()))) ** 2)

    def whitened(self, columns: FloatArray) -> FloatArray:
        """Columns (n, c) as the innovations see them, in units of their sd, shape (n − p, c)."""
        order = self.ar.size
        if order == 0:
            return _without_slow(columns / self.innovation_sd, *self.slow)
        rows = columns.shape[0]
        filtered = columns[order:].copy()
        for lag, weight in enumerate(self.ar, start=1):
            filtered -= weight * columns[order - lag : rows - lag]
        return _without_slow(np.asarray(filtered / self.innovation_sd), *self.slow)

    def spectrum(self, angle: FloatArray) -> FloatArray:
        """``σ² / |1 − Σ_j a_j e^{−ijω}|²`` without the slow part, at angles (k,) per row."""
        turned, left = np.exp(-1j * angle), np.zeros(angle.shape, dtype=complex)
        for weight in self.ar[::-1]:
            left = (left + weight) * turned
        left = 1.0 - left
        return np.asarray(self.innovation_sd**2 / (left.real**2 + left.imag**2))

    @property
    def is_white(self) -> bool:
        """Whether samples are independent."""
        return self.ar.size == 0 and not self.slow[0]


def _without_slow(columns: FloatArray, variance: float, memory: float) -> FloatArray:
    """Innovations of columns (n, c) whose noise is white of sd one, and a slow part.

    A scalar Kalman filter: nothing is known of where the slow part starts. Once its gain is steady
    it is ``(1 − φB)/(1 − θB)``.
    """
    if not variance:
        return columns
    from scipy.signal import lfilter

    out, at = np.empty_like(columns), np.zeros(columns.shape[1])
    spread, start = variance, len(columns)
    for t, row in enumerate(columns):
        out[t] = (row - at) / np.sqrt(spread + 1.0)
        gain = spread / (spread + 1.0)
        at = memory * (at + gain * (row - at))
        after = memory**2 * gain + variance * (1.0 - memory**2)
        if abs(after - spread) < _STEADY * spread:
            start = t + 1
            break
        spread = after
    rest, kept = columns[start:], memory * (1.0 - gain)
    if len(rest):
        ahead, _ = lfilter([memory * gain], [1.0, -kept], rest, axis=0, zi=kept * at[None])
        out[start:] = (rest - np.vstack([at, ahead[:-1]])) / np.sqrt(spread + 1.0)
    return out


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
    whole = _joined(shares)
    channels = []
    for raw, gamma, (ar, variance) in zip(products.T, white.T, first, strict=True):
        for _ in range(_ROUNDS if ar.size else 0):
            noise = ChannelNoise(ar, float(np.sqrt(variance)), 0.0)
            gamma = raw + sum(share.taken(noise.spectrum(share.angle)) for share in whole)
            gamma = gamma / count
            ar, variance = _levinson(gamma, total)
        channels.append(ChannelNoise(ar, float(np.sqrt(variance)), float(np.sqrt(gamma[0]))))
    if not coloured:
        return tuple(channels)
    return _with_slow_parts(channels, residuals, products, count, shares)


def _with_slow_parts(
    channels: Sequence[ChannelNoise],
    residuals: Sequence[FloatArray],
    products: FloatArray,
    count: FloatArray,
    shares: Sequence[_RegressorShare],
) -> tuple[ChannelNoise, ...]:
    """Noise with a slow part where that describes low frequencies surely better than the lags do.

    An autoregression reaches no further than its lags: of noise that lasts for 500 samples under
    white noise, thirty show the mean of a record less than half of its sd.
    """
    low = [np.arange(1, len(r) // (2 * MAX_LAGS)) for r in residuals]
    angle = np.concatenate([2.0 * np.pi * k / len(r) for k, r in zip(low, residuals, strict=True)])
    # share of each frequency that the fit took
    taken = np.concatenate([share.spectrum[k].sum(axis=1) / 2.0 / share.rows
                            for k, share in zip(low, shares, strict=True)])  # fmt: skip
    shown = taken < _SEEN
    if shown.sum() < _FEWEST:
        return tuple(channels)
    power = np.concatenate(
        [np.abs(rfft(r, axis=0)[k]) ** 2 / len(r) for k, r in zip(low, residuals, strict=True)]
    )
    power, angle = power[shown] / (1.0 - taken[shown])[:, None], angle[shown]
    longest, lag, whole = max(len(r) for r in residuals), np.arange(len(count)), _joined(shares)
    found = []
    for channel, own, raw in zip(channels, power.T, products.T, strict=True):
        level, variance, memory = _slow_part(own, angle, channel.spectrum(angle), longest)
        if not variance:
            found.append(channel)
            continue
        fast = ChannelNoise(np.empty(0), float(np.sqrt(level)), 0.0)
        for _ in range(_ROUNDS):
            put_back = sum(
                share.taken(fast.spectrum(share.angle) + variance * _form(share.angle, memory))
                for share in whole
            )
            gamma = (raw + put_back) / count
            ar, left = _levinson(gamma - variance * memory**lag, int(count[0]))
            fast = ChannelNoise(ar, float(np.sqrt(max(left, 0.0))), float(np.sqrt(gamma[0])))
        if not fast.innovation_sd > 0.0:
            found.append(channel)
            continue
        ratio = variance * ((1.0 - fast.ar.sum()) / fast.innovation_sd) ** 2
        found.append(replace(fast, slow=(float(ratio), memory)))
    return tuple(found)


def _form(angle: FloatArray, memory: float) -> FloatArray:
    """Spectrum of an autoregression of the first order of variance one."""
    return np.asarray((1.0 - memory**2) / (1.0 - 2.0 * memory * np.cos(angle) + memory**2))


def _slow_part(
    power: FloatArray, angle: FloatArray, lagged: FloatArray, longest: int
) -> tuple[float, float, float]:
    """Level of white noise, variance and φ of a slow part; zeros where none is surely nearer.

    Whittle's likelihood of a periodogram P, ``−Σ_k log S_k + P_k / S_k``, with
    ``S = b + v (1 − φ²)/(1 − 2 φ cos ω + φ²)``, against that of the autoregression's S.
    """

    def cost(spectrum: FloatArray) -> float:
        return float(np.sum(np.log(spectrum) + power / spectrum))

    least = float(lagged.mean()) * _LEAST
    if not least > 0.0:
        return 0.0, 0.0, 0.0
    order = np.argsort(angle, kind="stable")
    passed = np.cumsum((power / np.maximum(lagged, least))[order])
    even = np.arange(1, power.size + 1) / power.size
    apart = float(np.abs(passed / max(passed[-1], _LEAST) - even).max()) * np.sqrt(power.size)
    if apart < _UNEVEN:
        return 0.0, 0.0, 0.0
    best = (cost(lagged) - 0.5 * _SURE, 0.0, 0.0, 0.0)
    for rows in np.geomspace(MAX_LAGS, longest, _MEMORIES):
        memory = float(np.exp(-1.0 / rows))
        form = _form(angle, memory)
        level, variance = _likeliest(power, form)
        best = min(best, (cost(level + variance * form), level, variance, memory))
    return best[1:]


def _likeliest(power: FloatArray, form: FloatArray) -> tuple[float, float]:
    """Level b and variance v of the likeliest ``b + v form``: b follows from their ratio."""

    def level(log_ratio: float) -> float:
        return float(np.mean(power / (1.0 + np.exp(log_ratio) * form)))

    def cost(log_ratio: float) -> float:
        shape = 1.0 + np.exp(log_ratio) * form
        return power.size * float(np.log(level(log_ratio))) + float(np.sum(np.log(shape)))

    ends = -np.log(form.max() * power.size), np.log(power.size / form.min())
    ratio = float(optimize.minimize_scalar(cost, bounds=ends, method="bounded").x)
    return level(ratio), level(ratio) * float(np.exp(ratio))


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
    """What a fit takes out of one record, or out of several equally long ones.

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
        basis, rows = qr(regressors, mode="economic", check_finite=False)[0].T, len(regressors)
        seen = rfft(basis)
        spectrum = seen.real**2 + seen.imag**2
        products = irfft(spectrum, rows)[:, : lags + 1].T.copy()
        for lag in range(1, lags + 1):  # the record's ends do not meet
            products[lag] -= np.sum(basis[:, :lag] * basis[:, rows - lag :], axis=1)
        spectrum[:, 1 : (rows + 1) // 2] *= 2.0
        return cls(rows, spectrum.T, products)

    @property
    def angle(self) -> FloatArray:
        """Of the frequencies 0 … Nyquist, rad per row."""
        return np.asarray(2.0 * np.pi * np.fft.rfftfreq(self.rows), dtype=np.float64)

    def taken(self, spectrum: FloatArray) -> FloatArray:
        """``Σ_a S_a c_a(k)`` of noise with a spectrum (n/2 + 1,), shape (lags + 1,)."""
        return np.asarray(self.products @ (spectrum @ self.spectrum / self.rows))


def _joined(shares: Sequence[_RegressorShare]) -> list[_RegressorShare]:
    """The same shares, those of equally long records as one: they see noise alike."""
    groups: dict[int, list[_RegressorShare]] = {}
    for share in shares:
        groups.setdefault(share.rows, []).append(share)
    return [
        _RegressorShare(
            rows, np.hstack([s.spectrum for s in group]), np.hstack([s.products for s in group])
        )
        for rows, group in groups.items()
    ]
