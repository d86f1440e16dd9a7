"""Models that are linear but for a few shapes: time constants of creep, the reach of a play.

``y = X(s) b + Z u_block + ε`` with s the logarithms of the shapes. For every s the best b follows
by least squares, so that what is left is a function of s alone (variable projection: Golub and
Pereyra, SIAM J. Numer. Anal. 10, 1973), which is searched. Its derivatives by s then stand beside
X, and b and s get one joint covariance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from footcal_cli.core.inference.blocks import (
    BlockFit,
    centring,
    correlation_time,
    fit_blocks,
    whiten_autoregressive,
)
from footcal_cli.core.parameters import FloatArray, IntArray, ParameterSet

LOG_STEP = 1e-3
"""Step of a shape's logarithm in numeric derivatives."""
_REACH = float(np.log(2.5))
"""How far a search goes from the best point of the grid."""
_SIMPLEX = 0.4
_FORBIDDEN = 1e12
_SEEN = 1e-9


@dataclass(frozen=True)
class SeparableFit:
    """A fitted model.

    Parameters
    ----------
    log_shapes
        s, shape (k,).
    correlation_s
        How long the noise persists; 0: rows are independent.
    linear
        Regression at these shapes.
    covariance, dof
        Of b and s, shapes (p + k, p + k) and (p + k,).
    """

    log_shapes: FloatArray
    correlation_s: float
    linear: BlockFit
    covariance: FloatArray
    dof: FloatArray


