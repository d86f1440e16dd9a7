"""Columns of any units, some of them dependent, some empty."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from footcal_cli.core.inference.linear import (
    about_usual,
    least_squares,
    left_by,
    orthonormal,
    scaled_inverse,
    unit_columns,
)
from footcal_cli.core.parameters import FloatArray

UNITS = np.array([1e-6, 1.0, 1e5, 1e-6, 1.0])


def basis_of(seed: int = 0) -> FloatArray:
    """Three directions in five columns of very different units; the last one is empty."""
    rng = np.random.default_rng(seed)
    own = rng.standard_normal((40, 3))
    return np.asarray(np.column_stack([own, own[:, 0] - own[:, 1], np.zeros(40)]) * UNITS)


def test_a_basis_has_the_rank_of_its_columns_whatever_their_units() -> None:
    basis = orthonormal(basis_of(), 1e-8)
    assert basis.shape == (40, 3)
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-12)


def test_what_a_fit_leaves_is_orthogonal_to_all_columns() -> None:
    columns, target = basis_of(), np.random.default_rng(1).standard_normal((40, 2))
    left = left_by(columns, target, 1e-9)
    np.testing.assert_allclose(unit_columns(columns).T @ left, 0.0, atol=1e-10)
    # and the rest lies in their span, so that it is the projection
    inside = orthonormal(columns, 1e-8)
    np.testing.assert_allclose(left, target - inside @ (inside.T @ target), atol=1e-10)
    np.testing.assert_allclose(
        target - columns @ least_squares(columns, target, 1e-9), left, atol=1e-7
    )


def test_nothing_is_left_out_by_columns_that_are_nothing() -> None:
    target = np.arange(4.0)
    np.testing.assert_array_equal(left_by(np.zeros((4, 2)), target, 1e-9), target)


def test_inverses_of_many_blocks_are_the_inverses_of_each() -> None:
    rng = np.random.default_rng(2)
    raw = rng.standard_normal((6, 30, 4)) * UNITS[:4]
    products = raw.swapaxes(1, 2) @ raw
    found = scaled_inverse(products, 1e-9)
    units = np.outer(UNITS[:4], UNITS[:4])
    for one, inverse in zip(products, found, strict=True):
        np.testing.assert_allclose((inverse * units) @ (one / units), np.eye(4), atol=1e-12)
    empty = products.copy()
    empty[:, 2] = empty[:, :, 2] = 0.0
    alone = scaled_inverse(empty, 1e-9)
    assert not alone[:, 2].any()
    kept = np.ix_(range(6), [0, 1, 3], [0, 1, 3])
    np.testing.assert_allclose(alone[kept], scaled_inverse(products[kept], 1e-9), rtol=1e-9)


def test_a_basis_is_found_where_divide_and_conquer_does_not_converge(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def failing(*_: Any, **__: Any) -> None:
        raise np.linalg.LinAlgError("SVD did not converge")

    expected = orthonormal(basis_of(), 1e-8)
    monkeypatch.setattr(np.linalg, "svd", failing)
    basis = orthonormal(basis_of(), 1e-8)
    np.testing.assert_allclose(basis @ basis.T, expected @ expected.T, atol=1e-10)


def test_coefficients_of_a_usual_size_are_the_posterior_mean() -> None:
    """``(DᵀD / σ² + U⁻²)⁻¹ Dᵀt / σ²``, σ² of the residual; what nothing shows keeps its sd."""
    rng = np.random.default_rng(4)
    design = rng.standard_normal((30, 3)) * np.array([1.0, 10.0, 1e-9])
    target, usual = rng.standard_normal((30, 2)), np.array([0.1, 0.2, 0.3])
    found, loose = about_usual(design, target, usual)
    rest = target - design @ np.linalg.lstsq(design, target, rcond=None)[0]
    noise = np.sum(rest**2) / (2 * 27)
    precision = design.T @ design / noise + np.diag(usual**-2.0)
    expected = np.linalg.solve(precision, design.T @ target / noise)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-12)
    covariance = np.linalg.inv(precision)
    np.testing.assert_allclose(
        loose, covariance @ np.diag(usual**-2.0) @ covariance, rtol=1e-6, atol=1e-12
    )
    assert np.sqrt(loose[2, 2]) == pytest.approx(0.3)
