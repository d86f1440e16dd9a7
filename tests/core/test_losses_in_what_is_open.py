"""A block is judged as surely as the others predict it: against the full covariance, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.inference.scores import losses_in_what_is_open
from footcal_cli.core.parameters import FloatArray

BLOCKS, ROWS = 5, 6


def rows_of(seed: int, columns: int) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(BLOCKS, ROWS, columns)), rng.normal(size=(BLOCKS, ROWS))


def products(columns: FloatArray, residual: FloatArray) -> FloatArray:
    every = np.concatenate([columns, residual[..., None]], axis=2)
    return np.asarray(np.einsum("bij,bik->bjk", every, every))


@pytest.mark.parametrize("block", range(BLOCKS))
def test_it_is_the_error_in_the_covariance_of_the_prediction(block: int) -> None:
    columns, residual = rows_of(3, 4)
    without = np.arange(BLOCKS) == block
    others, seen = columns[~without].reshape(-1, 4), residual[~without].ravel()
    theta = np.linalg.solve(others.T @ others, others.T @ seen)
    error = residual[block] - columns[block] @ theta
    open_yet = np.linalg.inv(others.T @ others)
    covariance = np.eye(ROWS) + columns[block] @ open_yet @ columns[block].T
    expected = error @ np.linalg.solve(covariance, error)
    found = losses_in_what_is_open(products(columns, residual), np.arange(4), without)
    assert found == pytest.approx([expected], rel=1e-9)


def test_a_column_that_no_other_block_knows_makes_no_error_of_prediction() -> None:
    columns, residual = rows_of(4, 3)
    columns[1:, :, 2] = 0.0  # the first block's own
    first = np.arange(BLOCKS) == 0
    before = losses_in_what_is_open(products(columns, residual), np.arange(3), first)
    moved = residual.copy()
    moved[0] += 1e4 * columns[0, :, 2]
    after = losses_in_what_is_open(products(columns, moved), np.arange(3), first)
    assert after == pytest.approx(before, rel=1e-5)


def test_what_is_open_is_not_fitted() -> None:
    columns, residual = rows_of(5, 3)
    without = np.arange(BLOCKS) >= 3
    both = losses_in_what_is_open(products(columns, residual), np.arange(2), without)
    alone = losses_in_what_is_open(products(columns[..., :2], residual), np.arange(2), without)
    assert both.shape == (2,)
    assert np.all(both <= alone + 1e-9)
