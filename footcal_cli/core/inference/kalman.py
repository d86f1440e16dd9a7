"""The one Kalman step: predict, then correct by standardised innovations.

With ``S = H P Hᵀ + R = L Lᵀ``, ``W = L⁻¹ H P`` and the standardised innovation ``z = L⁻¹ ν``,

    x̂ ← x̂ + Wᵀ z,   P ← P − Wᵀ W,   NIS = zᵀ z,   ln det S = 2 Σ ln Lᵢᵢ

(Kailath, Sayed and Hassibi, Linear Estimation, 2000, chapter 9): no inverse, and P stays symmetric.
Any leading axes are a batch of filters. `footcal_cli.core.online.kalman_loops` holds the same step
in loops, for the compiler.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray

LOG_2PI = float(np.log(2.0 * np.pi))


def predict(
    mean: FloatArray, cov: FloatArray, decay: FloatArray, drive: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """``x̂ ← Φ x̂``, ``P ← Φ P Φ + Q`` with diagonal Φ and Q.

    Parameters
    ----------
    mean, cov
        Shape (…, s) and (…, s, s).
    decay, drive
        Diagonals of Φ and Q, shape (…, s).
    """
    ahead = cov * (decay[..., :, None] * decay[..., None, :])
    at = np.arange(mean.shape[-1])
    ahead[..., at, at] += drive
    return mean * decay, ahead


@dataclass(frozen=True)
class Innovation:
    """What an update did not expect, and what it is worth.

    Parameters
    ----------
    root
        L⁻¹, shape (…, k, k).
    standard
        z, shape (…, k): independent with variance 1 where the model holds.
    weight
        W, shape (…, k, s).
    variance
        Diagonal of S before gross errors were weighed down, shape (…, k).
    nis, log_det
        Shape (…).
    """

    root: FloatArray
    standard: FloatArray
    weight: FloatArray
    variance: FloatArray
    nis: FloatArray
    log_det: FloatArray

    @property
    def log_likelihood(self) -> FloatArray:
        """Of the innovations, shape (…)."""
        rows = self.standard.shape[-1]
        return np.asarray(-0.5 * (self.nis + self.log_det + rows * LOG_2PI))


def innovate(
    cov: FloatArray, h: FloatArray, nu: FloatArray, noise: FloatArray, huber: float = np.inf
) -> Innovation:
    """Compare rows with what was predicted.

    Parameters
    ----------
    cov
        Predicted P, shape (…, s, s).
    h
        Shape (…, k, s).
    nu
        ν = measured − predicted, shape (…, k).
    noise
        R, shape (…, k, k).
    huber
        A row further off than so many sd gets the noise that would explain it.
    """
    hp = h @ cov
    total = hp @ np.swapaxes(h, -1, -2) + noise
    at = np.arange(h.shape[-2])
    variance = total[..., at, at].copy()
    total[..., at, at] = np.maximum(variance, nu**2 / huber**2)
    chol = np.asarray(np.linalg.cholesky(total), dtype=np.float64)
    root = np.asarray(np.linalg.inv(chol), dtype=np.float64)
    standard = np.asarray((root @ nu[..., None])[..., 0])
    diagonal = chol[..., at, at]
    return Innovation(
        root, standard, np.asarray(root @ hp), variance,
        np.asarray(np.sum(standard**2, axis=-1)),
        np.asarray(2.0 * np.sum(np.log(diagonal), axis=-1), dtype=np.float64),
    )  # fmt: skip


def correct(mean: FloatArray, cov: FloatArray, found: Innovation) -> tuple[FloatArray, FloatArray]:
    """``x̂ + Wᵀ z`` and ``P − Wᵀ W``."""
    turned = np.swapaxes(found.weight, -1, -2)
    return (mean + (turned @ found.standard[..., None])[..., 0], cov - turned @ found.weight)


def correct_by_products(
    cov: FloatArray, products: FloatArray, whole: FloatArray | None = None
) -> FloatArray:
    """The same correction by many rows of unit noise at once, from their products ``Hᵀ H`` alone.

    ``(P⁻¹ + HᵀH)⁻¹ = (1 + P HᵀH)⁻¹ P``: no P is inverted.

    Parameters
    ----------
    whole
        Filled with ``1 + P HᵀH``, if given: its determinant is that of ``1 + H P Hᵀ``.

    Returns
    -------
    P after them, shape (…, s, s)
    """
    whole = np.matmul(cov, products, out=whole)
    at = np.arange(products.shape[-1])
    whole[..., at, at] += 1.0
    after = np.linalg.solve(whole, cov)
    return np.asarray(0.5 * (after + np.swapaxes(after, -1, -2)), dtype=np.float64)


def standardised(left: FloatArray, rows: FloatArray, cov: FloatArray) -> FloatArray:
    """Innovations of unit noise made independent with variance 1, ``(1 + H P Hᵀ)^−½ ν``.

    With ``H = Q R`` and ``1 + R P Rᵀ = V S Vᵀ``: ``ν + Q V (S^−½ − 1) Vᵀ Qᵀ ν``.

    Parameters
    ----------
    left
        ν of any number of columns, shape (k, n).
    rows, cov
        H, shape (k, s), and P before them, shape (s, s).
    """
    basis, upper = np.linalg.qr(rows)
    values, vectors = np.linalg.eigh(np.eye(len(upper)) + upper @ cov @ upper.T)
    turned = basis @ vectors
    return np.asarray(left + turned @ ((values**-0.5 - 1.0)[:, None] * (turned.T @ left)))


def information(cov: FloatArray, weight: FloatArray) -> float:
    """``½ ln (det P / det (P − Wᵀ W))``: what an update teaches about some states.

    Parameters
    ----------
    cov, weight
        Of these states alone, shape (p, p) and (k, p).
    """
    before = np.linalg.slogdet(cov)[1]
    after = np.linalg.slogdet(cov - weight.T @ weight)[1]
    return 0.5 * float(before - after)


def smooth_back(
    mean: FloatArray,
    cov: FloatArray,
    decay: FloatArray,
    ahead: tuple[FloatArray, FloatArray],
    later: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """One step back of Rauch, Tung and Striebel (AIAA Journal 3, 1965).

    ``x̂ₖ|N = x̂ₖ + Cₖ (x̂ₖ₊₁|N − x̂ₖ₊₁|k)``, ``Cₖ = Pₖ Φᵀ P⁻¹ₖ₊₁|k``.

    Parameters
    ----------
    mean, cov
        Filtered at k.
    decay
        Diagonal of Φ into k + 1.
    ahead
        Mean and covariance of k + 1 predicted from k.
    later
        Smoothed mean and covariance of k + 1.
    """
    onward = np.linalg.solve(ahead[1], np.swapaxes(cov * decay, -1, -2))
    reach = np.swapaxes(onward, -1, -2)
    return (
        mean + (reach @ (later[0] - ahead[0])[..., None])[..., 0],
        cov + reach @ (later[1] - ahead[1]) @ onward,
    )