@dataclass(frozen=True)
class Separable:
    """A model and its rows, in order of time within each block.

    Parameters
    ----------
    design
        X(s), shape (n, p).
    target, time_s, block
        y, stamps and the session of each row, shape (n,).
    shapes
        Priors and bounds of s.
    starts
        Points of a grid, each (k,).
    ascending
        Positions of shapes that must ascend and stay `apart`: a sum of two creeps is symmetric.
    shared
        Z as in `fit_blocks`; a block then has an offset of its own in the search too.
    kept
        Unless what tells the shapes apart is the offsets of the blocks themselves.
    """

    design: Callable[[FloatArray], FloatArray]
    target: FloatArray
    time_s: FloatArray
    block: IntArray
    shapes: ParameterSet
    starts: Sequence[FloatArray]
    ascending: Sequence[int] = ()
    apart: float = 0.0
    shared: FloatArray | None = None
    kept: bool = False

    def fit(
        self, start: FloatArray | None = None, correlation_s: float | None = None
    ) -> SeparableFit:
        """Search the shapes, then fit all together.

        Parameters
        ----------
        start
            Shapes to start from; the best point of the grid where None.
        correlation_s
            Known persistence of the noise; None: found from what a first fit leaves.
        """
        if correlation_s is None:
            start = self._search(start, 0.0)
            left = _rest(*self._rows(start, 0.0))
            if self.kept:
                left = self._centred(left[:, None])[:, 0]
            correlation_s = correlation_time(left, self.time_s, self.block)
            log_shapes = self._search(start, correlation_s) if correlation_s > 0.0 else start
        else:
            log_shapes = self._search(start, correlation_s)
        return self.together(log_shapes, correlation_s)

    def left(self, log_shapes: FloatArray, correlation_s: float) -> FloatArray:
        """What the best coefficients leave of the whitened rows, shape (n,)."""
        rows, target = self._rows(log_shapes, correlation_s)
        return _rest(rows / np.maximum(np.linalg.norm(rows, axis=0), 1e-300), target)

    def _rows(self, log_shapes: FloatArray, correlation_s: float) -> tuple[FloatArray, FloatArray]:
        """Design and target, white, and without the offset of their block where it has one."""
        rows, target = self._white(self.design(log_shapes), correlation_s)
        if self.shared is None or self.kept:
            return rows, target
        return self._centred(rows), self._centred(target[:, None])[:, 0]

    @cached_property
    def _centred(self) -> Callable[[FloatArray], FloatArray]:
        return centring(self.block)

    def _white(self, rows: FloatArray, correlation_s: float) -> tuple[FloatArray, FloatArray]:
        return whiten_autoregressive(rows, self.target, self.time_s, self.block, correlation_s)

    def _search(self, start: FloatArray | None, correlation_s: float) -> FloatArray:
        """Shapes of the smallest ``(n/2) ln RSS`` plus prior, shape (k,).

        Without derivatives: the reach of a play makes the residual kinked.
        """
        if not len(self.shapes):
            return np.zeros(0)

        def cost(log_shapes: FloatArray) -> float:
            return self._cost(log_shapes, correlation_s)

        if start is None:
            start = min(self.starts, key=cost)
        if start.size == 1:
            bounds = float(start[0] - _REACH), float(start[0] + _REACH)
            found = minimize_scalar(
                lambda s: cost(np.array([s])), bounds=bounds, options={"xatol": 1e-3}
            )
            return np.array([found.x]) if found.fun <= cost(start) else start
        refined = minimize(
            cost,
            start,
            method="Nelder-Mead",
            options={
                "maxfev": 60 * start.size,
                "xatol": 2e-3,
                "fatol": 1e-4,
                "initial_simplex": np.vstack([start, start + _SIMPLEX * np.eye(start.size)]),
            },
        )
        return np.asarray(refined.x, dtype=np.float64)

    @cached_property
    def _prior(self) -> FloatArray:
        """Lower and upper bound, middle and sd of each shape, shape (4, k)."""
        rows = [(p.lower, p.upper, p.value, p.sd) for p in self.shapes]
        return np.array(rows, dtype=np.float64).T

    def _cost(self, log_shapes: FloatArray, correlation_s: float) -> float:
        apart = np.diff(log_shapes[list(self.ascending)]) > self.apart
        lower, upper, middle, sd = self._prior
        if not apart.all() or np.any((log_shapes < lower) | (log_shapes > upper)):
            return _FORBIDDEN
        left = self.left(log_shapes, correlation_s)
        away = (log_shapes - middle) / sd
        prior = 0.5 * float(np.sum(away**2))
        return 0.5 * left.size * float(np.log(left @ left + 1e-300)) + prior

    def together(
        self,
        log_shapes: FloatArray,
        correlation_s: float,
        regression: Callable[[FloatArray], BlockFit] | None = None,
    ) -> SeparableFit:
        """Coefficients at known shapes, and their covariance with that of the shapes.

        Parameters
        ----------
        log_shapes, correlation_s
            As found before.
        regression
            Of the target on a design (n, q); with the noise of this model where None.
        """

        def solve(design: FloatArray) -> BlockFit:
            return regression(design) if regression else self._regression(design, correlation_s)

        design = self.design(log_shapes)
        fit = solve(design)
        p, k = design.shape[1], log_shapes.size
        bends = np.zeros((design.shape[0], k))
        for i, step in enumerate(LOG_STEP * np.eye(k)):
            moved = self.design(log_shapes + step) - self.design(log_shapes - step)
            bends[:, i] = moved @ fit.coefficients / (2.0 * LOG_STEP)
        seen = np.linalg.norm(bends, axis=0) > _SEEN * np.linalg.norm(self.target)
        spread = fit
        if seen.any():
            spread = solve(np.column_stack([design, bends[:, seen]]))
        at = np.concatenate([np.arange(p), p + np.flatnonzero(seen)])
        covariance = np.zeros((p + k, p + k))
        covariance[np.ix_(at, at)] = spread.covariance
        dof = np.full(p + k, float(spread.dof.max()))
        dof[at] = spread.dof
        prior_sd = np.array([shape.sd for shape in self.shapes])
        return SeparableFit(
            log_shapes, correlation_s, fit, _with_prior(covariance, prior_sd, at[p:], p), dof
        )

    def _regression(self, design: FloatArray, correlation_s: float) -> BlockFit:
        shared = np.ones((len(design), 1)) if self.shared is None else self.shared
        rows, target = self._white(np.column_stack([design, shared]), correlation_s)
        block = None if self.shared is None else self.block
        p = design.shape[1]
        return fit_blocks(rows[:, :p], target, block, rows[:, p:])


def _rest(rows: FloatArray, target: FloatArray) -> FloatArray:
    return np.asarray(target - rows @ np.linalg.lstsq(rows, target, rcond=None)[0])


def _with_prior(
    covariance: FloatArray, prior_sd: FloatArray, seen: IntArray, first: int
) -> FloatArray:
    """Joint covariance after the priors of the shapes, which stand from `first` on.

    A shape that no row depends on keeps its prior alone.
    """
    covariance = covariance.copy()
    unseen = np.setdiff1d(np.arange(first, len(covariance)), seen)
    covariance[unseen, unseen] = prior_sd[unseen - first] ** 2
    at = seen[np.isfinite(prior_sd[seen - first])]
    if not at.size:
        return covariance
    prior = np.diag(prior_sd[at - first] ** 2)
    gain = np.linalg.solve(covariance[np.ix_(at, at)] + prior, covariance[at]).T
    kept = np.eye(len(covariance))
    kept[:, at] -= gain
    # Joseph's form: variances stay positive where the plain difference loses all digits
    return np.asarray(kept @ covariance @ kept.T + gain @ prior @ gain.T)
