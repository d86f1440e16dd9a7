"""What a linear fit takes out of the noise of records: the spectra of its regressors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import as_strided
from scipy.fft import rfft
from scipy.linalg import qr

from footcal_cli.core.parameters import FloatArray

_WIDE = 32
"""Samples in a row of those that are multiplied with each other."""
_INDEPENDENT = 1e-4
"""Share of a regressor that those before it leave, from which their products show it exactly."""


@dataclass(frozen=True)
class RegressorShare:
    """What a fit takes out of one record, or out of several equally long ones.

    Parameters
    ----------
    rows
        Length n of the record.
    spectrum
        Power of each orthonormal regressor over the frequencies 0 … Nyquist, shape (d, n/2 + 1).
    products
        Their autocorrelations c_a(k), shape (d, lags + 1).
    """

    rows: int
    spectrum: FloatArray
    products: FloatArray

    @classmethod
    def of(cls, regressors: FloatArray, lags: int) -> RegressorShare:
        """Of the regressors (n, d) of a record."""
        rows = len(regressors)
        basis = _orthonormal_rows(regressors)
        spectrum = power_of(basis)
        spectrum[:, 1 : (rows + 1) // 2] *= 2.0
        return cls(rows, spectrum, lag_products([basis], lags))

    @cached_property
    def angle(self) -> FloatArray:
        """Of the frequencies 0 … Nyquist, rad per row."""
        return np.asarray(2.0 * np.pi * np.fft.rfftfreq(self.rows), dtype=np.float64)

    def lagged(self, ar: FloatArray, innovation_sd: float) -> FloatArray:
        """``σ² / |1 − Σ_j a_j e^{−ijω}|²`` at those frequencies, shape (n/2 + 1,)."""
        return innovation_sd**2 / power_of(np.concatenate([[1.0], -ar]), self.rows)

    def taken(self, spectrum: FloatArray) -> FloatArray:
        """``Σ_a S_a c_a(k)`` of noise with a spectrum (n/2 + 1,), shape (lags + 1,)."""
        return np.asarray(self.spectrum @ spectrum / self.rows @ self.products)


def power_of(values: FloatArray, length: int | None = None) -> FloatArray:
    """Squared size of the Fourier transform of values (…, n), at 0 … Nyquist.

    Of several rows at once in half the time of one after the other.
    """
    seen = rfft(values, length)
    return np.asarray(seen.real**2 + seen.imag**2)


def _orthonormal_rows(regressors: FloatArray) -> FloatArray:
    """Basis of what regressors (n, d) span, each beside those before it, shape (d, n)."""
    try:
        upper = np.linalg.cholesky(regressors.T @ regressors).T
    except np.linalg.LinAlgError:
        upper = np.zeros((1, 1))
    norm = np.sqrt(np.sum(upper**2, axis=0))
    if not np.all(np.diag(upper) > _INDEPENDENT * norm):
        return np.asarray(qr(regressors, mode="economic", check_finite=False)[0].T)
    return np.asarray(np.linalg.inv(upper).T @ regressors.T)


def lag_products(records: Sequence[FloatArray], lags: int) -> FloatArray:
    """``Σ_i e_i e_{i+k}`` over records (c, n) for k = 0 … lags, shape (c, lags + 1).

    With a record in rows of L samples, L at least the lags, they are sums along the diagonals of
    ``[Xᵀ X, Xᵀ X']``, X' one row later.
    """
    channels, wide = len(records[0]), max(lags, _WIDE)
    both = np.zeros((channels, wide, 2 * wide))
    for record in records:
        whole = record.shape[1] // wide * wide
        last = np.zeros((channels, 2, wide))
        last[:, 1, : record.shape[1] - whole] = record[:, whole:]
        rows = record[:, :whole].reshape(channels, -1, wide)
        if whole:
            last[:, 0] = rows[:, -1]
        turned = np.swapaxes(rows, 1, 2)
        both[:, :, :wide] += turned @ rows + last[:, 1, :, None] * last[:, 1, None]
        both[:, :, wide:] += (
            turned[:, :, :-1] @ rows[:, 1:] + last[:, 0, :, None] * last[:, 1, None]
        )
    along = as_strided(
        both, (channels, wide, lags + 1), (both.strides[0], sum(both.strides[1:]), both.strides[2])
    )
    return np.asarray(along.sum(axis=1))
