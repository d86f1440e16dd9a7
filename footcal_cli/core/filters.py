"""Filters of evenly sampled signals, along their first axis, shape (n, ...).

Equal to those of `scipy.signal` to rounding, without the third of a second that its import takes
(it brings `scipy.stats` along). A recursion ``y_t + a₁ y_{t−1} + a₂ y_{t−2} = f_t`` is a system
with three diagonals, which LAPACK solves for all channels.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from footcal_cli.core.parameters import FloatArray


def butterworth(order: int, cutoff_hz: float, rate_hz: float) -> FloatArray:
    """Low-pass of Butterworth as sections ``b₀ b₁ b₂ 1 a₁ a₂``, each of gain one at rest, (k, 6).

    Poles of the analogue filter at the warped cut-off, by the bilinear transform.
    """
    warped = math.tan(math.pi * cutoff_hz / rate_hz)
    sections = []
    for k in range((order + 1) // 2):
        pole = warped * np.exp(0.5j * np.pi * (2 * k + order + 1) / order)
        root = (1.0 + pole) / (1.0 - pole)
        if 2 * k + 1 == order:  # the real one of an odd order
            first, second, zeros = -float(root.real), 0.0, (1.0, 1.0, 0.0)
        else:
            first, second, zeros = -2.0 * float(root.real), float(abs(root)) ** 2, (1.0, 2.0, 1.0)
        gain = (1.0 + first + second) / sum(zeros)
        sections.append([*(gain * z for z in zeros), 1.0, first, second])
    return np.array(sections)


def response(sections: FloatArray, at_hz: FloatArray, rate_hz: float) -> FloatArray:
    """Size of what a filter makes of a wave of size one, at frequencies (f,), shape (f,)."""
    back = np.exp(-2j * np.pi * at_hz / rate_hz)
    powers = np.stack([np.ones_like(back), back, back**2])
    return np.asarray(
        np.abs(np.prod(sections[:, :3] @ powers / (sections[:, 3:] @ powers), axis=0))
    )


def recursion(
    values: FloatArray, forward: tuple[float, ...], back: tuple[float, ...], before: FloatArray
) -> FloatArray:
    """``y_t = Σ_i b_i x_{t−i} − Σ_j a_j y_{t−j}``.

    Parameters
    ----------
    forward, back
        The b_i from i = 0 and the a_j from j = 1.
    before
        What the past adds to the first outputs, shape (≤ n, ...).
    """
    from scipy.linalg.lapack import dtbtrs

    flat = np.asfortranarray(values.reshape(len(values), -1), dtype=float)
    driven = forward[0] * flat
    for lag, weight in enumerate(forward[1:], start=1):
        driven[lag:] += weight * flat[: max(len(flat) - lag, 0)]
    past = before[: len(flat)].reshape(min(len(before), len(flat)), -1)
    driven[: len(past)] += past
    diagonals = np.empty((1 + len(back), len(flat)))
    diagonals[:] = np.array([1.0, *back])[:, None]
    found, _ = dtbtrs(diagonals, driven, uplo="L", overwrite_b=True)
    return np.asarray(found).reshape(values.shape)


def filtered(sections: FloatArray, values: FloatArray) -> FloatArray:
    """A signal through a filter, as if it had rested at its first value before."""
    for b0, b1, b2, _, a1, a2 in sections.tolist():
        after = b2 - a2
        rest = np.stack([(b1 - a1 + after) * values[0], after * values[0]])
        values = recursion(values, (b0, b1, b2), (a1, a2), rest)
    return values


def filtered_both_ways(
    sections: FloatArray, values: FloatArray, padding: int | None = None
) -> FloatArray:
    """A signal through a filter forward and backward, so that nothing is delayed.

    Parameters
    ----------
    padding
        Samples by which both ends are continued, turned about the end; fewer than there are. None:
        three times the coefficients.

    Raises
    ------
    ValueError
        The signal is no longer than that.
    """
    if padding is None:
        last = min(int(np.sum(sections[:, 2] == 0.0)), int(np.sum(sections[:, 5] == 0.0)))
        padding = 3 * (2 * len(sections) + 1 - last)
    if len(values) <= padding:
        raise ValueError(f"{len(values)} samples cannot be continued by {padding}")
    if padding:
        head = 2.0 * values[:1] - values[padding:0:-1]
        tail = 2.0 * values[-1:] - values[-2 : -(padding + 2) : -1]
        values = np.concatenate([head, values, tail])
    there = filtered(sections, values)
    back = filtered(sections, there[::-1])[::-1]
    return np.asarray(back[padding : len(back) - padding])


def polynomial_derivative(
    values: FloatArray, window: int, degree: int, order: int, period: float
) -> FloatArray:
    """Derivative of local polynomials (Savitzky and Golay), fitted to the ends of the record too.

    Parameters
    ----------
    window
        Samples of a fit, odd, at most n.
    degree, order
        Of the polynomial and of the derivative.
    period
        From sample to sample.
    """
    half = window // 2
    place = np.arange(-half, half + 1) / max(half, 1)
    basis, upper = np.linalg.qr(np.vander(place, degree + 1, increasing=True))
    # row p of `turned`: the coefficient of place**p from the samples of a window
    turned = np.linalg.solve(upper, basis.T)
    scale = (max(half, 1) * period) ** -order
    falling = np.array([math.perm(p, order) for p in range(degree + 1)], dtype=float)

    def at(where: FloatArray) -> FloatArray:
        powers = np.maximum(np.arange(degree + 1) - order, 0)
        return np.asarray(scale * (falling * where[:, None] ** powers) @ turned)

    flat = np.asarray(values, dtype=float).reshape(len(values), -1)
    found = np.empty_like(flat)
    middle = at(np.zeros(1))[0]
    for column, out in zip(flat.T, found.T, strict=True):
        out[half : len(flat) - half] = np.correlate(column, middle, "valid")
    found[:half] = at(place[:half]) @ flat[:window]
    found[len(flat) - half :] = at(place[half + 1 :]) @ flat[-window:]
    return found.reshape(values.shape)


def median_spectrum(
    values: FloatArray, rate_hz: float, length: int
) -> tuple[FloatArray, FloatArray]:
    """Frequencies (f,) and density of a signal (n, k) by Welch, the median of its segments, (f, k).

    Segments of `length` overlap by half, less their means, under von Hann's window; a median of
    squares is brought to the mean of an exponential law.
    """
    from scipy.fft import rfft

    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)
    segments = sliding_window_view(values, length, axis=0)[:: length - length // 2]
    seen = rfft((segments - segments.mean(axis=-1, keepdims=True)) * hann)
    power = (seen.real**2 + seen.imag**2) / (rate_hz * np.sum(hann**2))
    power[..., 1 : (length + 1) // 2] *= 2.0
    even = 2.0 * np.arange(1, (len(power) - 1) // 2 + 1)
    bias = 1.0 + float(np.sum(1.0 / (even + 1.0) - 1.0 / even))
    frequency = np.asarray(np.arange(length // 2 + 1) * (rate_hz / length), dtype=np.float64)
    return frequency, np.asarray(np.median(power, axis=0).T / bias)
