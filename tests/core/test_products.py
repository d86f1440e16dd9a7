"""Products that are made where they are asked for are those of all columns at once."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.inference.products import (
    Dense,
    Lazy,
    Products,
    block_products,
    partial_out,
    rows_of_blocks,
    with_known,
)
from footcal_cli.core.parameters import FloatArray, IntArray

BLOCKS, COLUMNS = 5, 12
Z, KNOWN = np.array([2, 3, 7]), np.array([0, 4])
VARIANCE = np.array([0.5, 2.0, 0.0])
PRECISION = np.array([[3.0, 1.0], [1.0, 2.0]])


def logged() -> tuple[FloatArray, IntArray]:
    """Columns and the block of each row, in no order."""
    rng = np.random.default_rng(5)
    return rng.standard_normal((90, COLUMNS)), rng.integers(0, BLOCKS, 90)


def both() -> tuple[Products, Products]:
    """What differs from block to block taken out, some columns known: at once, and as asked for."""
    columns, block = logged()
    at_once = block_products(columns, block, BLOCKS)
    as_asked: Products = Lazy(rows_of_blocks(columns, block, BLOCKS))
    assert isinstance(at_once, Dense)
    left, right = (
        with_known(partial_out(p, Z, VARIANCE), PRECISION, KNOWN) for p in (at_once, as_asked)
    )
    return left, right


def expected() -> FloatArray:
    """``X' (1 + Z D Z')⁻¹ X + K`` of each block, by an inverse of the size of its rows."""
    columns, block = logged()
    out = np.zeros((BLOCKS, COLUMNS, COLUMNS))
    for b in range(BLOCKS):
        x = columns[block == b]
        z = x[:, Z] * np.sqrt(VARIANCE)
        out[b] = x.T @ np.linalg.inv(np.eye(len(x)) + z @ z.T) @ x
        out[b][np.ix_(KNOWN, KNOWN)] += PRECISION
    return out


@pytest.mark.parametrize("which", [0, 1])
def test_products_are_those_of_the_rows_in_their_noise(which: int) -> None:
    products, true = both()[which], expected()
    some, others = np.array([4, 1, 11]), np.array([0, 11, 2, 4])
    assert (products.blocks, products.size, products.last) == (BLOCKS, COLUMNS, COLUMNS - 1)
    np.testing.assert_allclose(products.part(some, others), true[:, some[:, None], others])
    np.testing.assert_allclose(products.part(others, some), true[:, others[:, None], some])
    np.testing.assert_allclose(products.squares(others), true[:, others, others])
    np.testing.assert_allclose(products.among(others), true[:, others[:, None], others])
    np.testing.assert_allclose(
        products.summed(others), true[:, others[:, None], others].sum(axis=0)
    )
    np.testing.assert_allclose(products.with_residual(some), true[:, some, -1])
    weights = np.random.default_rng(6).standard_normal((BLOCKS, 3, 4))
    own = weights @ true[:, others[:, None], others] @ weights.swapaxes(1, 2)
    np.testing.assert_allclose(
        products.squared(others, weights), np.einsum("bll->bl", own), rtol=1e-9
    )


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("asked_before", [False, True])
def test_some_blocks_have_the_products_of_these(which: int, asked_before: bool) -> None:
    products, true = both()[which], expected()
    some, kept = np.array([4, 1]), np.array([True, False, True, True, False])
    if asked_before:
        products.part(some, some)
        products.squares(some)
    fewer = products.of_blocks(kept)
    np.testing.assert_allclose(fewer.part(some, some), true[kept][:, some[:, None], some])
    np.testing.assert_allclose(fewer.squares(some), true[kept][:, some, some])
    for mine in (kept, ~kept, np.full(BLOCKS, fill_value=True)):
        of = products.of_blocks(mine)
        summed = true[mine][:, some[:, None], some].sum(axis=0)
        np.testing.assert_allclose(of.summed(some), summed)
        of.summed(some)[:] = 0.0  # what is given away is not kept
        np.testing.assert_allclose(of.summed(some), summed)
    np.testing.assert_allclose(fewer.summed(some), true[kept][:, some[:, None], some].sum(axis=0))


@pytest.mark.parametrize("which", [0, 1])
def test_a_residual_may_have_columns_taken_from_it(which: int) -> None:
    columns, sizes = np.array([5, 9]), np.array([0.3, -2.0])
    less = both()[which].less(columns, sizes)
    turn = np.eye(COLUMNS)
    turn[columns, -1] = -sizes
    every = np.arange(COLUMNS)
    np.testing.assert_allclose(less.among(every), turn.T @ expected() @ turn, atol=1e-9)


def test_what_is_fitted_to_one_base_is_made_once() -> None:
    products, base = both()[1], np.array([1, 4])
    calls: list[FloatArray] = []

    def fitted(given: FloatArray) -> FloatArray:
        calls.append(given)
        return np.asarray(given.sum(axis=0))

    for _ in range(2):
        found = products.fit(base, fitted)
    used = np.array([1, 4, COLUMNS - 1])
    np.testing.assert_allclose(found, expected()[:, used[:, None], used].sum(axis=0))
    products.fit(np.array([1, 5]), fitted)
    assert len(calls) == 2
