"""Inner products of columns, block by block; of many columns, as far as they are asked for.

A library of effects has many hundred columns. What a search asks for is a few of their rows (those
of what is fitted), squares, and sums over the blocks. Imported by
`footcal_cli.core.inference.grams`, which says what the columns are.
"""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

MOST_AT_ONCE = 128
"""Columns of which all products are made at once."""


class Products(ABC):
    """``X_bᵀ V_b⁻¹ X_b`` of every block b; the residual is the last column."""

    def __init__(self) -> None:
        self._fits: dict[bytes, FloatArray] = {}

    @property
    @abstractmethod
    def blocks(self) -> int:
        """Number of blocks, B."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of columns, n."""

    @property
    def last(self) -> int:
        """Column of the residual."""
        return self.size - 1

    @abstractmethod
    def part(self, fitted: IntArray, columns: IntArray) -> FloatArray:
        """Products of what is fitted with columns, shape (B, fitted, columns).

        Kept for all columns: what is fitted once is fitted again beside something else.
        """

    @abstractmethod
    def squares(self, columns: IntArray) -> FloatArray:
        """Product of each column with itself, shape (B, columns)."""

    @abstractmethod
    def among(self, columns: IntArray) -> FloatArray:
        """Products of columns with each other, shape (B, columns, columns)."""

    @abstractmethod
    def summed(self, columns: IntArray) -> FloatArray:
        """The same summed over the blocks, shape (columns, columns)."""

    @abstractmethod
    def squared(self, columns: IntArray, weights: FloatArray) -> FloatArray:
        """Products of sums of columns, each there once, with themselves, shape (B, l).

        Parameters
        ----------
        weights
            Of each column in the sums of each block, shape (B, l, columns).
        """

    @abstractmethod
    def of_blocks(self, kept: BoolArray) -> Products:
        """Of some of the blocks, shape (B,)."""

    @abstractmethod
    def less(self, columns: IntArray, sizes: FloatArray) -> Products:
        """With a residual from which columns of given sizes are taken."""

    def fit(self, base: IntArray, fitted: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """What one function makes of the products of a base and the residual, made once.

        Parameters
        ----------
        fitted
            Of products (B, p + 1, p + 1), the residual last.
        """
        key = base.tobytes()
        if key not in self._fits:
            used = np.append(base, self.last)
            self._fits[key] = fitted(self.part(used, used))
        return self._fits[key]

    def with_residual(self, columns: IntArray) -> FloatArray:
        """Products of columns with the residual, shape (B, columns)."""
        return self.part(np.array([self.last]), columns)[:, 0]


class Dense(Products):
    """All of them at hand.

    Parameters
    ----------
    every
        Shape (B, n, n).
    """

    def __init__(self, every: FloatArray) -> None:
        super().__init__()
        self.every = every

    @property
    def blocks(self) -> int:
        """As `Products.blocks`."""
        return int(self.every.shape[0])

    @property
    def size(self) -> int:
        """As `Products.size`."""
        return int(self.every.shape[1])

    def part(self, fitted: IntArray, columns: IntArray) -> FloatArray:
        """As `Products.part`."""
        return np.asarray(self.every[:, fitted[:, None], columns[None, :]])

    def squares(self, columns: IntArray) -> FloatArray:
        """As `Products.squares`."""
        return np.asarray(self.every[:, columns, columns])

    def among(self, columns: IntArray) -> FloatArray:
        """As `Products.among`."""
        return self.part(columns, columns)

    def summed(self, columns: IntArray) -> FloatArray:
        """As `Products.summed`."""
        return np.asarray(self.among(columns).sum(axis=0))

    def squared(self, columns: IntArray, weights: FloatArray) -> FloatArray:
        """As `Products.squared`."""
        return np.asarray(np.einsum("bli,bli->bl", weights @ self.among(columns), weights))

    def of_blocks(self, kept: BoolArray) -> Dense:
        """As `Products.of_blocks`."""
        return Dense(self.every[kept])

    def less(self, columns: IntArray, sizes: FloatArray) -> Dense:
        """As `Products.less`."""
        turn = np.eye(self.size)
        turn[columns, -1] = -sizes
        return Dense(turn.T @ self.every @ turn)


class Lazy(Products):
    """``X_bᵀ X_b − W_bᵀ W_b + K``, made where asked for.

    Parameters
    ----------
    rows
        X of each block, shape (m_b, n) each.
    taken
        W of each block, shape (B, w, n).
    known, at
        K of some columns, shape (p, p), and which.
    """

    def __init__(
        self,
        rows: Sequence[FloatArray],
        taken: FloatArray | None = None,
        known: FloatArray | None = None,
        at: IntArray | None = None,
    ) -> None:
        super().__init__()
        self.rows, self.taken, self.known = rows, taken, known
        self.at = np.empty(0, dtype=np.int64) if at is None else at
        self._kept: dict[int, FloatArray] = {}
        self._sums: dict[bytes, FloatArray] = {}
        self._own: FloatArray | None = None
        self._of: tuple[Lazy, BoolArray] | None = None

    @property
    def blocks(self) -> int:
        """As `Products.blocks`."""
        return len(self.rows)

    @property
    def size(self) -> int:
        """As `Products.size`."""
        return int(self.rows[0].shape[1])

    def part(self, fitted: IntArray, columns: IntArray) -> FloatArray:
        """As `Products.part`."""
        self._keep([int(c) for c in fitted if int(c) not in self._kept])
        if not fitted.size:
            return np.empty((self.blocks, 0, columns.size))
        out = np.empty((self.blocks, fitted.size, columns.size))
        for i, c in enumerate(fitted):
            out[:, i] = self._kept[int(c)][:, columns]
        return out

    def _keep(self, columns: list[int]) -> None:
        """Products of a few columns with all of them, shape (B, n) each."""
        if self._of is not None:
            whole, kept = self._of
            self._kept.update({c: whole._kept[c][kept] for c in columns if c in whole._kept})
            columns = [c for c in columns if c not in self._kept]
        if not columns:
            return
        chosen, every = np.array(columns), np.arange(self.size)
        made = np.stack([x[:, chosen].T @ x for x in self.rows])
        if self.taken is not None:
            made -= self.taken[:, :, chosen].swapaxes(1, 2) @ self.taken
        made += self._of_known(chosen, every)
        self._kept.update(zip(columns, made.swapaxes(0, 1), strict=True))

    def _of_known(self, some: IntArray, others: IntArray) -> FloatArray:
        """K spread over columns, shape (some, others)."""
        if self.known is None:
            return np.zeros((1, 1))
        whole = np.zeros((some.size, others.size))
        (i, k), (j, m) = (np.nonzero(which[:, None] == self.at) for which in (some, others))
        whole[np.ix_(i, j)] = self.known[np.ix_(k, m)]
        return whole

    def squares(self, columns: IntArray) -> FloatArray:
        """As `Products.squares`."""
        if self._own is None:
            self._own = np.stack([np.einsum("ij,ij->j", x, x) for x in self.rows])
            if self.taken is not None:
                self._own -= np.einsum("bij,bij->bj", self.taken, self.taken)
            if self.known is not None:
                self._own[:, self.at] += np.diag(self.known)
        return np.asarray(self._own[:, columns])

    def among(self, columns: IntArray) -> FloatArray:
        """As `Products.among`."""
        out = np.empty((self.blocks, columns.size, columns.size))
        for b, x in enumerate(self.rows):
            mine = x.take(columns, axis=1)
            np.matmul(mine.T, mine, out=out[b])
            if self.taken is not None:
                w = self.taken[b].take(columns, axis=1)
                out[b] -= w.T @ w
        out += self._of_known(columns, columns)
        return out

    def squared(self, columns: IntArray, weights: FloatArray) -> FloatArray:
        """As `Products.squared`, by the sums themselves: no products of columns are made."""
        known = self._of_known(columns, columns)
        whole = np.zeros((weights.shape[1], self.size))
        out = np.empty(weights.shape[:2])
        for b, (x, own) in enumerate(zip(self.rows, weights, strict=True)):
            whole[:, columns] = own
            out[b] = np.sum((whole @ x.T) ** 2, axis=1)
            if self.taken is not None:
                out[b] -= np.sum((whole @ self.taken[b].T) ** 2, axis=1)
            if self.known is not None:
                out[b] += np.einsum("li,li->l", own @ known, own)
        return out

    def summed(self, columns: IntArray) -> FloatArray:
        """As `Products.summed`; of most blocks, all less the others: folds ask for all again."""
        key = columns.tobytes()
        if key not in self._sums:
            whole, kept = self._of or (self, np.ones(self.blocks, dtype=bool))
            if kept.all() or 2 * np.count_nonzero(kept) <= kept.size:
                self._sums[key] = self._added(columns)
            else:
                self._sums[key] = whole.summed(columns) - whole.of_blocks(~kept)._added(columns)
        return self._sums[key].copy()

    def _added(self, columns: IntArray) -> FloatArray:
        total = np.zeros((columns.size, columns.size))
        for x in self.rows:
            mine = x[:, columns]
            total += mine.T @ mine
        if self.taken is not None:
            w = self.taken[:, :, columns].reshape(-1, columns.size)
            total -= w.T @ w
        return np.asarray(total + self.blocks * self._of_known(columns, columns))

    def of_blocks(self, kept: BoolArray) -> Lazy:
        """As `Products.of_blocks`."""
        rows = list(itertools.compress(self.rows, kept))
        taken = None if self.taken is None else self.taken[kept]
        fewer = Lazy(rows, taken, self.known, self.at)
        fewer._of = self, kept
        fewer._own = None if self._own is None else self._own[kept]
        return fewer

    def less(self, columns: IntArray, sizes: FloatArray) -> Lazy:
        """As `Products.less`."""

        def changed(x: FloatArray) -> FloatArray:
            x = x.copy()
            x[..., -1] -= x[..., columns] @ sizes
            return x

        taken = None if self.taken is None else changed(self.taken)
        return Lazy([changed(x) for x in self.rows], taken, self.known, self.at)


def block_products(columns: FloatArray, block: IntArray, blocks: int) -> Products:
    """``X_bᵀ X_b`` of each block's rows.

    Parameters
    ----------
    columns, block
        Shape (m, n), and the block of each row, shape (m,).
    """
    parts = rows_of_blocks(columns, block, blocks)
    if columns.shape[1] > MOST_AT_ONCE:
        return Lazy(parts)
    out = np.empty((blocks, columns.shape[1], columns.shape[1]))
    for b, part in enumerate(parts if columns.shape[1] else ()):
        np.matmul(part.T, part, out=out[b])
    return Dense(out)


def rows_of_blocks(columns: FloatArray, block: IntArray, blocks: int) -> list[FloatArray]:
    """The rows of each block, shape (m_b, n) each; no copy where they stand together."""
    if np.any(block[1:] < block[:-1]):
        order = np.argsort(block, kind="stable")
        columns, block = columns[order], block[order]
    ends = np.searchsorted(block, np.arange(blocks + 1))
    return [columns[start:end] for start, end in itertools.pairwise(ends)]


def partial_out(products: Products, wandering: IntArray, variance: FloatArray) -> Products:
    """``X'V⁻¹X`` by Woodbury: ``X'X − X'Z (D⁻¹ + Z'Z)⁻¹ Z'X``, block by block.

    Parameters
    ----------
    products
        ``X'X``, Z among the columns.
    wandering, variance
        Which columns are Z, and of each its variance, shape (w,); without one it takes out nothing.
    """
    active = wandering[variance > 0]
    if not active.size:
        return products
    every = np.arange(products.size)
    cross = products.part(active, every)
    inner = middle(cross[:, :, active], variance[variance > 0])
    if isinstance(products, Dense):
        taken = cross.swapaxes(1, 2) @ np.linalg.solve(inner, cross)
        return Dense(np.subtract(products.every, taken, out=taken))
    assert isinstance(products, Lazy)
    # (D⁻¹ + Z'Z)⁻¹ = L⁻ᵀ L⁻¹, and W = L⁻¹ Z'X
    return Lazy(products.rows, np.linalg.solve(np.linalg.cholesky(inner), cross))


def middle(square: FloatArray, variance: FloatArray) -> FloatArray:
    """``D⁻¹ + Z'Z`` of each block, shape (B, w, w), from Z'Z."""
    return np.asarray(np.diag(1.0 / variance) + square)


def with_known(products: Products, known: FloatArray, at: IntArray) -> Products:
    """Products to which a precision of some columns is added in every block.

    Parameters
    ----------
    known, at
        Shape (p, p), and of which columns.
    """
    if isinstance(products, Dense):
        more = products.every.copy()
        more[np.ix_(np.arange(products.blocks), at, at)] += known
        return Dense(more)
    assert isinstance(products, Lazy)
    return Lazy(products.rows, products.taken, known, at)
