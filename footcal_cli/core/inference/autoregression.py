"""Autocorrelated sensor noise: an autoregressive model, and how many samples it leaves.

Neighbouring samples of a slow drift say the same thing twice. A fit that counts them as
independent claims intervals that are too short: with 2 s of memory they cover 62 % instead of 95 %.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import mul

import numpy as np
from scipy import optimize
from scipy.linalg.lapack import dtbtrs

from footcal_cli.core import chances
from footcal_cli.core.inference.regressor_share import RegressorShare, lag_products, power_of
from footcal_cli.core.parameters import FloatArray

MAX_LAGS = 30
"""Longest autoregression tried; what lasts longer has a slow part of its own."""
_SAMPLES_PER_LAG = 10
_ROUNDS = 3
_RUNS_AWAY = 5.0
"""Sd with what the fit took over the sd before, beyond which each round puts back more."""
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
_PIECE = 2048
"""Samples that are filtered at once."""


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
        pieces = [piece.copy() for piece in self._filtered(np.ascontiguousarray(columns.T))]
        return _without_slow(np.hstack(pieces), *self.slow).T

    def products(self, rows: FloatArray) -> FloatArray:
        """Inner products of rows (c, n) once they are whitened, shape (c, c)."""
        if self.slow[0]:
            white = self.whitened(rows.T)
            return np.asarray(white.T @ white)
        return np.asarray(sum(piece @ piece.T for piece in self._filtered(rows)))

    def _filtered(self, rows: FloatArray) -> Iterator[FloatArray]:
        """``(x_t − Σ_j a_j x_{t−j}) / σ`` of rows (c, n), pieces that stay in the cache."""
        order, size = self.ar.size, rows.shape[1]
        room = np.empty((2, len(rows) * _PIECE))
        for start in range(order, size, _PIECE):
            end = min(start + _PIECE, size)
            piece, part = room[:, : len(rows) * (end - start)].reshape(2, len(rows), -1)
            np.divide(rows[:, start:end], self.innovation_sd, out=piece)
            for lag, weight in enumerate(self.ar, start=1):
                earlier = rows[:, start - lag : end - lag]
                np.multiply(earlier, weight / self.innovation_sd, out=part)
                np.subtract(piece, part, out=piece)
            yield piece

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


def _without_slow(rows: FloatArray, variance: float, memory: float) -> FloatArray:
    """Innovations of rows (c, n) whose noise is white of sd one, and a slow part.

    A scalar Kalman filter: nothing is known of where the slow part starts. Its gains g_t follow
    from the variances alone, so that the levels expected, ``m_t = φ (1 − g) m_{t−1} + φ g x`` with
    the g and x before, solve a system with two diagonals.
    """
    if not variance:
        return rows
    size = rows.shape[1]
    spreads = _spreads(variance, memory, size)
    gain = spreads / (spreads + 1.0)
    diagonals = np.stack([np.ones(size), -memory * (1.0 - gain)])
    driven = np.zeros((size, len(rows)), order="F")
    driven[1:] = (memory * gain[:-1] * rows[:, :-1]).T
    level, _ = dtbtrs(diagonals, driven, uplo="L")
    return np.asarray((rows - level.T) / np.sqrt(spreads + 1.0))


def _spreads(variance: float, memory: float, size: int) -> FloatArray:
    """Variances of a level before each row, ``s' = φ² s / (s + 1) + v (1 − φ²)``, from v on, (n,).

    With the fixed points ``s₊ ≥ 0 > s₋`` of that map, ``(s − s₊) / (s − s₋)`` shrinks by the same
    factor in each row.
    """
    added = variance * (1.0 - memory**2)
    half = 0.5 * (memory**2 + added - 1.0)
    root = np.sqrt(half**2 + added)
    # of two numbers that nearly cancel the product, −added, is exact
    far = half + root if half > 0.0 else half - root
    above, below = (far, -added / far) if half > 0.0 else (-added / far, far)
    factor = (memory**2 + added - above) / (memory**2 + added - below)
    share = (variance - above) / (variance - below) * factor ** np.arange(size)
    return np.asarray((above - below * share) / (1.0 - share))


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
    products = lag_products([r.T for r in residuals], lags).T
    taken = sum(z.shape[1] for z in regressors)
    white = products / count[:, None] * (total / max(total - taken, 1))
    first = [_levinson(gamma, total) for gamma in white.T]
    coloured = any(ar.size for ar, _ in first)
    shares = [RegressorShare.of(z, lags) for z in regressors] if coloured else []
    channels = []
    for raw, gamma, (ar, variance) in zip(products.T, white.T, first, strict=True):
        for _ in range(_ROUNDS if ar.size else 0):
            noise = ChannelNoise(ar, float(np.sqrt(variance)), 0.0)
            more = (raw + _put_back(shares, noise)) / count
            if more[0] > _RUNS_AWAY**2 * raw[0] / count[0]:
                break
            gamma = more
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
    shares: Sequence[RegressorShare],
) -> tuple[ChannelNoise, ...]:
    """Noise with a slow part where that describes low frequencies surely better than the lags do.

    An autoregression reaches no further than its lags: of noise that lasts for 500 samples under
    white noise, thirty show the mean of a record less than half of its sd.
    """
    low = [np.arange(1, len(r) // (2 * MAX_LAGS)) for r in residuals]
    angle = np.concatenate([2.0 * np.pi * k / len(r) for k, r in zip(low, residuals, strict=True)])
    # share of each frequency that the fit took
    taken = np.concatenate([share.spectrum[:, k].sum(axis=0) / 2.0 / share.rows
                            for k, share in zip(low, shares, strict=True)])  # fmt: skip
    shown = taken < _SEEN
    if shown.sum() < _FEWEST:
        return tuple(channels)
    power = np.concatenate(
        [power_of(r.T)[:, k].T / len(r) for k, r in zip(low, residuals, strict=True)]
    )
    power, angle = power[shown] / (1.0 - taken[shown])[:, None], angle[shown]
    longest, lag = max(len(r) for r in residuals), np.arange(len(count))
    found = []
    for channel, own, raw in zip(channels, power.T, products.T, strict=True):
        level, variance, memory = _slow_part(own, angle, channel.spectrum(angle), longest)
        if not variance:
            found.append(channel)
            continue
        fast = ChannelNoise(np.empty(0), float(np.sqrt(level)), 0.0)
        for _ in range(_ROUNDS):
            gamma = (raw + _put_back(shares, fast, (variance, memory))) / count
            ar, left = _levinson(gamma - variance * memory**lag, int(count[0]))
            fast = ChannelNoise(ar, float(np.sqrt(max(left, 0.0))), float(np.sqrt(gamma[0])))
        # lags that last as long as the slow part are not kept apart from it
        if not fast.innovation_sd > 0.0 or fast.sd > _RUNS_AWAY * channel.sd:
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

    def parts(log_ratio: float) -> tuple[float, FloatArray]:
        shape = 1.0 + np.exp(log_ratio) * form
        return float((power / shape).sum()) / power.size, shape

    def cost(log_ratio: float) -> float:
        level, shape = parts(log_ratio)
        return power.size * float(np.log(level)) + float(np.log(shape).sum())

    ends = -np.log(form.max() * power.size), np.log(power.size / form.min())
    ratio = float(optimize.minimize_scalar(cost, bounds=ends, method="bounded").x)
    level, _ = parts(ratio)
    return level, level * math.exp(ratio)


def _levinson(gamma: FloatArray, samples: int) -> tuple[FloatArray, float]:
    """Autoregression and innovation variance from autocovariances, order by AIC."""
    ar: list[float] = []
    # plain numbers: the arrays of thirty numbers would cost more than what is done with them
    left = [float(g) for g in gamma]
    variance = left[0]
    best = (samples * np.log(variance) if variance > 0.0 else -np.inf, ar, variance)
    for order in range(1, len(left)):
        if variance <= 0.0 or order > len(best[1]) + _PATIENCE:
            break
        reflection = (left[order] - sum(map(mul, ar, left[order - 1 : 0 : -1]))) / variance
        if abs(reflection) >= 1.0:
            break
        ar = [*(a - reflection * b for a, b in zip(ar, ar[::-1], strict=True)), reflection]
        variance *= 1.0 - reflection**2
        score = samples * np.log(variance) + 2.0 * order
        if score < best[0]:
            best = (score, ar, variance)
    return np.array(best[1]), best[2]


def _put_back(
    shares: Sequence[RegressorShare], noise: ChannelNoise, slow: tuple[float, float] | None = None
) -> FloatArray:
    """What fits took of all records, shape (lags + 1,); `slow`: variance and φ of a slow part."""
    each: dict[int, FloatArray] = {}  # equally long records see noise alike
    for share in shares:
        if share.rows not in each:
            spectrum = share.lagged(noise.ar, noise.innovation_sd)
            each[share.rows] = (
                spectrum + slow[0] * _form(share.angle, slow[1]) if slow else spectrum
            )
    return np.asarray(sum(share.taken(each[share.rows]) for share in shares))
