"""Linear columns: regressions, projections and whitened innovations, against their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.inference.kalman import standardised
from footcal_cli.core.inference.linear import left_by, orthogonal, regressed, scaled_inverse

RCOND = 1e-9


@pytest.mark.parametrize("kind", ["free", "dependent", "empty"])
def test_a_regression_is_that_of_the_pseudo_inverse(kind: str) -> None:
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(5, 40, 4)) * [1.0, 1e3, 1e-3, 1.0]
    if kind == "dependent":
        columns[..., 3] = columns[..., 0] - 2.0 * columns[..., 2]
    elif kind == "empty":
        columns[2, :, 3] = 0.0
    target = rng.normal(size=(5, 40, 3))
    products = np.swapaxes(columns, 1, 2) @ columns
    cross = np.swapaxes(columns, 1, 2) @ target
    found = columns @ regressed(products, cross, RCOND)
    expected = columns @ scaled_inverse(products, RCOND) @ cross
    np.testing.assert_allclose(found, expected, atol=1e-8)


@pytest.mark.parametrize("dependent", [False, True])
def test_an_orthogonal_basis_leaves_what_the_best_fit_leaves(dependent: bool) -> None:
    rng = np.random.default_rng(1)
    columns, target = rng.normal(size=(30, 5)) * [1.0, 1e4, 1.0, 1e-4, 1.0], rng.normal(size=30)
    if dependent:
        columns[:, 4] = columns[:, 0] + 1e-4 * columns[:, 1]
    basis = orthogonal(columns, 1e-8)
    assert basis.shape == (30, 4 if dependent else 5)
    np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-14)
    left = target - basis @ (basis.T @ target)
    np.testing.assert_allclose(left, left_by(columns, target, 1e-8), atol=1e-10)
    assert orthogonal(np.zeros((30, 2)), 1e-8).shape == (30, 0)


@pytest.mark.parametrize("rows", [2, 20])
def test_standardised_innovations_have_the_products_of_the_filter(rows: int) -> None:
    """``X' (1 + H P H')⁻¹ X``, with more rows than states and with fewer."""
    rng = np.random.default_rng(2)
    h, left = rng.normal(size=(rows, 3)), rng.normal(size=(rows, 6))
    root = rng.normal(size=(3, 3))
    white = standardised(left, h, root @ root.T)
    expected = left.T @ np.linalg.solve(np.eye(rows) + h @ root @ root.T @ h.T, left)
    np.testing.assert_allclose(white.T @ white, expected, rtol=1e-9, atol=1e-12)
